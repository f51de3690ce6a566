//! The margins of points: how far their orbits stay from the event.

use super::{Event, Question, Refused};
use crate::model::variable::Place;
use crate::model::{Coordinates, Model};

/// The margin of a point at which no orbit can start.
const NO_ORBIT: f64 = f64::INFINITY;

/// The margins of points, and how many orbits they took.
pub(super) struct Margins {
    /// Zero or less where the event happens; in units of the clearance.
    pub values: Vec<f64>,
    /// Number of orbits.
    pub orbits: usize,
}

impl<M: Model, const N: usize> Question<M, N> {
    /// The margins of these points in standardised coordinates.
    pub(super) fn margins(&self, points: &[[f64; N]]) -> Result<Margins, Refused> {
        let starting: Vec<usize> = (0..points.len()).filter(|&i| self.allows(&points[i])).collect();
        let mut columns = vec![Vec::with_capacity(starting.len()); M::State::<f64>::COUNT];
        for &i in &starting {
            let variables = self.gaussian.point(points[i]);
            let state = self.flow.model.state(0.0, Coordinates::from_fn(|k| variables[k]));
            columns.iter_mut().enumerate().for_each(|(k, column)| column.push(state.component(k)));
        }
        let found = match self.event {
            Event::Ever => self.nearest(&mut columns),
            Event::AtEnd => self.at_end(&mut columns),
        };
        let mut values = vec![NO_ORBIT; points.len()];
        for (&i, margin) in starting.iter().zip(found) {
            if margin.is_nan() {
                let variables = self.gaussian.point(points[i]);
                let place = Place::new(M::VARIABLES, |k| variables[k]);
                return Err(Refused::Lost { place, years: self.years });
            }
            values[i] = margin;
        }
        Ok(Margins { values, orbits: starting.len() })
    }

    /// The least clearance of each orbit, less the critical one. Whether it has passed is read off the series of the
    /// integrator; the least clearance is that at a few places of each step.
    fn nearest(&self, columns: &mut [Vec<f64>]) -> Vec<f64> {
        let count = columns[0].len();
        let (mut times, mut lowest) = (vec![f64::INFINITY; count], vec![f64::INFINITY; count]);
        let interval = (0.0, self.years);
        self.flow.carry_approaching(&mut slices(columns), interval, self.critical, &mut times, &mut lowest);
        let critical = self.flow.model.critical_clearance(self.critical);
        let margin = |(time, lowest): (&f64, &f64)| match time {
            time if time.is_nan() => f64::NAN,
            // An orbit that was lost after its passage counts as one that just passes.
            time if time.is_finite() => {
                if lowest.is_nan() {
                    0.0
                } else {
                    (lowest - critical).min(0.0)
                }
            }
            _ => (lowest - critical).max(f64::MIN_POSITIVE),
        };
        times.iter().zip(&lowest).map(margin).collect()
    }

    /// The clearance of each orbit at the end, less the critical one.
    fn at_end(&self, columns: &mut [Vec<f64>]) -> Vec<f64> {
        self.flow.carry_where_possible(&mut slices(columns), 0.0, self.years);
        let critical = self.flow.model.critical_clearance(self.critical);
        let margin = |i: usize| {
            let state = M::State::<f64>::from_fn(|k| columns[k][i]);
            self.flow.model.clearance(state) - critical
        };
        (0..columns[0].len()).map(margin).collect()
    }
}

fn slices(columns: &mut [Vec<f64>]) -> Vec<&mut [f64]> {
    columns.iter_mut().map(Vec::as_mut_slice).collect()
}

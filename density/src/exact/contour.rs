//! One closed orbit, followed once round from the point at which it is least eccentric.
//!
//! Time along the orbit is measured by the angle that the Sun moves, `θ = n_sun t` \[rad\]. It runs from `θ = 0` at the
//! least eccentric point to half a period at the most eccentric one; the other half is the mirror image. The
//! integrator's own Taylor series are kept, so a state at any time is a polynomial, and the state `t` years later is on
//! the same orbit at `θ + n_sun t`, taken modulo the period. The cost does not depend on `t`.

use crate::flow::Flow;
use crate::flow::record::Step;
use crate::model::earth::SUN_MEAN_MOTION;
use crate::model::plane::{PlanarHamiltonian, State};

/// Largest number of steps for half an orbit; an orbit within rounding of a separatrix takes a few hundred.
const MOST_STEPS: usize = 3000;
/// Largest number of years for which half an orbit is followed.
const MOST_YEARS: f64 = 1e6;
/// Number of parts of a step; an orbit crosses the axis at most once in each part.
const PARTS: u32 = 16;

/// A closed orbit.
#[derive(Debug, Clone)]
pub(crate) struct Contour {
    /// Half its period \[rad\].
    pub half: f64,
    /// Start of each step \[rad\], ascending from 0.
    starts: Vec<f64>,
    steps: Vec<Step>,
}

/// An orbit that is being traced.
struct Trace {
    place: usize,
    state: State,
    years: f64,
    starts: Vec<f64>,
    steps: Vec<Step>,
}

impl Contour {
    /// The orbits through `(0, q)`, where they are least eccentric; `None` for one that does not close within the disc
    /// `e < 1` and [`MOST_YEARS`].
    pub(crate) fn trace<M: PlanarHamiltonian>(flow: &Flow<M>, points: &[f64]) -> Vec<Option<Self>> {
        let mut contours: Vec<Option<Self>> = vec![None; points.len()];
        let mut under_way: Vec<Trace> =
            points.iter().enumerate().map(|(k, &q)| Trace::new(&flow.model, k, q)).collect();
        while !under_way.is_empty() {
            let states: Vec<State> = under_way.iter().map(|trace| trace.state).collect();
            let years: Vec<f64> = under_way.iter().map(|trace| trace.years).collect();
            let recorded = flow.record(&states, &years);
            let mut next = Vec::new();
            for (mut trace, recorded) in under_way.into_iter().zip(recorded) {
                let Some((steps, end)) = recorded else { continue };
                match trace.take(steps, end) {
                    Some(half) => {
                        let Trace { place, starts, steps, .. } = trace;
                        contours[place] = Some(Self { half, starts, steps });
                    }
                    None if trace.may_go_on() => next.push(trace),
                    None => {}
                }
            }
            under_way = next;
        }
        contours
    }

    /// The period \[rad\].
    pub(crate) fn period(&self) -> f64 {
        2.0 * self.half
    }

    /// The time `theta` on the orbit, between minus and plus half a period.
    pub(crate) fn wrap(&self, theta: f64) -> f64 {
        let turns = (theta / self.period()).round();
        (theta - turns * self.period()).clamp(-self.half, self.half)
    }

    /// The state at a time between minus and plus half a period.
    #[inline]
    pub(crate) fn at(&self, theta: f64) -> State {
        let time = theta.abs().min(self.half);
        let step = self.starts.partition_point(|&start| start <= time).max(1) - 1;
        let State { x1, x2 } = self.steps[step].at(time - self.starts[step]);
        State { x1: if theta < 0.0 { -x1 } else { x1 }, x2 }
    }

    /// The ends of the integrator's steps on the first half, including 0 and half a period. Between two of them, a rule
    /// of eight points resolves every smooth function of the state well.
    pub(crate) fn knots(&self) -> impl Iterator<Item = f64> + '_ {
        self.starts.iter().copied().filter(|&start| start < self.half).chain([self.half])
    }

    /// The time between 0 and half a period at which the eccentricity grows beyond `e`; `None` if it never does, 0 if
    /// the eccentricity is never below `e`.
    pub(crate) fn rises_above(&self, e: f64) -> Option<f64> {
        let below = |theta: f64| {
            let State { x1, x2 } = self.at(theta);
            x1 * x1 + x2 * x2 < e * e
        };
        if !below(0.0) {
            return Some(0.0);
        }
        (!below(self.half)).then(|| {
            let (mut low, mut high) = (0.0_f64, self.half);
            while low.midpoint(high) > low && low.midpoint(high) < high {
                let middle = low.midpoint(high);
                if below(middle) { low = middle } else { high = middle }
            }
            high
        })
    }
}

impl Trace {
    fn new(model: &impl PlanarHamiltonian, place: usize, q: f64) -> Self {
        let state = State { x1: 0.0, x2: q };
        let years = 0.5 / model.pace(state);
        Self { place, state, years, starts: Vec::new(), steps: Vec::new() }
    }

    /// Appends the recorded steps; returns half the period if the orbit has come to the other side of the axis.
    fn take(&mut self, steps: Vec<Step>, end: State) -> Option<f64> {
        for step in steps {
            let start = self.starts.last().zip(self.steps.last()).map_or(0.0, |(start, last)| start + last.length);
            let crossing = crossing(&step);
            self.starts.push(start);
            self.steps.push(step);
            if let Some(time) = crossing {
                return Some(start + time);
            }
        }
        (self.state, self.years) = (end, 2.0 * self.years);
        None
    }

    fn may_go_on(&self) -> bool {
        self.years < MOST_YEARS && self.steps.len() < MOST_STEPS
    }
}

/// The time within a step at which `x1` falls to zero, if it does.
fn crossing(step: &Step) -> Option<f64> {
    let time = |k: u32| step.length * f64::from(k) / f64::from(PARTS);
    let part = (1..=PARTS).find(|&k| step.at(time(k)).x1 <= 0.0)?;
    let (mut low, mut high) = (time(part - 1), time(part));
    while low.midpoint(high) > low && low.midpoint(high) < high {
        let middle = low.midpoint(high);
        if step.at(middle).x1 > 0.0 { low = middle } else { high = middle }
    }
    Some(low.midpoint(high))
}

/// The angle `n_sun t` \[rad\] for a time in years.
pub(crate) fn angle_of(years: f64) -> f64 {
    SUN_MEAN_MOTION * years
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::planar::SrpJ2;

    #[test]
    fn an_orbit_is_where_the_flow_takes_it_after_any_number_of_periods() {
        let flow = Flow::new(SrpJ2 { radiation: 0.15, oblateness: 0.40921 });
        for q in [-0.3, -0.01, 0.2, 0.52, 0.8] {
            let contour = Contour::trace(&flow, &[q]).remove(0).unwrap();
            for years in [0.1, 1.0, 7.3] {
                let there = contour.at(contour.wrap(0.4 + angle_of(years)));
                let start = contour.at(0.4);
                let flown = flow.advance_one(start, years).unwrap();
                assert!((there.x1 - flown.x1).hypot(there.x2 - flown.x2) < 1e-10, "{q} {years} {there:?} {flown:?}");
            }
        }
    }

    #[test]
    fn an_orbit_is_its_own_mirror_image() {
        let flow = Flow::new(SrpJ2 { radiation: 0.15, oblateness: 0.40921 });
        let contour = Contour::trace(&flow, &[0.1]).remove(0).unwrap();
        let (start, end) = (contour.at(-0.5), contour.at(0.5));
        let flown = flow.advance_one(start, 1.0 / SUN_MEAN_MOTION).unwrap();
        assert!((flown.x1 - end.x1).hypot(flown.x2 - end.x2) < 1e-12);
    }

    #[test]
    fn without_oblateness_the_period_is_that_of_the_rigid_rotation() {
        let flow = Flow::new(SrpJ2 { radiation: 0.3, oblateness: 0.0 });
        let contour = Contour::trace(&flow, &[0.05]).remove(0).unwrap();
        let period = SUN_MEAN_MOTION / (1.0 + 0.3f64 * 0.3).sqrt();
        assert!((contour.period() - period).abs() < 1e-11, "{} {period}", contour.period());
        assert!(Contour::trace(&flow, &[-0.95])[0].is_none(), "it leaves e < 1");
    }

    #[test]
    fn the_eccentricity_rises_above_a_value_once_in_a_half() {
        let flow = Flow::new(SrpJ2 { radiation: 0.15, oblateness: 0.40921 });
        let contour = Contour::trace(&flow, &[-0.1]).remove(0).unwrap();
        let time = contour.rises_above(0.4).unwrap();
        assert!((contour.at(time).eccentricity() - 0.4).abs() < 1e-13);
        assert_eq!(contour.rises_above(0.05), Some(0.0));
        assert_eq!(contour.rises_above(0.99), None);
    }
}

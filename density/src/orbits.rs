//! A set of orbits that moves from `t = 0` through the snapshot times.

use rayon::prelude::*;

use crate::flow::{Escaped, Flow, Loss, Passages};
use crate::model::planar::SrpJ2;
use crate::model::plane::{PlanarHamiltonian, State};
use crate::model::variable::Place;
use crate::model::{Coordinates, Model};

/// Number of orbits that a thread reads out at a time.
const CHUNK: usize = 4096;

/// Orbits that share a flow and a clock.
#[derive(Debug, Clone, PartialEq)]
pub struct Orbits<M = SrpJ2> {
    /// The flow that moves them.
    pub flow: Flow<M>,
    /// Their states, one column per coordinate.
    columns: Vec<Vec<f64>>,
    time: f64,
}

/// An orbit could not be followed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("sample {index}, which started at {place}, {why} between t = {from} and {to} yr")]
pub struct LostOrbit {
    /// Index of the orbit.
    pub index: usize,
    /// Why it could not be followed.
    pub why: Loss,
    /// Where the orbit was at `t = 0`.
    pub place: Place,
    /// Start of the interval in which it was lost \[yr\].
    pub from: f64,
    /// End of that interval \[yr\].
    pub to: f64,
}

impl LostOrbit {
    /// The same error for a larger set, in which this set starts at number `first`.
    pub fn counted_from(self, first: usize) -> Self {
        Self { index: first + self.index, ..self }
    }
}

impl<M: Model> Orbits<M> {
    /// Orbits in the states at `t = 0` whose coordinates are in these columns.
    ///
    /// # Panics
    /// If there is not one column for every coordinate, or if they differ in length.
    pub fn from_columns(flow: Flow<M>, columns: Vec<Vec<f64>>) -> Self {
        assert_eq!(columns.len(), M::State::<f64>::COUNT, "one column for every coordinate");
        assert!(columns.iter().all(|column| column.len() == columns[0].len()), "columns of the same length");
        Self { flow, columns, time: 0.0 }
    }

    /// Orbits at `t = 0` whose variables are in these columns.
    ///
    /// # Panics
    /// If there is not one column for every variable, or if they differ in length.
    pub fn from_variables(flow: Flow<M>, variables: &[&[f64]]) -> Self {
        assert_eq!(variables.len(), M::VARIABLES.len(), "one column for every variable");
        let state = |i: usize| flow.model.state(0.0, Coordinates::from_fn(|k| variables[k][i]));
        let mut columns = vec![Vec::with_capacity(variables[0].len()); M::State::<f64>::COUNT];
        for state in (0..variables[0].len()).map(state) {
            columns.iter_mut().enumerate().for_each(|(k, column)| column.push(state.component(k)));
        }
        Self::from_columns(flow, columns)
    }

    /// Number of orbits.
    pub fn len(&self) -> usize {
        self.columns[0].len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The states, one column per coordinate.
    pub fn columns(&self) -> &[Vec<f64>] {
        &self.columns
    }

    /// Moves all orbits to `time` \[yr\].
    ///
    /// # Errors
    /// [`LostOrbit`] names the first orbit that cannot be followed; the set is then of no use.
    pub fn advance_to(&mut self, time: f64) -> Result<(), LostOrbit> {
        let from = self.time;
        self.time = time;
        let moved = self.flow.carry(&mut slices(&mut self.columns), from, time);
        moved.map_err(|escaped| self.trace(escaped, from, time))
    }

    /// Like [`Orbits::advance_to`], and notes when each orbit's re-entry variable first reaches `critical` or goes
    /// beyond it, see [`Flow::carry_watching`].
    ///
    /// # Errors
    /// As [`Orbits::advance_to`].
    ///
    /// # Panics
    /// If there is not one passage for every orbit.
    pub fn advance_watching<T: Copy + PartialEq + Send + Sync>(
        &mut self,
        time: f64,
        critical: f64,
        passages: Passages<'_, T>,
    ) -> Result<(), LostOrbit> {
        let from = self.time;
        self.time = time;
        let moved = self.flow.carry_watching(&mut slices(&mut self.columns), (from, time), critical, passages);
        moved.map_err(|escaped| self.trace(escaped, from, time))
    }

    /// The error about an orbit that escaped while something was read out at `time` \[yr\].
    pub(crate) fn lost(&self, escaped: Escaped, time: f64) -> LostOrbit {
        self.trace(escaped, time, time)
    }

    /// Follows an orbit that escaped back to where it started.
    fn trace(&self, Escaped { index, why, place, .. }: Escaped, from: f64, to: f64) -> LostOrbit {
        let model = &self.flow.model;
        let before = model.state(from, Coordinates::from_fn(|k| place.values[k]));
        let start = model.read_out(0.0, self.flow.carry_one(before, from, 0.0).unwrap_or(before));
        LostOrbit { index, why, place: Place::new(M::VARIABLES, |k| start.component(k)), from, to }
    }

    /// Writes the variables of all orbits, one column per variable.
    ///
    /// # Panics
    /// If there is not one column for every variable, or one is not as long as there are orbits.
    pub fn read_out_columns(&self, variables: &mut [&mut [f64]]) {
        assert_eq!(variables.len(), M::VARIABLES.len(), "one column for every variable");
        assert!(variables.iter().all(|column| column.len() == self.len()), "room for every orbit");
        let mut pieces: Vec<Vec<&mut [f64]>> = (0..self.len().div_ceil(CHUNK)).map(|_| Vec::new()).collect();
        for column in variables {
            pieces.iter_mut().zip(column.chunks_mut(CHUNK)).for_each(|(piece, chunk)| piece.push(chunk));
        }
        pieces.par_iter_mut().enumerate().for_each(|(piece, columns)| {
            for i in 0..columns[0].len() {
                let state = Coordinates::from_fn(|k| self.columns[k][piece * CHUNK + i]);
                let values = self.flow.model.read_out(self.time, state);
                columns.iter_mut().enumerate().for_each(|(k, column)| column[i] = values.component(k));
            }
        });
    }
}

/// Columns as slices.
fn slices(columns: &mut [Vec<f64>]) -> Vec<&mut [f64]> {
    columns.iter_mut().map(Vec::as_mut_slice).collect()
}

impl<M: PlanarHamiltonian> Orbits<M> {
    /// Orbits in the states `(x1[i], x2[i])` at `t = 0`.
    pub fn new(flow: Flow<M>, x1: Vec<f64>, x2: Vec<f64>) -> Self {
        Self::from_columns(flow, vec![x1, x2])
    }

    /// Orbits at `(phi[i], e[i])` at `t = 0`.
    pub fn from_polar(flow: Flow<M>, phi: &[f64], e: &[f64]) -> Self {
        Self::from_variables(flow, &[phi, e])
    }

    /// `e sin(phi)` of each orbit.
    pub fn x1(&self) -> &[f64] {
        &self.columns[0]
    }

    /// `e cos(phi)` of each orbit.
    pub fn x2(&self) -> &[f64] {
        &self.columns[1]
    }

    /// Writes solar angles, in `[0, 2π)` \[rad\], and eccentricities.
    ///
    /// # Panics
    /// If a slice is not as long as there are orbits.
    pub fn read_out(&self, phi: &mut [f64], e: &mut [f64]) {
        assert!(phi.len() == self.len() && e.len() == self.len(), "room for every orbit");
        let chunks = phi.par_chunks_mut(CHUNK).zip(e.par_chunks_mut(CHUNK));
        let states = self.x1().par_chunks(CHUNK).zip(self.x2().par_chunks(CHUNK));
        chunks.zip(states).for_each(|((phi, e), (x1, x2))| {
            for (((phi, e), &x1), &x2) in phi.iter_mut().zip(e).zip(x1).zip(x2) {
                let state = State { x1, x2 };
                *phi = state.solar_angle();
                *e = state.eccentricity();
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lost_orbit_is_named_by_where_it_started() {
        // Without oblateness the flow turns (e, sqrt(1-e²)) about an axis. For an orbit that starts circular, e peaks
        // at 2C/(1+C²); for one that starts at e = 0.6 and phi = 0, it passes 1 when C = 3.
        let flow = Flow::new(SrpJ2 { radiation: 3.0, oblateness: 0.0 });
        let mut orbits = Orbits::from_polar(flow, &[0.3, 0.0], &[0.1, 0.6]);
        let lost = (1..100).find_map(|k| orbits.advance_to(0.005 * f64::from(k)).err()).expect("one escapes");
        assert!(lost.index < 2);
        let start = [(0.3, 0.1), (0.0, 0.6)][lost.index];
        let [phi, e, ..] = lost.place.values;
        assert!((phi - start.0).abs() < 1e-9 && (e - start.1).abs() < 1e-9, "{lost}");
    }

    #[test]
    fn read_out_is_the_inverse_of_the_polar_start() {
        let flow = Flow::new(SrpJ2 { radiation: 0.15, oblateness: 0.4 });
        let (phi, e) = ([0.1, 3.0, 6.2], [0.1, 0.5, 0.9]);
        let (mut phi_out, mut e_out) = ([0.0; 3], [0.0; 3]);
        Orbits::from_polar(flow, &phi, &e).read_out(&mut phi_out, &mut e_out);
        for i in 0..3 {
            assert!((phi[i] - phi_out[i]).abs() < 1e-14 && (e[i] - e_out[i]).abs() < 1e-15);
        }
    }
}

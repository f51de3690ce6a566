//! A set of orbits on their way from `t = 0` through the snapshot times.

use rayon::prelude::*;

use crate::dynamics::State;
use crate::flow::{Escaped, Flow, Loss, Passages};

/// Orbits that a thread reads out at a time.
const CHUNK: usize = 4096;

/// Orbits that share a flow and a clock.
#[derive(Debug, Clone, PartialEq)]
pub struct Orbits {
    /// What moves them.
    pub flow: Flow,
    /// `e sin(phi)` of each.
    pub x1: Vec<f64>,
    /// `e cos(phi)` of each.
    pub x2: Vec<f64>,
    time: f64,
}

/// An orbit could not be followed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("sample {index}, which started at phi = {phi} rad, e = {e}, {why} between t = {from} and {to} yr")]
pub struct LostOrbit {
    /// Which orbit.
    pub index: usize,
    /// Why.
    pub why: Loss,
    /// Its solar angle at `t = 0` \[rad\].
    pub phi: f64,
    /// Its eccentricity at `t = 0`.
    pub e: f64,
    /// Start of the interval in which it was lost \[yr\].
    pub from: f64,
    /// End of that interval \[yr\].
    pub to: f64,
}

impl LostOrbit {
    /// The same of a part of a larger set that starts at number `first` of it.
    pub fn counted_from(self, first: usize) -> Self {
        Self { index: first + self.index, ..self }
    }
}

impl Orbits {
    /// Orbits in the states `(x1[i], x2[i])` at `t = 0`.
    pub fn new(flow: Flow, x1: Vec<f64>, x2: Vec<f64>) -> Self {
        Self { flow, x1, x2, time: 0.0 }
    }

    /// Orbits at `(phi[i], e[i])` at `t = 0`.
    pub fn from_polar(flow: Flow, phi: &[f64], e: &[f64]) -> Self {
        let states = phi.iter().zip(e).map(|(&phi, &e)| State::from_polar(phi, e));
        let (x1, x2) = states.map(|state| (state.x1, state.x2)).unzip();
        Self::new(flow, x1, x2)
    }

    /// Number of orbits.
    pub fn len(&self) -> usize {
        self.x1.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.x1.is_empty()
    }

    /// Moves all to `time` \[yr\].
    ///
    /// # Errors
    /// [`LostOrbit`] names the first that cannot be followed; the set is then of no use.
    pub fn advance_to(&mut self, time: f64) -> Result<(), LostOrbit> {
        let from = self.time;
        self.time = time;
        self.flow.advance(&mut self.x1, &mut self.x2, time - from).map_err(|escaped| self.trace(escaped, from, time))
    }

    /// As [`Orbits::advance_to`], and notes when each orbit first has `e >= critical_e`, see [`Flow::advance_watching`].
    ///
    /// # Errors
    /// As [`Orbits::advance_to`].
    ///
    /// # Panics
    /// If there is not one passage for every orbit.
    pub fn advance_watching<T: Copy + PartialEq + Send + Sync>(
        &mut self,
        time: f64,
        critical_e: f64,
        passages: Passages<'_, T>,
    ) -> Result<(), LostOrbit> {
        let from = self.time;
        self.time = time;
        let moved = self.flow.advance_watching(&mut self.x1, &mut self.x2, (from, time), critical_e, passages);
        moved.map_err(|escaped| self.trace(escaped, from, time))
    }

    /// Follows an orbit that escaped back to where it started.
    fn trace(&self, Escaped { index, why, phi, e, .. }: Escaped, from: f64, to: f64) -> LostOrbit {
        let before = State::from_polar(phi, e);
        let start = self.flow.advance_one(before, -from).unwrap_or(before);
        LostOrbit { index, why, phi: start.solar_angle(), e: start.eccentricity(), from, to }
    }

    /// Writes solar angles, in `[0, 2π)` \[rad\], and eccentricities.
    ///
    /// # Panics
    /// If a slice is not as long as there are orbits.
    pub fn read_out(&self, phi: &mut [f64], e: &mut [f64]) {
        assert!(phi.len() == self.len() && e.len() == self.len(), "room for every orbit");
        let chunks = phi.par_chunks_mut(CHUNK).zip(e.par_chunks_mut(CHUNK));
        let states = self.x1.par_chunks(CHUNK).zip(self.x2.par_chunks(CHUNK));
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
    use crate::dynamics::Force;

    #[test]
    fn a_lost_orbit_is_named_by_where_it_started() {
        // Without oblateness the flow turns (e, sqrt(1-e²)) about an axis; from the circular orbit e peaks at
        // 2C/(1+C²), and from e = 0.6 at phi = 0 it passes 1 when C = 3.
        let flow = Flow::new(Force { radiation: 3.0, oblateness: 0.0 });
        let mut orbits = Orbits::from_polar(flow, &[0.3, 0.0], &[0.1, 0.6]);
        let lost = (1..100).find_map(|k| orbits.advance_to(0.005 * f64::from(k)).err()).expect("one escapes");
        assert!(lost.index < 2);
        let start = [(0.3, 0.1), (0.0, 0.6)][lost.index];
        assert!((lost.phi - start.0).abs() < 1e-9 && (lost.e - start.1).abs() < 1e-9, "{lost}");
    }

    #[test]
    fn read_out_is_the_inverse_of_the_polar_start() {
        let flow = Flow::new(Force { radiation: 0.15, oblateness: 0.4 });
        let (phi, e) = ([0.1, 3.0, 6.2], [0.1, 0.5, 0.9]);
        let (mut phi_out, mut e_out) = ([0.0; 3], [0.0; 3]);
        Orbits::from_polar(flow, &phi, &e).read_out(&mut phi_out, &mut e_out);
        for i in 0..3 {
            assert!((phi[i] - phi_out[i]).abs() < 1e-14 && (e[i] - e_out[i]).abs() < 1e-15);
        }
    }
}

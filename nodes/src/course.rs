//! Orbits on their way through the snapshots of a scenario.

use density::orbits::Orbits;
use density::problem::Problem;

use crate::failure::Failure;

/// Orbits and the times they have to reach.
#[derive(Debug)]
pub struct Course {
    /// The orbits.
    pub orbits: Orbits,
    times: Vec<f64>,
}

impl Course {
    /// The course of `orbits` through the snapshots of `problem`.
    pub fn new(orbits: Orbits, problem: &Problem) -> Self {
        Self { orbits, times: problem.times.clone() }
    }

    /// Moves the orbits to snapshot `index` and returns how many they are.
    ///
    /// # Errors
    /// [`Failure::LostOrbit`] names the orbit that cannot be followed.
    pub fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        self.orbits.advance_to(self.times[index])?;
        Ok(self.orbits.len())
    }
}

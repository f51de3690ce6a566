//! Orbits on their way through the snapshots of a scenario.

use density::model::registry::Planar;
use density::orbits::Orbits;
use density::problem::Problem;

use kit::failure::Failure;

/// Orbits and the times they have to reach.
#[derive(Debug)]
pub struct Course {
    /// The orbits.
    pub orbits: Orbits<Planar>,
    first: usize,
    times: Vec<f64>,
}

impl Course {
    /// The course of `orbits`, numbered from `first`, through the snapshots of `problem`.
    pub fn new(orbits: Orbits<Planar>, first: usize, problem: &Problem<Planar>) -> Self {
        Self { orbits, first, times: problem.times.clone() }
    }

    /// Moves the orbits to snapshot `index` and returns the number of orbits.
    ///
    /// # Errors
    /// [`Failure::LostOrbit`] names the orbit that cannot be followed.
    pub fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        self.orbits.advance_to(self.times[index]).map_err(|lost| lost.counted_from(self.first))?;
        Ok(self.orbits.len())
    }
}

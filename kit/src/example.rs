//! A small scenario for tests and examples.

use density::grid::{Axis, Grid};
use density::model::planar::SrpJ2;
use density::model::registry::Planar;
use density::problem::{InitialGaussian, Problem};

use crate::assignment::{Assignment, Plane};

/// A small cloud in the plane, with snapshots at the start and half a year later.
pub fn problem() -> Problem<Planar> {
    Problem {
        model: SrpJ2 { radiation: 0.15, oblateness: 0.4 }.into(),
        initial: InitialGaussian { mean_phi: 2.0, mean_e: 0.1, sigma_phi: 0.1, sigma_e: 0.01, correlation: 0.0 },
        times: vec![0.0, 0.5],
        critical_e: 0.6,
    }
}

/// The scenario of that cloud, with comparison grids of 4 x 3 bins.
pub fn assignment() -> Assignment {
    let grid = Grid { phi: Axis { low: 0.0, high: 6.0, bins: 4 }, e: Axis { low: 0.0, high: 0.9, bins: 3 } };
    Assignment::in_plane(7, "scenario-1", (0, 1), Plane { problem: problem(), grids: vec![grid; 2] })
}

//! Chooses how the joint density is computed: by blocks, checked by a few orbits, or by orbits alone.

use crate::grid::Grid;
use crate::model::plane::{PlanarHamiltonian, State};

use super::family::Family;
use super::joint::Joint;
use super::moments::Noise;
use super::{by_blocks, by_orbits};

/// Number of backward orbits of one turn that the computation by blocks may take for each orbit that the computation by
/// orbits may take; the cost is about the same.
const BACKWARD: f64 = 4.0;
/// Number of orbits that check the computation by blocks.
const CHECKING: usize = 1_000;

/// The joint density after `years` on `grid`, to an L1 error of about `tolerance` unless that takes more than
/// `most_orbits`.
///
/// While the cloud is not wound up, blocks of bins with a polynomial each ([`by_blocks`]) are the cheaper way. Their
/// result is taken only if a few orbits, followed from grid line to grid line, agree with it within both errors.
pub(super) fn joint(
    family: &Family<impl PlanarHamiltonian>,
    grid: &Grid,
    years: f64,
    tolerance: f64,
    most_orbits: usize,
) -> Joint {
    let noise = Noise::of_probabilities(years, family);
    let joint = without_noise(family, grid, years, tolerance.max(noise), most_orbits);
    Joint { error: joint.error + noise, ..joint }
}

/// The joint density as if the states on the orbits were exact.
fn without_noise(
    family: &Family<impl PlanarHamiltonian>,
    grid: &Grid,
    years: f64,
    tolerance: f64,
    most_orbits: usize,
) -> Joint {
    if let Some(at_start) = Joint::at_start(&family.measure, grid).filter(|_| years == 0.0) {
        return at_start;
    }
    let most_backward = (BACKWARD * most_orbits as f64 / turns(&family.flow.model, grid, years).max(1.0)) as usize;
    let coarse = by_orbits::joint(family, grid, years, tolerance, CHECKING.min(most_orbits));
    if coarse.error <= tolerance {
        return coarse;
    }
    match by_blocks::joint(&family.flow, &family.measure, grid, years, tolerance, most_backward) {
        Some(joint) if joint.error <= tolerance && joint.agrees_with(&coarse, grid) => joint,
        _ => by_orbits::joint(family, grid, years, tolerance, most_orbits),
    }
}

/// Approximate number of turns of the fastest orbit on the grid in `years`; the integrator's steps are proportional to
/// it.
fn turns(model: &impl PlanarHamiltonian, grid: &Grid, years: f64) -> f64 {
    years * model.turning_rate(State { x1: 0.0, x2: grid.e.high }).max(1.0)
}

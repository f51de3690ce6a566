//! Weighted points of a cloud, and their moments.

use super::disc::Disc;
use crate::angle::Circular;
use crate::estimate::{Moments, weighted_moments};
use crate::model::plane::State;

/// The points of all cells, and the disc of each cell.
#[derive(Debug, Clone)]
pub(in crate::mesh) struct Whole {
    pub(super) samples: Samples,
    pub(super) discs: Vec<Disc>,
    /// Whether the points of each cell are states of orbits, and not of polynomials; empty if none are.
    pub(super) direct: Vec<bool>,
}

impl Whole {
    pub(super) fn is_direct(&self, cell: usize) -> bool {
        self.direct.get(cell).copied().unwrap_or(false)
    }
}

/// Weighted points of a cloud.
#[derive(Debug, Clone, Default)]
pub(super) struct Samples {
    pub phi: Vec<f64>,
    pub e: Vec<f64>,
    pub weights: Vec<f64>,
}

impl Samples {
    pub fn push(&mut self, state: State, weight: f64) {
        self.phi.push(state.x1.atan2(state.x2));
        self.e.push(state.eccentricity());
        self.weights.push(weight);
    }

    pub fn append(&mut self, mut other: Self) {
        self.phi.append(&mut other.phi);
        self.e.append(&mut other.e);
        self.weights.append(&mut other.weights);
    }

    pub fn moments(&self, critical_e: f64) -> (Moments, Circular) {
        weighted_moments(&self.phi, &self.e, Some(&self.weights), critical_e)
    }
}

//! The range of the Hamiltonian in a cloud: `H` is constant along every orbit, so no other orbits need be examined.

use std::f64::consts::TAU;

use crate::model::plane::{PlanarHamiltonian, State};

use super::measure::Measure;

/// Distance from the mean, in standard deviations, within which the cloud is looked for: 2e-16 of it lies beyond.
const RADIUS: f64 = 8.5;

/// A closed interval of values of the Hamiltonian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HamiltonianRange {
    pub low: f64,
    pub high: f64,
}

impl HamiltonianRange {
    pub(super) fn meets(self, other: Self) -> bool {
        self.low <= other.high && other.low <= self.high
    }

    fn hull(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}

/// Bounds of `H` on the rectangle `phi` x `e`.
pub(super) fn hamiltonian_range(model: &impl PlanarHamiltonian, phi: (f64, f64), e: (f64, f64)) -> HamiltonianRange {
    let (low, high) = model.hamiltonian_range(phi, e);
    HamiltonianRange { low, high }
}

/// The range of `H` in the cloud.
pub(crate) fn cloud_range(model: &impl PlanarHamiltonian, measure: &Measure) -> HamiltonianRange {
    range_within(model, measure, RADIUS)
}

/// The range of `H` in the part of the cloud that is at most so many standard deviations from its mean.
pub(super) fn range_within(model: &impl PlanarHamiltonian, measure: &Measure, radius: f64) -> HamiltonianRange {
    const PARTS: u32 = 48;
    let gaussian = measure.gaussian;
    let edge = |i: u32| radius * (2.0 * f64::from(i) / f64::from(PARTS) - 1.0);
    let least = |i: u32| edge(i).max(-edge(i + 1)).max(0.0);
    let mut range: Option<HamiltonianRange> = None;
    for (i, j) in (0..PARTS * PARTS).map(|k| (k / PARTS, k % PARTS)) {
        if least(i).hypot(least(j)) > radius {
            continue;
        }
        let corners = [(i, j), (i, j + 1), (i + 1, j), (i + 1, j + 1)].map(|(i, j)| gaussian.point(edge(i), edge(j)));
        let (e_low, e_high) = (corners[0].1, corners[3].1);
        let angles = corners.map(|(phi, _)| phi);
        let (phi_low, phi_high) =
            (angles.into_iter().fold(f64::INFINITY, f64::min), angles.into_iter().fold(f64::NEG_INFINITY, f64::max));
        if e_high <= 0.0 || e_low >= 1.0 {
            continue;
        }
        let cell = hamiltonian_range(model, (phi_low, phi_high), (e_low, e_high));
        range = Some(range.map_or(cell, |range| range.hull(cell)));
    }
    range.unwrap_or(HamiltonianRange { low: f64::NEG_INFINITY, high: f64::INFINITY })
}

/// A lower bound of the distance of a state from the cloud at `t = 0` in the `(x1, x2)` plane; 0 inside [`RADIUS`].
pub(super) fn distance_from_cloud(measure: &Measure, state: State) -> f64 {
    let gaussian = measure.gaussian;
    let e = state.eccentricity();
    let radial = (measure.e_sigmas(e).abs() - RADIUS) * gaussian.sigma_e;
    let angle = (measure.phi_sigmas(state.solar_angle()).abs() - RADIUS) * gaussian.sigma_phi;
    let beside = if angle > 0.0 { e * angle.min(TAU / 4.0).sin() } else { 0.0 };
    radial.max(beside).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::planar::SrpJ2;

    #[test]
    fn hamiltonian_range_encloses_the_hamiltonian() {
        let force = SrpJ2 { radiation: 0.15, oblateness: 0.40921 };
        for (phi, e) in [((0.2, 1.0), (0.1, 0.3)), ((2.0, 4.0), (0.0, 0.7)), ((-0.3, 0.4), (0.5, 0.9))] {
            let range = hamiltonian_range(&force, phi, e);
            for (i, j) in (0..21 * 21).map(|k| (f64::from(k / 21) / 20.0, f64::from(k % 21) / 20.0)) {
                let state = State::from_polar(phi.0 + i * (phi.1 - phi.0), e.0 + j * (e.1 - e.0));
                let h = force.hamiltonian(state);
                assert!(h >= range.low - 1e-12 && h <= range.high + 1e-12, "{h} {range:?}");
            }
        }
    }

    #[test]
    fn a_cloud_at_small_eccentricity_cannot_reach_the_rim() {
        let problem = crate::problem::paper::scenario(1);
        let cloud = cloud_range(&problem.model, &Measure::new(problem.initial));
        let at = |e: (f64, f64)| hamiltonian_range(&problem.model, (0.0, 0.5), e).meets(cloud);
        assert!(!at((0.9, 0.95)) && !at((0.95, 1.0)) && at((0.3, 0.5)));
    }
}

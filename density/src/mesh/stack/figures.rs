//! What follows from the sums over a stack.

use super::layer::Sums;
use crate::angle::Circular;
use crate::estimate::{Estimate, Moments};
use crate::grid::Grid;
use crate::uncertain::ThirdMoments;

/// The figures of a stack with a step.
pub(super) struct Read {
    pub plane: Estimate,
    /// Covariances of the third variable with solar angle and eccentricity.
    pub with_third: [f64; 2],
    /// The probability of the stack.
    pub mass: f64,
    /// The share of it that is counted in a wrong bin at most.
    pub misplaced: f64,
}

/// What a halving of the step changed.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Changed {
    /// The largest change of a moment, in standard deviations or products of them.
    pub moments: f64,
    /// The change of the joint density, in total variation.
    pub joint: f64,
}

impl Changed {
    pub(super) fn between(before: &Read, now: &Read, third: &ThirdMoments) -> Self {
        let (a, b) = (before.plane.moments, now.plane.moments);
        let (phi, e, c) = (b.std_phi, b.std_e, third.deviation);
        let of = |a: f64, b: f64, scale: f64| (a - b).abs() / scale;
        let moments = [
            of(a.mean_phi, b.mean_phi, phi),
            of(a.std_phi, b.std_phi, phi),
            of(a.mean_e, b.mean_e, e),
            of(a.std_e, b.std_e, e),
            of(a.cov_phi_e, b.cov_phi_e, phi * e),
            of(a.prob_above_critical_e, b.prob_above_critical_e, 1.0),
            of(before.with_third[0], now.with_third[0], phi * c),
            of(before.with_third[1], now.with_third[1], e * c),
        ];
        let bins = before.plane.joint.iter().zip(&now.plane.joint);
        let joint = 0.5 * bins.map(|(a, b)| (a - b).abs()).sum::<f64>() * now.plane.grid.bin_area();
        Self { moments: moments.into_iter().fold(0.0, f64::max), joint }
    }
}

/// The figures of sums with a step; `coarser` has the sums with the double step, for Simpson's rule.
pub(super) fn read(sums: &Sums, step: f64, coarser: Option<(&Sums, f64)>, centre: [f64; 2], grid: &Grid) -> Read {
    let mut integral = sums.clone();
    integral.scale(step);
    if let Some((before, double)) = coarser {
        integral.scale(4.0 / 3.0);
        integral.add(before, -double / 3.0);
    }
    let Sums { powers, with_third, vector, above, misplaced, mut joint } = integral;
    let [mass, phi, e, phi_phi, phi_e, e_e] = powers;
    let [phi, e, phi_phi, phi_e, e_e] = [phi, e, phi_phi, phi_e, e_e].map(|sum| sum / mass);
    joint.iter_mut().for_each(|bin| *bin /= mass * grid.bin_area());
    let moments = Moments {
        mean_phi: centre[0] + phi,
        std_phi: (phi_phi - phi * phi).max(0.0).sqrt(),
        mean_e: centre[1] + e,
        std_e: (e_e - e * e).max(0.0).sqrt(),
        cov_phi_e: phi_e - phi * e,
        prob_above_critical_e: (above / mass).clamp(0.0, 1.0),
    };
    let circular = Circular::from_mean_vector(vector[0] / mass, vector[1] / mass);
    let [third, with_phi, with_e] = with_third.map(|sum| sum / mass);
    Read {
        plane: Estimate::from_joint(*grid, joint, moments, circular),
        with_third: [with_phi - third * phi, with_e - third * e],
        mass,
        misplaced: misplaced / mass,
    }
}

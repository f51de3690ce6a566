//! Whether the densities that characteristics carry along are those that follow from their points.
//!
//! A carried mesh keeps the probability of its elements and needs no `n` after `t = 0`. The flow keeps the measure
//! `e/s dphi de`, so the points alone determine `n`: it must be the initial Gaussian's density times
//! `(e/s) / (e0/s0)`. A propagator that sends another `n` contradicts its own points.

use std::f64::consts::TAU;

use density::angle::nearest;
use density::model::plane::{State, density_growth};
use density::problem::InitialGaussian;

/// Standard deviations of the solar angle from the mean within which points are looked for.
const EXTENT: f64 = 6.0;

/// Where the points started, and their initial densities.
#[derive(Debug)]
pub(crate) struct CarriedDensity {
    start: Vec<(State, f64)>,
}

impl CarriedDensity {
    /// Takes the points of the first snapshot, at `t = 0`, and the densities that came with them. Angles are given
    /// modulo a full turn. If the cloud spans several turns, a point is placed on the turn on which the initial
    /// density is closest to the density that came with the point.
    pub(crate) fn begin(initial: &InitialGaussian, phi: &[f64], e: &[f64], n: &[f64]) -> Self {
        let turns = (EXTENT * initial.sigma_phi / TAU).round() as i32;
        let at = |((&phi, &e), &n): ((&f64, &f64), &f64)| {
            let phi = nearest(phi, initial.mean_phi);
            let densities = (-turns..=turns).map(|turn| initial.density(phi + TAU * f64::from(turn), e));
            let closest = densities.min_by(|a, b| (a - n).abs().total_cmp(&(b - n).abs()));
            (State::from_polar(phi, e), closest.unwrap_or(f64::NAN))
        };
        Self { start: phi.iter().zip(e).zip(n).map(at).collect() }
    }

    /// The mean of `|n - right| / max(n, right)` over all points, weighted by their initial densities: 0 where `n` is
    /// right, at most 1 unless `n` is negative. Points on `e = 0`, where the density of polar coordinates vanishes, do
    /// not count.
    pub(crate) fn error_of(&self, phi: &[f64], e: &[f64], n: &[f64]) -> f64 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (((&phi, &e), &n), &(start, density)) in phi.iter().zip(e).zip(n).zip(&self.start) {
            let right = density * density_growth(start, State::from_polar(phi, e));
            let largest = n.abs().max(right);
            if largest.is_finite() && largest > 0.0 {
                sum += density * (n - right).abs() / largest;
                weights += density;
            }
        }
        if weights > 0.0 { sum / weights } else { f64::NAN }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_carried_density_is_right_if_it_grows_by_the_change_of_e_over_s_and_wrong_by_as_much_as_it_does_not() {
        let initial = InitialGaussian { mean_phi: 6.2, mean_e: 0.2, sigma_phi: 0.1, sigma_e: 0.02, correlation: 0.0 };
        let (phi, e) = ([6.2, 0.0, 6.1], [0.2, 0.21, 0.0]);
        let carried = CarriedDensity::begin(&initial, &phi, &e, &[0.0; 3]);
        let n: Vec<f64> = carried.start.iter().map(|(_, density)| *density).collect();
        assert!(n[1] > 0.0 && n[2] == 0.0, "the nearest turn is meant; nothing is on e = 0");
        assert_eq!(carried.error_of(&phi, &e, &n), 0.0);
        let later = [0.4, 0.42, 0.3];
        let growth = |e0: f64, e1: f64| e1 / (1.0 - e1 * e1).sqrt() / (e0 / (1.0 - e0 * e0).sqrt());
        let right = [n[0] * growth(0.2, 0.4), n[1] * growth(0.21, 0.42), 0.0];
        assert!(carried.error_of(&phi, &later, &right) < 1e-12);
        let half = right.map(|n| 0.5 * n);
        assert!((carried.error_of(&phi, &later, &half) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn points_of_a_cloud_of_several_turns_are_on_the_turn_that_their_densities_are_of() {
        let initial = InitialGaussian { mean_phi: 3.0, mean_e: 0.2, sigma_phi: 1.5, sigma_e: 0.02, correlation: 0.0 };
        let (unfolded, e) = ([-3.0, 3.0, 8.0], [0.2; 3]);
        let n = [0, 1, 2].map(|i| initial.density(unfolded[i], e[i]));
        let phi = unfolded.map(|phi: f64| phi.rem_euclid(TAU));
        assert!(CarriedDensity::begin(&initial, &phi, &e, &n).error_of(&phi, &e, &n) < 1e-12);
        let half = n.map(|n| 0.5 * n);
        let off = CarriedDensity::begin(&initial, &phi, &e, &half).error_of(&phi, &e, &half);
        assert!(off > 0.4, "{off}");
    }
}

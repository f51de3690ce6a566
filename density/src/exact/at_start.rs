//! The moments of the initial Gaussian itself, in closed form: independent in `phi`, wrapped round the circle, and `e`, cut to `0 < e < 1`.

use std::f64::consts::{PI, TAU};

use crate::angle::{Circular, fold};
use crate::problem::InitialGaussian;

use super::measure::{normal_density, normal_tail};
use super::moments::SmoothMoments;

/// Moments at `t = 0`.
pub(super) fn moments(initial: &InitialGaussian) -> SmoothMoments {
    let (mean_e, std_e) = truncated(initial.mean_e, initial.sigma_e);
    let resultant = (-0.5 * initial.sigma_phi * initial.sigma_phi).exp();
    let mean_phi = fold(initial.mean_phi, 0.0);
    let error = ROUNDING * (1.0 / std_e + 1.0);
    SmoothMoments {
        mean_phi,
        std_phi: wrapped_deviation(initial.sigma_phi),
        mean_e,
        std_e,
        cov_phi_e: 0.0,
        circular: Circular { mean: mean_phi, resultant },
        error: error + ROUNDING / initial.sigma_phi,
        e_error: error,
        circular_error: ROUNDING,
        mass_error: 0.0,
        orbits: 0,
    }
}

/// Accuracy of the closed forms in double precision.
const ROUNDING: f64 = 1e-14;

/// Mean and deviation of a Gaussian that is cut to between 0 and 1 (Johnson, Kotz & Balakrishnan, *Continuous Univariate
/// Distributions* 1, 1994, Sect. 13.10.1).
fn truncated(mean: f64, sigma: f64) -> (f64, f64) {
    let (low, high) = (-mean / sigma, (1.0 - mean) / sigma);
    let mass = 1.0 - normal_tail(-low) - normal_tail(high);
    let (at_low, at_high) = (normal_density(low), normal_density(high));
    let shift = (at_low - at_high) / mass;
    let variance = 1.0 + (low * at_low - high * at_high) / mass - shift * shift;
    (mean + sigma * shift, sigma * variance.max(0.0).sqrt())
}

/// Standard deviation of a Gaussian angle of mean 0 on the branch from -π to π: an angle between `(2k - 1)π` and
/// `(2k + 1)π` is measured from `2πk`, which changes its square by `(2πk)² - 4πk phi`.
fn wrapped_deviation(sigma: f64) -> f64 {
    let turns = (10.0 * sigma / TAU).ceil() as u32 + 1;
    let change = |k: u32| {
        let turn = TAU * f64::from(k);
        let (from, to) = ((turn - PI) / sigma, (turn + PI) / sigma);
        let mass = normal_tail(from) - normal_tail(to);
        turn * turn * mass - 2.0 * turn * sigma * (normal_density(from) - normal_density(to))
    };
    (sigma * sigma + 2.0 * (1..=turns).map(change).sum::<f64>()).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the midpoint rule.
    fn integral(f: impl Fn(f64) -> f64, low: f64, high: f64) -> f64 {
        let n = 200_000;
        let h = (high - low) / f64::from(n);
        (0..n).map(|i| f(low + h * (f64::from(i) + 0.5))).sum::<f64>() * h
    }

    #[test]
    fn the_closed_forms_are_the_integrals() {
        for sigma in [0.1, 0.6, 1.2, 2.0, PI] {
            let density =
                |x: f64| (-6..=6).map(|k| normal_density((x + TAU * f64::from(k)) / sigma) / sigma).sum::<f64>();
            let variance = integral(|x| x * x * density(x), -PI, PI);
            assert!((wrapped_deviation(sigma) - variance.sqrt()).abs() < 1e-9, "{sigma}");
        }
        for (mean, sigma) in [(0.3, 0.02), (0.01, 0.02), (0.5, 0.5), (0.98, 0.03)] {
            let weight = |e: f64| normal_density((e - mean) / sigma);
            let mass = integral(weight, 0.0, 1.0);
            let first = integral(|e| e * weight(e), 0.0, 1.0) / mass;
            let second = integral(|e| (e - first).powi(2) * weight(e), 0.0, 1.0) / mass;
            let (found, deviation) = truncated(mean, sigma);
            assert!((found - first).abs() < 1e-9 && (deviation - second.sqrt()).abs() < 1e-9, "{mean} {sigma}");
        }
    }
}

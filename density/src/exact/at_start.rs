//! The moments of the initial Gaussian itself, with `phi` wrapped round the circle and `e` cut to `0 < e < 1`: in
//! closed form if they are independent, and otherwise by a sum over `e` of closed forms in `phi`.

use std::f64::consts::{PI, TAU};

use crate::angle::{Circular, fold};
use crate::problem::InitialGaussian;

use super::measure::{REACH, normal_density, normal_tail};
use super::moments::SmoothMoments;
use super::rules::gauss;

/// Moments at `t = 0`.
pub(super) fn moments(initial: &InitialGaussian) -> SmoothMoments {
    if initial.correlation == 0.0 { independent(initial) } else { correlated(initial) }
}

fn independent(initial: &InitialGaussian) -> SmoothMoments {
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

/// With `v` the eccentricity in standard deviations from its mean, the solar angle given `v` is normal.
fn correlated(initial: &InitialGaussian) -> SmoothMoments {
    let sigma = initial.sigma_phi_given_e();
    let nodes = nodes(initial);
    let mean_of = |term: &dyn Fn(f64) -> f64| nodes.iter().map(|&(v, weight)| weight * term(v)).sum::<f64>();
    let (mean_e, std_e) = truncated(initial.mean_e, initial.sigma_e);
    let offset = |v: f64| initial.mean_phi_given(v) - initial.mean_phi;
    let length = (-0.5 * sigma * sigma).exp();
    let (sin, cos) = (mean_of(&|v| offset(v).sin()), mean_of(&|v| offset(v).cos()));
    let circular = sin.atan2(cos);
    let on_branch = |v: f64| branch_moments(offset(v) - circular, sigma);
    let mean = mean_of(&|v| on_branch(v).0);
    let square = mean_of(&|v| on_branch(v).1);
    let product = mean_of(&|v| (initial.mean_e + initial.sigma_e * v - mean_e) * (on_branch(v).0 - mean));
    let direction = fold(initial.mean_phi + circular, 0.0);
    let std_phi = (square - mean * mean).max(0.0).sqrt();
    let error = ROUNDING * (1.0 / std_e + 1.0);
    SmoothMoments {
        mean_phi: direction + mean,
        std_phi,
        mean_e,
        std_e,
        cov_phi_e: product,
        circular: Circular { mean: direction, resultant: length * sin.hypot(cos) },
        error: error + ROUNDING / std_phi,
        e_error: error,
        circular_error: ROUNDING,
        mass_error: 0.0,
        orbits: 0,
    }
}

/// Nodes and weights of a mean over `v`, the cut eccentricity in standard deviations from its mean: the eight-point
/// Gauss rule on intervals that are short on the scale of the density and of the solar angle's passage through the
/// branch cut.
fn nodes(initial: &InitialGaussian) -> Vec<(f64, f64)> {
    let InitialGaussian { mean_e, sigma_e, correlation, .. } = *initial;
    let (low, high) = ((-mean_e / sigma_e).max(-REACH), ((1.0 - mean_e) / sigma_e).min(REACH));
    let scale = ((1.0 - correlation * correlation).sqrt() / correlation.abs()).min(1.0);
    let parts = ((high - low) / (0.5 * scale)).ceil().max(1.0) as u32;
    let edge = |i: u32| low + (high - low) * f64::from(i) / f64::from(parts);
    let nodes = (0..parts).flat_map(|i| gauss(edge(i), edge(i + 1)));
    let weighted: Vec<(f64, f64)> = nodes.map(|(v, weight)| (v, weight * normal_density(v))).collect();
    let total: f64 = weighted.iter().map(|(_, weight)| weight).sum();
    weighted.into_iter().map(|(v, weight)| (v, weight / total)).collect()
}

/// First and second moment, on the branch from -π to π, of a normal angle with this mean and deviation.
fn branch_moments(mean: f64, sigma: f64) -> (f64, f64) {
    let turns = ((mean.abs() + REACH * sigma - PI) / TAU).ceil().max(0.0) as i32;
    let on_turn = |k: i32| {
        let turn = TAU * f64::from(k);
        let [a, b] = [turn - PI, turn + PI].map(|end| (end - mean) / sigma);
        let mass = if a > 0.0 { normal_tail(a) - normal_tail(b) } else { normal_tail(-b) - normal_tail(-a) };
        // About the normal distribution's own mean (Johnson, Kotz & Balakrishnan 1994, Sect. 13.10.1).
        let first = sigma * (normal_density(a) - normal_density(b));
        let second = sigma * sigma * (mass + a * normal_density(a) - b * normal_density(b));
        let shift = mean - turn;
        (shift * mass + first, shift * shift * mass + 2.0 * shift * first + second)
    };
    (-turns..=turns).map(on_turn).fold((0.0, 0.0), |sum, term| (sum.0 + term.0, sum.1 + term.1))
}

/// Accuracy of the closed forms in double precision.
const ROUNDING: f64 = 1e-14;

/// Mean and deviation of a Gaussian that is cut to between 0 and 1 (Johnson, Kotz & Balakrishnan, *Continuous
/// Univariate Distributions* 1, 1994, Sect. 13.10.1).
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
        for (mean, sigma) in [(0.0, 0.3), (0.4, 0.6), (-3.0, 0.2), (2.9, 1.4), (7.0, 0.5)] {
            let density =
                |x: f64| (-6..=6).map(|k| normal_density((x - mean + TAU * f64::from(k)) / sigma) / sigma).sum::<f64>();
            let (first, second) = branch_moments(mean, sigma);
            // The integrands are no periodic functions, for which the midpoint rule would be accurate to rounding.
            assert!((first - integral(|x| x * density(x), -PI, PI)).abs() < 1e-8, "{mean} {sigma}");
            assert!((second - integral(|x| x * x * density(x), -PI, PI)).abs() < 1e-8, "{mean} {sigma}");
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

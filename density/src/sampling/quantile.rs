//! The standard normal distribution's tail and its inverse.

use std::f64::consts::{SQRT_2, TAU};

/// Probability that a standard normal variable exceeds `z`.
pub(crate) fn normal_tail(z: f64) -> f64 {
    0.5 * libm::erfc(z / SQRT_2)
}

/// The `z` that a standard normal variable exceeds with probability `tail`, for `0 < tail < 1`: a rational start
/// (Abramowitz & Stegun 26.2.23, accurate to 4.5e-4) and two steps of Halley's method, each of which triples the number
/// of correct digits.
pub(crate) fn normal_quantile_of_tail(tail: f64) -> f64 {
    if tail > 0.5 {
        // 1 - tail is exact here.
        return -normal_quantile_of_tail(1.0 - tail);
    }
    let t = (-2.0 * tail.ln()).sqrt();
    let start =
        t - (2.515_517 + t * (0.802_853 + t * 0.010_328)) / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308)));
    (0..2).fold(start, |z, _| {
        let newton = (normal_tail(z) - tail) * TAU.sqrt() * (0.5 * z * z).exp();
        z + newton / (1.0 - 0.5 * z * newton)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantile_inverts_the_tail() {
        for z in [-6.0f64, -2.5, -0.3, 0.0, 0.7, 3.0, 8.0] {
            // A tail near 1 keeps its last digit of 1e-16 only.
            let rounding = 1e-16 * (0.5 * z * z).exp() * TAU.sqrt();
            let tolerance = if z < 0.0 { 1e-13 + rounding } else { 1e-13 };
            assert!((normal_quantile_of_tail(normal_tail(z)) - z).abs() < tolerance, "{z}");
        }
        // Abramowitz & Stegun, Table 26.5.
        assert!((normal_quantile_of_tail(0.025) - 1.959_963_984_540_054).abs() < 1e-14);
    }
}

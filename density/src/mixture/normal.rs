//! The normal distribution function and the exponential, as fast as the bins of a mixture need them.

use std::f64::consts::{FRAC_1_SQRT_2, LN_2, LOG2_E, TAU};

/// Standard deviations from its mean beyond which a component is neglected; the tail left out is 2e-9.
pub(super) const REACH: f64 = 6.0;

/// `exp(x)` for `-700 < x <= 0` to a relative 1e-8: `2^k 2^f` with `|f| <= 1/2` and the Taylor series of `2^f`.
#[inline(always)]
pub(super) fn exp_of_negative(x: f64) -> f64 {
    // Adding this leaves a number's nearest integer in its lowest bits.
    const ROUND: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52
    let shifted = x * LOG2_E + ROUND;
    let y = x - (shifted - ROUND) * LN_2;
    let series = 1.0
        + y * (1.0
            + y * (1.0 / 2.0
                + y * (1.0 / 6.0 + y * (1.0 / 24.0 + y * (1.0 / 120.0 + y * (1.0 / 720.0 + y * (1.0 / 5040.0)))))));
    series * f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52)
}

/// `Φ` on `[-REACH, REACH]` by cubic Hermite interpolation, accurate to 4e-9; 0 and 1 beyond.
pub(super) struct NormalDistribution {
    /// `Φ` and its derivative times the spacing, at equally spaced nodes.
    nodes: Vec<[f64; 2]>,
}

impl NormalDistribution {
    const NODES_PER_SIGMA: f64 = 32.0;

    pub(super) fn new() -> Self {
        let node = |k: u32| {
            let x = f64::from(k) / Self::NODES_PER_SIGMA - REACH;
            let density = (-0.5 * x * x).exp() / TAU.sqrt();
            [0.5 * libm::erfc(-x * FRAC_1_SQRT_2), density / Self::NODES_PER_SIGMA]
        };
        Self { nodes: (0..=(2.0 * REACH * Self::NODES_PER_SIGMA) as u32).map(node).collect() }
    }

    /// `Φ(x)`.
    #[inline(always)]
    pub(super) fn below(&self, x: f64) -> f64 {
        let position = (x + REACH) * Self::NODES_PER_SIGMA;
        if position < 0.0 {
            return 0.0;
        }
        let index = position as usize;
        let Some(&[[low, low_slope], [high, high_slope]]) = self.nodes.get(index..).and_then(|rest| rest.first_chunk())
        else {
            return 1.0;
        };
        let t = position - index as f64;
        let rise = high - low;
        let curve = 3.0 * rise - 2.0 * low_slope - high_slope;
        low + t * (low_slope + t * (curve + t * (low_slope + high_slope - 2.0 * rise)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_the_normal_distribution_is_that_of_the_error_function() {
        let normal = NormalDistribution::new();
        for k in -8000..8000 {
            let x = f64::from(k) / 1000.0;
            assert!((normal.below(x) - 0.5 * libm::erfc(-x * FRAC_1_SQRT_2)).abs() < 4e-9, "{x}");
        }
    }

    #[test]
    fn exponentials_are_good_to_1e_8() {
        for k in 0..2500 {
            let x = -f64::from(k) / 100.0;
            assert!((exp_of_negative(x) / x.exp() - 1.0).abs() < 1e-8, "{x}");
        }
    }
}

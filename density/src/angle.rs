//! Statistics of an angle: the solar angle has no natural start, so a cloud is described on the branch that keeps it
//! whole.
//!
//! Mean and standard deviation of `phi` are taken on the branch `[c - π, c + π)` around the cloud's circular mean `c`
//! (Mardia & Jupp, *Directional Statistics*, 2000, Sect. 2.2). Taken on `[0, 2π)` they are meaningless for a cloud that
//! straddles `phi = 0`: scenario 3 at two years has a standard deviation of 0.108 rad, and of 1.92 rad on `[0, 2π)`.

use std::f64::consts::{PI, TAU};

/// The representative of `phi` in `[low, low + 2π)` \[rad\]; NaN stays NaN.
#[inline]
pub fn fold(phi: f64, low: f64) -> f64 {
    let offset = phi - low;
    // The remainder of an angle within the turn is the angle itself, bit by bit.
    let folded = low + if (0.0..TAU).contains(&offset) { offset } else { offset.rem_euclid(TAU) };
    if folded >= low + TAU { low } else { folded }
}

/// The representative of `phi` within π of `centre` \[rad\].
pub fn nearest(phi: f64, centre: f64) -> f64 {
    fold(phi, centre - PI)
}

/// Circular mean and mean resultant length of a weighted cloud of angles.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Circular {
    /// Direction of the mean vector, in `[0, 2π)` \[rad\].
    pub mean: f64,
    /// Length of the mean vector: 1 for a point, 0 for a cloud spread evenly round the circle.
    pub resultant: f64,
}

impl Circular {
    /// From the weighted means of `sin(phi)` and `cos(phi)`.
    pub fn from_mean_vector(sin: f64, cos: f64) -> Self {
        Self { mean: fold(sin.atan2(cos), 0.0), resultant: sin.hypot(cos) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folding_keeps_the_angle_and_lands_on_the_branch() {
        for phi in [-20.0, -1e-17, 0.0, 3.0, TAU, 100.0] {
            for low in [-PI, 0.0, 2.5] {
                let folded = fold(phi, low);
                assert!((low..low + TAU).contains(&folded));
                assert!((folded.sin() - phi.sin()).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn what_is_no_angle_stays_none() {
        assert!(fold(f64::NAN, 0.0).is_nan() && nearest(f64::NAN, 1.0).is_nan());
    }

    #[test]
    fn circular_mean_of_a_cloud_astride_zero_is_zero() {
        let vector = |phi: f64| (phi.sin(), phi.cos());
        let (a, b) = (vector(0.1), vector(TAU - 0.1));
        let circular = Circular::from_mean_vector((a.0 + b.0) / 2.0, (a.1 + b.1) / 2.0);
        assert!(nearest(circular.mean, 0.0).abs() < 1e-15);
        assert!((circular.resultant - 0.1f64.cos()).abs() < 1e-15);
    }
}

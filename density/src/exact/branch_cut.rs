//! Moments of an angle whose cloud reaches its branch cut, without a discontinuous integrand.
//!
//! On the branch `[c - π, c + π)` the deviation `θ = phi - c` jumps by 2π at the cut, and `θ²` has a kink there. Both are
//! convolved with a narrow kernel of order eight (a normal density of width [`WIDTH`] times a polynomial, whose moments 1
//! to 7 vanish; Wand & Schucany, Canad. J. Statist. 18, 1990). Away from the cut that changes nothing, as a convolution with
//! such a kernel reproduces polynomials. At the cut it changes `E[θ]` by `O(WIDTH⁸ p⁽⁷⁾)`, `p` the marginal density
//! of `phi` there: the integrand is smooth and the moment the same. The kernel of order six tells how far from converged
//! this is. With `y = (phi - cut)/WIDTH`, `N` the normal distribution function and `n` its density, the step `S` and ramp `R` are
//!
//! ```text
//! S(y) = N(y) - n(y) Σ_j c_j He_{2j-1}(y)      R(y) = y N(y) + n(y) (1 + Σ_j c_j He_{2j-2}(y))      c_j = (-1)^j/(2^j j!)
//! ```

use std::f64::consts::{PI, TAU};

use super::measure::normal_tail;

/// Width of the kernel \[rad\].
const WIDTH: f64 = 0.12;
/// Widths from the cut beyond which nothing changes.
const REACH: f64 = 9.0;

/// `θ` and `θ²`, smoothed at the cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Deviation {
    pub first: f64,
    pub second: f64,
    /// `first` minus what the kernel of order six gives.
    pub first_change: f64,
    /// `second` minus what the kernel of order six gives.
    pub second_change: f64,
}

/// Smooth deviation for `theta` in `[-π, π)`.
pub(super) fn deviation(theta: f64) -> Deviation {
    // Continue the branch across the cut: the side above it is θ + 2π.
    let beyond = if theta < 0.0 { theta + PI } else { theta - PI };
    let y = beyond / WIDTH;
    if y.abs() > REACH {
        return Deviation { first: theta, second: theta * theta, first_change: 0.0, second_change: 0.0 };
    }
    let y2 = y * y;
    let normal = (-0.5 * y2).exp() / TAU.sqrt();
    let last_step = normal * y * (y2 * (y2 - 10.0) + 15.0) / 48.0;
    let last_ramp = -normal * (y2 * (y2 - 6.0) + 3.0) / 48.0;
    let step = normal_tail(-y) + normal * y * (0.5 - (y2 - 3.0) / 8.0) + last_step;
    let ramp = y * normal_tail(-y) + normal * (0.5 + (y2 - 1.0) / 8.0) + last_ramp;
    let unrolled = PI + beyond;
    Deviation {
        first: unrolled - TAU * step,
        second: unrolled * unrolled - 4.0 * PI * WIDTH * ramp,
        first_change: -TAU * last_step,
        second_change: -4.0 * PI * WIDTH * last_ramp,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean of `f` under the wrapped normal density of deviation `sigma`, centred `shift` from the branch's centre.
    fn mean(sigma: f64, shift: f64, f: impl Fn(f64) -> f64) -> f64 {
        const POINTS: u32 = 200_000;
        let density = |theta: f64| -> f64 {
            let image = |k: i32| (theta - shift + TAU * f64::from(k)) / sigma;
            (-4..=4).map(|k| (-0.5 * image(k).powi(2)).exp()).sum::<f64>() / (sigma * TAU.sqrt())
        };
        let width = TAU / f64::from(POINTS);
        let theta = |i: u32| -PI + (f64::from(i) + 0.5) * width;
        (0..POINTS).map(|i| density(theta(i)) * f(theta(i)) * width).sum()
    }

    #[test]
    fn smoothing_the_cut_keeps_the_moments_of_a_wrapped_normal() {
        for (sigma, shift) in [(0.5, 0.0), (0.9, 0.2), (1.5, -0.4)] {
            let first = mean(sigma, shift, |theta| theta);
            let second = mean(sigma, shift, |theta| theta * theta);
            assert!((mean(sigma, shift, |theta| deviation(theta).first) - first).abs() < 1e-8);
            assert!((mean(sigma, shift, |theta| deviation(theta).second) - second).abs() < 1e-8);
        }
    }

    #[test]
    fn nothing_changes_away_from_the_cut() {
        for theta in [-2.0, -0.1, 0.0, 1.9] {
            assert_eq!(deviation(theta).first, theta);
        }
        // Where the smoothing ends it is as good as nothing already.
        let edge = PI - 0.99 * REACH * WIDTH;
        assert!(deviation(edge).first != edge && (deviation(edge).first - edge).abs() < 1e-12);
    }
}

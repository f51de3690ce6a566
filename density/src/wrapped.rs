//! A normal angle on a circle that is cut open: what lies beyond the cut appears at the other end.
//!
//! With `X` normal, of mean `mu` and deviation `sigma`, and the circle cut at `c ± π`, the angle on the branch is `W =
//! X - 2π` beyond the upper end and `X + 2π` beyond the lower one. The moments of truncated normals (Johnson, Kotz &
//! Balakrishnan, *Continuous Univariate Distributions* 1, 1994, Sect. 13.10.1) give those of `W`; a normal narrower
//! than a turn reaches across one end at most once.

use std::f64::consts::{PI, TAU};

use crate::exact::measure::{normal_density, normal_tail};

/// The part of a normal angle beyond the cut of its circle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct BeyondCut {
    /// Probability beyond the upper end less that beyond the lower end.
    upper_less_lower: f64,
    /// Probability beyond either end.
    both: f64,
    /// The deviation times the standard normal density at both ends \[rad\].
    edge: f64,
}

impl BeyondCut {
    /// The part beyond the cut of a normal angle whose mean lies `off` from the middle of the branch, `|off| <= π`.
    pub(crate) fn new(off: f64, deviation: f64) -> Self {
        let (to_upper, to_lower) = ((PI - off) / deviation, (PI + off) / deviation);
        let (upper, lower) = (normal_tail(to_upper), normal_tail(to_lower));
        let edge = deviation * (normal_density(to_upper) + normal_density(to_lower));
        Self { upper_less_lower: upper - lower, both: upper + lower, edge }
    }

    /// What it adds to the mean \[rad\].
    pub(crate) fn mean(&self) -> f64 {
        -TAU * self.upper_less_lower
    }

    /// What it adds to the mean square of the distance from an angle, from which the mean of the normal is `off`
    /// \[rad²\].
    pub(crate) fn square(&self, off: f64) -> f64 {
        TAU * (TAU * self.both - 2.0 * (off * self.upper_less_lower + self.edge))
    }

    /// What it adds to the mean product with another variable less a value, from which its mean is `off`; `slope` is
    /// its covariance with the angle over the angle's variance.
    pub(crate) fn product(&self, off: f64, slope: f64) -> f64 {
        -TAU * (off * self.upper_less_lower + slope * self.edge)
    }
}

/// What a component adds to the mean product of two variables less their means: `covariance` and `off` are its own
/// covariance and distances from these means, and `beyond` is the part of it that lies beyond the cut of an angle's
/// branch.
pub(crate) fn product(
    [a, b]: [usize; 2],
    covariance: impl Fn(usize, usize) -> f64,
    off: impl Fn(usize) -> f64,
    beyond: impl Fn(usize) -> Option<BeyondCut>,
) -> f64 {
    let plain = covariance(a, b) + off(a) * off(b);
    if a == b {
        return plain + beyond(a).map_or(0.0, |beyond| beyond.square(off(a)));
    }
    let across = |angle: usize, other: usize| {
        let slope = covariance(angle, other) / covariance(angle, angle);
        beyond(angle).map_or(0.0, |beyond| beyond.product(off(other), slope))
    };
    plain + across(a, b) + across(b, a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::angle::nearest;

    #[test]
    fn moments_of_a_normal_across_the_cut_are_those_of_a_sum_over_its_angles() {
        for (mean, deviation, slope) in [(2.9, 0.4, 0.3), (-3.0, 0.2, -0.5), (0.3, 0.9, 1.0), (1.0, 0.1, 0.2)] {
            let step = 1e-3;
            let (mut first, mut square, mut product) = (0.0, 0.0, 0.0);
            let (from, other_from) = (0.2, 0.7);
            for k in -9000..=9000 {
                let z = step * f64::from(k);
                let weight = step * normal_density(z);
                let x = mean + deviation * z;
                // The other variable has the mean 1.1 and depends on the angle by its slope.
                let (wrapped, other) = (nearest(x, 0.0), 1.1 + slope * (x - mean));
                first += weight * wrapped;
                square += weight * (wrapped - from).powi(2);
                product += weight * (wrapped - from) * (other - other_from);
            }
            let beyond = BeyondCut::new(mean, deviation);
            let off = mean - from;
            // A step at the cut is summed to a thousandth of the deviation.
            let tolerance = 3.0 * step;
            assert!((mean + beyond.mean() - first).abs() < tolerance, "{mean}");
            assert!(
                (off * off + deviation * deviation + beyond.square(off) - square).abs() < 6.0 * tolerance,
                "{mean}"
            );
            let expected = off * 0.4 + slope * deviation * deviation + beyond.product(0.4, slope);
            assert!((expected - product).abs() < 3.0 * tolerance, "{mean}: {expected} {product}");
        }
    }
}

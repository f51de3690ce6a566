//! Parts of a Gaussian over any number of variables, and how a part is split along any direction.
//!
//! A part is itself a Gaussian. It is kept in the standardised coordinates of the Gaussian that is split, in which that
//! one has the mean 0 and the covariance 1: a mean and a square root of the covariance, whose columns are the part's
//! own axes.
//!
//! A split along a direction is the even lattice of [`super::lattice`] in one dimension: equal Gaussians of width `s`,
//! in standard deviations of the part, at spacing `h`,
//!
//! ```text
//! m_i = i h,   w_i ∝ exp(-(i h)²/(2 (1 - s²))),   h = 1.6 s sqrt(1 - s²)
//! ```
//!
//! which reproduces the density to a ripple of `2 exp(-2 π²/1.6²)`, 0.09 %. The width is then changed by what the cut
//! of the lattice takes from the variance, so that weight, mean and covariance of the part are kept exactly.

use super::library::Library;
use crate::gaussian::Gaussian;
use crate::model::{Kind, Variable};

/// Spacing of the lattice in widths of its Gaussians.
const SPACING: f64 = 1.6;
/// A Gaussian of the lattice is left out if its peak weight is below this share of the whole probability: what lies
/// beyond the reach of 5.5 standard deviations of an undivided Gaussian.
const LEAST: f64 = 2.7e-7;
/// The least reach of a lattice in standard deviations, however little the part that is split weighs.
const LEAST_REACH: f64 = 2.5;

/// A part of a Gaussian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece<const N: usize> {
    /// Its share of the probability.
    pub weight: f64,
    /// Its mean in standardised coordinates.
    mean: [f64; N],
    /// Its axes in standardised coordinates: the columns of a square root of its covariance.
    axes: [[f64; N]; N],
}

/// Where a part lies in the ranges of the variables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Position<const N: usize> {
    /// All its sigma points are values of the variables.
    Inside,
    /// Some are not; the direction in the part's own axes in which a variable leaves its range.
    Across([f64; N]),
    /// Practically all of it is outside.
    Outside,
}

impl<const N: usize> Piece<N> {
    /// The undivided Gaussian.
    pub fn whole() -> Self {
        let axes = std::array::from_fn(|k| std::array::from_fn(|j| f64::from(j == k)));
        Self { weight: 1.0, mean: [0.0; N], axes }
    }

    /// The point at `own`, in standard deviations along the part's own axes.
    pub fn point(&self, whole: &Gaussian<N>, own: [f64; N]) -> [f64; N] {
        let along = |j: usize| (0..N).map(|k| own[k] * self.axes[k][j]).sum::<f64>();
        whole.point(std::array::from_fn(|j| self.mean[j] + along(j)))
    }

    /// The steps in the variables along the part's own axes.
    fn steps(&self, whole: &Gaussian<N>) -> [[f64; N]; N] {
        std::array::from_fn(|k| {
            std::array::from_fn(|v| (0..N).map(|j| whole.direction(j)[v] * self.axes[k][j]).sum::<f64>())
        })
    }

    /// Where the part lies, if its sigma points are at `distance` standard deviations.
    pub fn position(&self, whole: &Gaussian<N>, variables: &[Variable], distance: f64) -> Position<N> {
        /// Standard deviations beyond a bound at which a part counts as outside: 3e-5 of it are inside.
        const FAR: f64 = 4.0;
        let (centre, steps) = (self.point(whole, [0.0; N]), self.steps(whole));
        let mut position = Position::Inside;
        for (v, variable) in variables.iter().enumerate() {
            let Kind::Interval { low, high } = variable.kind else { continue };
            let width = steps.iter().map(|step| step[v] * step[v]).sum::<f64>().sqrt();
            let beyond = (low - centre[v]).max(centre[v] - high);
            if beyond > FAR * width {
                return Position::Outside;
            }
            if beyond + distance * width >= 0.0 {
                position = Position::Across(std::array::from_fn(|k| steps[k][v] / width));
            }
        }
        position
    }

    /// Splits the part along a direction of unit length in its own axes into parts with the means and the deviation of
    /// a library.
    pub fn split_by(&self, direction: [f64; N], library: &Library) -> Vec<Self> {
        let turned = self.turned(direction);
        let part = |(&x, &weight)| turned.moved(x, self.weight * weight, library.sigma);
        library.means.iter().zip(&library.weights).map(part).collect()
    }

    /// The part moved by `x` along its first axis, which it is then `width` times as wide along.
    fn moved(&self, x: f64, weight: f64, width: f64) -> Self {
        let axis = self.axes[0];
        let mut axes = self.axes;
        axes[0] = axis.map(|a| a * width);
        Self { weight, mean: std::array::from_fn(|j| self.mean[j] + x * axis[j]), axes }
    }

    /// Splits the part along a direction of unit length in its own axes into parts of width `s`.
    pub fn split(&self, direction: [f64; N], s: f64) -> Vec<Self> {
        let turned = self.turned(direction);
        let spread = (1.0 - s * s).sqrt();
        let spacing = SPACING * s * spread;
        let reach = (2.0 * (self.weight / LEAST).max(1.0).ln()).sqrt().max(LEAST_REACH) * spread;
        let count = (reach / spacing).ceil() as i32;
        let at: Vec<f64> = (-count..=count).map(|i| f64::from(i) * spacing).collect();
        let weights: Vec<f64> = at.iter().map(|x| (-0.5 * (x / spread).powi(2)).exp()).collect();
        let total: f64 = weights.iter().sum();
        let variance: f64 = at.iter().zip(&weights).map(|(x, weight)| weight * x * x).sum::<f64>() / total;
        let width = (1.0 - variance).sqrt();
        let part = |(&x, &weight): (&f64, &f64)| turned.moved(x, self.weight * weight / total, width);
        at.iter().zip(&weights).map(part).collect()
    }

    /// The same part with its first axis in a direction of unit length in its present axes: a Householder reflection.
    fn turned(&self, direction: [f64; N]) -> Self {
        let sign = if direction[0] > 0.0 { -1.0 } else { 1.0 };
        let mut normal = direction;
        normal[0] -= sign;
        let square: f64 = normal.iter().map(|x| x * x).sum();
        let reflected = |k: usize| -> [f64; N] {
            std::array::from_fn(|j| {
                let along = |i: usize| f64::from(i == k) - 2.0 * normal[i] * normal[k] / square;
                (0..N).map(|i| along(i) * self.axes[i][j]).sum()
            })
        };
        Self { axes: std::array::from_fn(reflected), ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_split_keeps_weight_mean_and_covariance() {
        let direction = [0.48, -0.6, 0.64];
        let mut pieces = vec![Piece::<3>::whole()];
        for (direction, s) in [(direction, 0.3), ([0.0, 1.0, 0.0], 0.6), ([1.0, 0.0, 0.0], 0.5)] {
            pieces = pieces.iter().flat_map(|piece| piece.split(direction, s)).collect();
        }
        let sum = |of: &dyn Fn(&Piece<3>) -> f64| pieces.iter().map(|piece| piece.weight * of(piece)).sum::<f64>();
        assert!((sum(&|_| 1.0) - 1.0).abs() < 1e-13);
        for (a, b) in [(0, 0), (0, 1), (1, 2), (2, 2)] {
            assert!(sum(&|piece| piece.mean[a]).abs() < 1e-13);
            let within = |piece: &Piece<3>| piece.axes.iter().map(|axis| axis[a] * axis[b]).sum::<f64>();
            let covariance = sum(&|piece| within(piece) + piece.mean[a] * piece.mean[b]);
            assert!((covariance - f64::from(a == b)).abs() < 1e-12, "{a} {b}: {covariance}");
        }
    }

    #[test]
    fn a_split_reproduces_the_density_to_its_ripple() {
        let normal = |x: f64, sigma: f64| (-0.5 * (x / sigma).powi(2)).exp() / sigma;
        for s in [0.1, 0.4, 0.7] {
            let parts = Piece::<1>::whole().split([1.0], s);
            for k in -30..=30 {
                let x = 0.1 * f64::from(k);
                let density: f64 = parts.iter().map(|p| p.weight * normal(x - p.mean[0], p.axes[0][0].abs())).sum();
                assert!((density / normal(x, 1.0) - 1.0).abs() < 2e-3, "{s} {x}");
            }
        }
    }

    #[test]
    fn a_part_across_a_bound_says_in_which_direction_it_leaves() {
        let range = |high| Variable { name: "", symbol: "", unit: "", kind: Kind::Interval { low: -1.0, high } };
        let whole = Gaussian::independent([0.0; 2], [0.1, 0.5]);
        let piece = Piece::whole();
        assert_eq!(piece.position(&whole, &[range(1.0); 2], 2.0), Position::Across([0.0, 1.0]));
        assert_eq!(piece.position(&whole, &[range(1.0); 2], 1.9), Position::Inside);
        assert_eq!(piece.position(&whole, &[range(-0.5), range(1.0)], 1.0), Position::Outside);
    }
}

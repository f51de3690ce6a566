//! How far the flow over a part of a Gaussian is from linear, in any number of variables, and in which direction most.
//!
//! This is [`super::linearity`] with all second derivatives. With the first and second differences `a_i` and `H_ij` of
//! the flow along the axes of the part ([`super::differences`]),
//!
//! ```text
//! D_c = Σ_i |½ H_ii| + Σ_{i<j} |H_ij|,   |b|² = b^T (P_lin + R)^{-1} b,   P_lin = Σ_i a_i a_i^T
//! ```
//!
//! with the resolution `R` of that file. The twist `H_ij` counts too, which sigma points on the axes alone do not see.
//! The direction in which the flow is most nonlinear is the unit vector `u` for which `Σ_j |H(u, j)|²` is largest.
//!
//! `D_c` says whether the image of the part is a Gaussian. What the part does to the moments of the whole cloud is
//! another question: second derivatives add `½ Σ_ij H_ij²` to the variance of a variable (the variance of a quadratic
//! form of normals), of which the unscented transform has a part only. In units of the whole cloud's variance this is
//! the part's moment error
//!
//! ```text
//! E_c = max_v ½ Σ_ij (H_ij)_v²/sigma_v²
//! ```
//!
//! It is large next to `e = 0`, where a part may be wide in `phi` and nearly a Gaussian.

use super::differences::{Differences, pairs};
use super::linearity::RESOLUTION;
use super::triangular::{cholesky, solved};
use crate::model::Variable;

/// The second differences of the flow over a part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Curvature<const N: usize> {
    /// In units in which the part's linear image has the covariance 1.
    pub local: Tensor<N>,
    /// In standard deviations of the whole cloud.
    pub whole: Tensor<N>,
}

/// Second differences: entry `[i][j]` is a vector over the variables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tensor<const N: usize>([[[f64; N]; N]; N]);

impl<const N: usize> Curvature<N> {
    /// From the variables of the points at [`places`](super::differences::places), carried by the flow. `deviations`
    /// are those of the whole cloud.
    pub fn new(variables: &[Variable], carried: &[[f64; N]], distance: f64, deviations: [f64; N]) -> Self {
        let Differences { slopes, second } = Differences::new(variables, carried, distance);
        let mut covariance = [[0.0; N]; N];
        for slope in slopes {
            for (a, row) in covariance.iter_mut().enumerate() {
                row.iter_mut().enumerate().for_each(|(b, entry)| *entry += slope[a] * slope[b]);
            }
        }
        for (v, row) in covariance.iter_mut().enumerate() {
            row[v] += (RESOLUTION * deviations[v]).powi(2) + f64::MIN_POSITIVE;
        }
        let (tensor, root) = (Tensor(second), cholesky(covariance));
        let in_deviations =
            |vector: [f64; N]| std::array::from_fn(|v| vector[v] / deviations[v].max(f64::MIN_POSITIVE));
        Self { local: tensor.map(|vector| solved(&root, vector)), whole: tensor.map(in_deviations) }
    }

    /// `D_c`.
    pub fn disagreement(&self) -> f64 {
        let Tensor(second) = &self.local;
        let bends: f64 = (0..N).map(|i| 0.5 * length(&second[i][i])).sum();
        bends + pairs::<N>().map(|(i, j)| length(&second[i][j])).sum::<f64>()
    }

    /// `E_c`.
    pub fn moment_error(&self) -> f64 {
        let Tensor(second) = &self.whole;
        let of = |v: usize| 0.5 * second.iter().flatten().map(|vector| vector[v] * vector[v]).sum::<f64>();
        (0..N).map(of).fold(0.0, f64::max)
    }
}

impl<const N: usize> Tensor<N> {
    fn map(&self, change: impl Fn([f64; N]) -> [f64; N]) -> Self {
        Self(self.0.map(|row| row.map(&change)))
    }

    /// The direction in which the flow is most nonlinear, of unit length in the part's own axes, by the power method.
    pub fn direction(&self) -> [f64; N] {
        const ROUNDS: usize = 60;
        let product = |i: usize, j: usize| -> f64 {
            (0..N).map(|l| (0..N).map(|v| self.0[i][l][v] * self.0[l][j][v]).sum::<f64>()).sum()
        };
        let matrix: [[f64; N]; N] = std::array::from_fn(|i| std::array::from_fn(|j| product(i, j)));
        let largest = (0..N).max_by(|&i, &j| matrix[i][i].total_cmp(&matrix[j][j])).unwrap_or(0);
        let mut unit: [f64; N] = std::array::from_fn(|k| f64::from(k == largest));
        for _ in 0..ROUNDS {
            let next: [f64; N] = std::array::from_fn(|i| (0..N).map(|j| matrix[i][j] * unit[j]).sum());
            let size = length(&next);
            if !(size > 0.0 && size.is_finite()) {
                break;
            }
            unit = next.map(|x| x / size);
        }
        unit
    }

    /// The share of the disagreement that a split along `direction` into parts of width `s` leaves: the bend along it,
    /// and the twists with it.
    pub fn after_split(&self, direction: [f64; N], s: f64) -> f64 {
        let with =
            |j: usize| -> [f64; N] { std::array::from_fn(|v| (0..N).map(|i| direction[i] * self.0[i][j][v]).sum()) };
        let rows: [[f64; N]; N] = std::array::from_fn(with);
        let bend: [f64; N] = std::array::from_fn(|v| (0..N).map(|j| direction[j] * rows[j][v]).sum());
        let twists = |j: usize| -> [f64; N] { std::array::from_fn(|v| rows[j][v] - direction[j] * bend[v]) };
        0.5 * s * s * length(&bend) + s * (0..N).map(|j| length(&twists(j))).sum::<f64>()
    }
}

fn length<const N: usize>(vector: &[f64; N]) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::differences::{places, points};
    use super::*;
    use crate::model::Kind;

    const REAL: Variable = Variable { name: "", symbol: "", unit: "", kind: Kind::Interval { low: -9.0, high: 9.0 } };

    fn of(map: impl Fn([f64; 3]) -> [f64; 3]) -> Curvature<3> {
        let carried: Vec<[f64; 3]> = places::<3>(2.0).into_iter().map(map).collect();
        assert_eq!(carried.len(), points(3));
        Curvature::new(&[REAL; 3], &carried, 2.0, [1e-9; 3])
    }

    #[test]
    fn a_linear_flow_agrees_and_a_quadratic_one_disagrees_by_its_second_derivatives() {
        let linear = of(|[x, y, z]| [2.0 * x + y, y - 0.5 * z, 3.0 * z]);
        assert!(linear.disagreement() < 1e-12, "{}", linear.disagreement());
        let bent = of(|[x, y, z]| [x, y + 0.2 * x * x, z]);
        assert!((bent.disagreement() - 0.2).abs() < 1e-12, "{}", bent.disagreement());
        let twisted = of(|[x, y, z]| [x, y, z + 0.3 * x * y]);
        assert!((twisted.disagreement() - 0.3).abs() < 1e-12, "sigma points on the axes would see nothing of it");
    }

    #[test]
    fn the_moment_error_is_the_variance_that_second_derivatives_add() {
        // x² - 1 of a standard normal x has the variance 2, and x y the variance 1.
        let carried: Vec<[f64; 3]> =
            places::<3>(2.0).into_iter().map(|[x, y, z]| [x + 0.1 * x * x, y + 0.2 * x * y, z]).collect();
        let error = |deviations| Curvature::new(&[REAL; 3], &carried, 2.0, deviations).moment_error();
        assert!((error([1.0, 9.0, 1.0]) - 0.01 * 2.0).abs() < 1e-12);
        assert!((error([9.0, 1.0, 1.0]) - 0.04).abs() < 1e-12);
    }

    #[test]
    fn the_direction_is_that_in_which_the_flow_bends() {
        let unit = [0.48, -0.6, 0.64];
        let bent = of(|x| {
            let along: f64 = (0..3).map(|k| unit[k] * x[k]).sum();
            [x[0] + along * along, x[1], x[2]]
        });
        let found = bent.local.direction();
        let cosine: f64 = (0..3).map(|k| unit[k] * found[k]).sum();
        assert!((cosine.abs() - 1.0).abs() < 1e-10, "{found:?}");
        assert!((bent.local.after_split(found, 0.5) / bent.local.after_split(found, 1.0) - 0.25).abs() < 1e-6);
    }
}

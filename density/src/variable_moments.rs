//! Moments of a cloud over the variables of any model.
//!
//! As in the plane ([`crate::estimate`]), a variable on a circle is taken on the branch around its circular mean.

use crate::angle::{Circular, nearest};
use crate::estimate::ordered_sum;
use crate::model::Variable;

/// Mean and covariance of a cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VariableMoments<const N: usize> {
    /// Means; the mean of an angle is on the branch within π of its circular mean \[rad\].
    pub mean: [f64; N],
    /// Covariance.
    pub covariance: [[f64; N]; N],
    /// Circular means and resultant lengths; `None` for variables that are not angles.
    pub circular: [Option<Circular>; N],
}

impl<const N: usize> VariableMoments<N> {
    /// Standard deviations.
    pub fn deviations(&self) -> [f64; N] {
        std::array::from_fn(|k| self.covariance[k][k].sqrt())
    }
}

/// Moments of weighted points, one column per variable. Weights need not be normalised; `None` gives all points the
/// same weight.
///
/// # Panics
/// If there are not `N` variables, or the columns differ in length.
pub fn weighted_moments<const N: usize>(
    variables: &[Variable],
    columns: [&[f64]; N],
    weights: Option<&[f64]>,
) -> VariableMoments<N> {
    let rows = columns[0].len();
    assert!(variables.len() == N && columns.iter().all(|column| column.len() == rows), "a column for every variable");
    let weight = |i: usize| weights.map_or(1.0, |weights| weights[i]);
    let [total] = ordered_sum(rows, |i| [weight(i)]);
    let circular = std::array::from_fn(|k| {
        variables[k].is_circle().then(|| {
            let [sin, cos] = ordered_sum(rows, |i| {
                let (sin, cos) = columns[k][i].sin_cos();
                [weight(i) * sin, weight(i) * cos]
            });
            Circular::from_mean_vector(sin / total, cos / total)
        })
    });
    let on_branch = |k: usize, i: usize| {
        let circular: Option<Circular> = circular[k];
        circular.map_or(columns[k][i], |circular| nearest(columns[k][i], circular.mean))
    };
    let mean: [f64; N] =
        ordered_sum(rows, |i| std::array::from_fn(|k| weight(i) * on_branch(k, i))).map(|sum| sum / total);
    let off = |k: usize, i: usize| on_branch(k, i) - mean[k];
    let covariance = std::array::from_fn(|a| {
        let row: [f64; N] = ordered_sum(rows, |i| std::array::from_fn(|b| weight(i) * off(a, i) * off(b, i)));
        row.map(|sum| sum / total)
    });
    VariableMoments { mean, covariance, circular }
}

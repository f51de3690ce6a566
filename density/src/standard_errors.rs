//! Standard errors of Monte Carlo: for the moments of a sample and for the density in its bins.
//!
//! For `n` independent samples, with central moments `m_jk = mean of (phi - mean)^j (e - mean)^k`, to leading order in
//! `1/n` (Kendall & Stuart, *The Advanced Theory of Statistics* 1, 1977, Chapter 10):
//!
//! ```text
//! mean         sqrt(m_2 / n)
//! deviation    sqrt((m_4 - m_2²) / (4 m_2 n))          not s/sqrt(2n), which holds for Gaussians only
//! covariance   sqrt((m_22 - m_11²) / n)
//! probability  sqrt(p (1 - p) / n)                      zero at p = 0: give `wilson_interval` in its place there
//! bin count c  sqrt(c (1 - c/n))                        binomial; about sqrt(c) for a bin that holds few of all
//! ```
//!
//! If a cloud reaches round the circle, moments of `phi` also depend on where its branch is cut, and the cut depends on
//! the sample: see [`Cut`].
//!
//! These formulas hold for independent samples only. Antithetic and low-discrepancy samples are correlated within a
//! group of [`crate::sampling::SamplingPlan`], but the groups are not. With the same moment taken of each of `R`
//! groups, the standard error of the whole is about `s_R / sqrt(R)`, with `s_R` the standard deviation of the groups'
//! values (Owen, *Monte Carlo theory, methods and examples*, 2013, Chapter 17). With few groups it is itself uncertain,
//! by `1/sqrt(2(R-1))` of its value, and an interval is `± t` of Student with `R - 1` degrees of freedom: 2.26 for 10
//! groups, not 1.96.

use std::f64::consts::TAU;

use crate::angle::{Circular, nearest};
use crate::estimate::{Moments, ordered_sum};
use crate::sampling::group;

/// The effect of the branch cut of `phi` on a sample's influence on moments: the cut follows the sample's circular
/// mean, see [`crate::sample_sums`]. All fields are zero for a cloud that does not reach round the circle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cut {
    /// Density of `phi` at the cut \[1/rad\].
    pub density: f64,
    /// Mean of `phi` less the circular mean \[rad\].
    pub mean_from_circular: f64,
    /// Mean of `e` beside the cut, less the mean of `e` of all samples.
    pub e_beside: f64,
    /// Mean of `(phi - μ) g`, `g = sin(phi - c)/R`.
    pub with_phi: f64,
    /// Mean of `((phi - μ)² - σ²) g`.
    pub with_square: f64,
    /// Mean of `((phi - μ)(e - ν) - κ) g`.
    pub with_product: f64,
    /// Mean of `g²`.
    pub square: f64,
}

/// Standard errors of the moments of `n` independent samples, from their central moments
/// `m_20, m_40, m_02, m_04, m_11, m_22` and the share `p` of samples above the critical eccentricity.
pub fn of_independent(n: f64, [phi2, phi4, e2, e4, phi_e, phi2_e2]: [f64; 6], cut: Cut, p: f64) -> Moments {
    let error = |variance: f64| (variance.max(0.0) / n).sqrt();
    // The variance of an influence function that contains the term `a g`.
    let with_cut = |variance: f64, a: f64, with: f64| {
        if a == 0.0 { variance } else { variance + 2.0 * a * with + a * a * cut.square }
    };
    let turn = TAU * cut.density;
    Moments {
        mean_phi: error(with_cut(phi2, turn, cut.with_phi)),
        std_phi: error(
            with_cut(phi4 - phi2 * phi2, -2.0 * turn * cut.mean_from_circular, cut.with_square) / (4.0 * phi2),
        ),
        mean_e: error(e2),
        std_e: error((e4 - e2 * e2) / (4.0 * e2)),
        cov_phi_e: error(with_cut(phi2_e2 - phi_e * phi_e, turn * cut.e_beside, cut.with_product)),
        prob_above_critical_e: error(p * (1.0 - p)),
    }
}

/// Standard errors of the moments of samples that were drawn in `replicates` independent groups, from the spread of the
/// groups' moments. They are right for every kind of [`crate::sampling::Draws`]. Each group has its own branch of
/// `phi`, as the whole sample has, so the spread includes that of the branch cut. [`Moments::NONE`] for fewer than two
/// groups, or if there are too few samples to put two into each group.
///
/// # Panics
/// If `phi` and `e` differ in length.
pub fn of_groups(phi: &[f64], e: &[f64], replicates: usize, circular_mean: f64, critical_e: f64) -> Moments {
    assert_eq!(phi.len(), e.len(), "one phi for every e");
    if replicates < 2 || phi.len() / 2 < replicates {
        return Moments::NONE;
    }
    let mut members = vec![Vec::with_capacity(phi.len() / replicates + 2); replicates];
    (0..phi.len()).for_each(|row| members[group(row, replicates)].push(row));
    let values: Vec<[f64; 6]> = members
        .iter()
        .map(|rows| {
            let [sin, cos] = ordered_sum(rows.len(), |i| [phi[rows[i]].sin(), phi[rows[i]].cos()]);
            let own = nearest(Circular::from_mean_vector(sin, cos).mean, circular_mean);
            group_moments(rows, |row| (nearest(phi[row], own), e[row]), critical_e)
        })
        .collect();
    let groups = replicates as f64;
    Moments::from_array(std::array::from_fn(|k| {
        let mean = values.iter().map(|value| value[k]).sum::<f64>() / groups;
        let squares: f64 = values.iter().map(|value| (value[k] - mean).powi(2)).sum();
        (squares / ((groups - 1.0) * groups)).sqrt()
    }))
}

/// Moments of the samples `rows`, on the branch that `point` gives.
fn group_moments(rows: &[usize], point: impl Fn(usize) -> (f64, f64) + Sync, critical_e: f64) -> [f64; 6] {
    let n = rows.len() as f64;
    let [phi, e, above] = ordered_sum(rows.len(), |i| {
        let (phi, e) = point(rows[i]);
        [phi, e, f64::from(e > critical_e)]
    })
    .map(|sum| sum / n);
    let [phi2, e2, phi_e] = ordered_sum(rows.len(), |i| {
        let (a, b) = (point(rows[i]).0 - phi, point(rows[i]).1 - e);
        [a * a, b * b, a * b]
    })
    .map(|sum| sum / n);
    [phi, phi2.sqrt(), e, e2.sqrt(), phi_e, above]
}

/// Standard errors of a density estimated from `samples` independent samples by counts in cells of area `cell`:
/// `sqrt(c (1 - c/n)) / (n A)`. For a marginal, `cell` is the bin's width. The standard error is zero in an empty bin,
/// about which the data say only that its probability is below `3/n` (95 %).
pub fn of_density(density: &[f64], samples: usize, cell: f64) -> Vec<f64> {
    let n = samples as f64;
    let error = |share: f64| (share * (1.0 - share).max(0.0) / n).sqrt() / cell;
    density.iter().map(|density| error((density * cell).max(0.0))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{Axis, Grid};

    #[test]
    fn a_bins_error_is_the_binomial_one_of_its_count() {
        // 25 of 100 samples in a bin of area 0.5.
        let errors = of_density(&[25.0 / 100.0 / 0.5, 0.0, 2.0], 100, 0.5);
        assert!((errors[0] - (25.0f64 * 0.75).sqrt() / 50.0).abs() < 1e-15);
        assert_eq!(errors[1..], [0.0; 2]);
        // Few of many: relative error 1/sqrt(c).
        let rare = of_density(&[9.0 / 1e6], 1_000_000, 1.0)[0] / (9.0 / 1e6);
        assert!((rare * 3.0 - 1.0).abs() < 1e-5);
    }

    #[test]
    fn errors_of_two_point_samples_are_those_of_a_coin() {
        // phi = ±0.1, e = 0.2 or 0.4 at even odds: deviation 0.1 exactly, however many samples.
        let n = 400;
        let phi: Vec<f64> = (0..n).map(|i| if i % 2 == 0 { 0.1 } else { -0.1 }).collect();
        let e: Vec<f64> = (0..n).map(|i| if i % 4 < 2 { 0.2 } else { 0.4 }).collect();
        let grid = Grid { phi: Axis { low: -0.3, high: 0.5, bins: 2 }, e: Axis { low: 0.1, high: 0.4, bins: 2 } };
        let errors = crate::binning::estimate(&phi, &e, grid, 0.3).standard_errors;
        assert!((errors.mean_phi - 0.1 / 20.0).abs() < 1e-15 && (errors.mean_e - 0.1 / 20.0).abs() < 1e-15);
        assert!(errors.std_phi < 1e-9 && errors.std_e < 1e-9);
        assert!((errors.cov_phi_e - 0.01 / 20.0).abs() < 1e-15);
        assert!((errors.prob_above_critical_e - 0.5 / 20.0).abs() < 1e-15);
    }

    #[test]
    fn one_group_has_no_spread_to_tell_an_error_from() {
        let errors = of_groups(&[0.1, 0.2, 0.3], &[0.1, 0.2, 0.3], 1, 0.2, 0.6);
        assert!(errors.to_array().iter().all(|error| error.is_nan()));
        assert!(of_groups(&[0.1; 3], &[0.1; 3], 2, 0.1, 0.6).mean_e.is_nan());
    }
}

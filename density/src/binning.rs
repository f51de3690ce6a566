//! Density of a Monte Carlo cloud: the share of samples in each bin, per area (Eqs. 9-10 of Sun et al. 2022).
//!
//! The moments are computed from the samples themselves, not from the bins, by sums that can be taken in parts
//! ([`sample_sums`]). Their [standard errors](standard_errors) come with them; the standard errors of the bins are a
//! function of the density ([`standard_errors::of_density`]).

use crate::estimate::Estimate;
use crate::grid::Grid;
use crate::{sample_sums, standard_errors};

/// The density of equally weighted, independent samples; samples outside the grid count in the total and in the
/// moments.
///
/// # Panics
/// If `phi` and `e` differ in length.
pub fn estimate(phi: &[f64], e: &[f64], grid: Grid, critical_e: f64) -> Estimate {
    sample_sums::estimate(phi, e, grid, critical_e)
}

/// Like [`estimate`], for samples drawn in `replicates` independent groups ([`crate::sampling::group`] gives the group
/// of a row). The standard errors are computed from the spread between the groups.
///
/// # Panics
/// If `phi` and `e` differ in length.
pub fn estimate_in_groups(phi: &[f64], e: &[f64], grid: Grid, critical_e: f64, replicates: usize) -> Estimate {
    let estimate = sample_sums::estimate(phi, e, grid, critical_e);
    let standard_errors = standard_errors::of_groups(phi, e, replicates, estimate.circular.mean, critical_e);
    Estimate { standard_errors, ..estimate }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Axis;

    #[test]
    fn samples_on_the_grid_make_its_mass() {
        let grid = Grid { phi: Axis { low: 6.0, high: 6.5, bins: 5 }, e: Axis { low: 0.1, high: 0.3, bins: 4 } };
        let (phi, e) = ([6.05, 0.1, 3.0, 6.45], [0.15, 0.29, 0.2, 0.5]); // two inside, one a turn lower
        let estimate = estimate(&phi, &e, grid, 0.25);
        assert!((estimate.mass() - 0.5).abs() < 1e-15);
        assert!((estimate.moments.prob_above_critical_e - 0.5).abs() < 1e-15);
        assert!((estimate.marginal_phi.iter().sum::<f64>() * grid.phi.width() - 0.5).abs() < 1e-15);
    }
}

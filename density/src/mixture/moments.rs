//! Moments of a Gaussian mixture, and its estimate on the comparison grid.
//!
//! Mean and covariance are those of Eq. 16, in a form without cancellation:
//! `P_c = Σ w_i (P_i + (m_i - m_c)(m_i - m_c)^T)`. The circular mean is the direction of `Σ w_i exp(i m_i - P_i/2)`,
//! the mean vector of normals wrapped round the circle (Mardia & Jupp 2000, Eq. 3.5.60); means of `phi` are taken on
//! the branch around it. `P(e > e_cri)` is a sum of complementary error functions. Only the part of every component
//! above `e = 0` counts.

use std::f64::consts::FRAC_1_SQRT_2;

use super::bins;
use super::error::MixtureError;
use super::planar_component::{PlanarComponent, check};
use crate::angle::{Circular, nearest};
use crate::estimate::{Estimate, Moments, ordered_sum};
use crate::grid::Grid;

/// Circular mean of a mixture's solar angle.
fn circular(components: &[PlanarComponent]) -> Circular {
    let [total, sin, cos] = ordered_sum(components.len(), |i| {
        let component = components[i];
        let (sin, cos) = component.mean_phi.sin_cos();
        let length = component.weight * (-0.5 * component.var_phi).exp();
        [component.weight, length * sin, length * cos]
    });
    Circular::from_mean_vector(sin / total, cos / total)
}

/// Moments of a mixture whose components are Gaussians.
pub(super) fn unchecked_moments(components: &[PlanarComponent], critical_e: f64) -> (Moments, Circular) {
    let [above] = ordered_sum(components.len(), |i| {
        let component = &components[i];
        let tail = 0.5 * libm::erfc((critical_e - component.mean_e) * FRAC_1_SQRT_2 / component.var_e.sqrt());
        [component.weight * tail]
    });
    let components: Vec<PlanarComponent> = components.iter().map(|component| component.above_zero()).collect();
    let circular = circular(&components);
    let on_branch = |component: &PlanarComponent| nearest(component.mean_phi, circular.mean);
    let [total, phi, e] = ordered_sum(components.len(), |i| {
        let component = &components[i];
        [1.0, on_branch(component), component.mean_e].map(|term| component.weight * term)
    });
    let (mean_phi, mean_e) = (phi / total, e / total);
    let [var_phi, cov_phi_e, var_e] = ordered_sum(components.len(), |i| {
        let component = &components[i];
        let (dphi, de) = (on_branch(component) - mean_phi, component.mean_e - mean_e);
        [component.var_phi + dphi * dphi, component.cov_phi_e + dphi * de, component.var_e + de * de]
            .map(|term| component.weight * term / total)
    });
    let moments = Moments {
        mean_phi,
        std_phi: var_phi.sqrt(),
        mean_e,
        std_e: var_e.sqrt(),
        cov_phi_e,
        prob_above_critical_e: (above / total).min(1.0),
    };
    (moments, circular)
}

/// Moments and circular mean of a mixture. Weights need not sum to 1.
///
/// # Errors
/// [`MixtureError::NoGaussian`] and [`MixtureError::Weightless`].
pub fn moments(components: &[PlanarComponent], critical_e: f64) -> Result<(Moments, Circular), MixtureError> {
    check(components)?;
    Ok(unchecked_moments(components, critical_e))
}

/// The share of a mixture's probability that lies below `e = 0`, where there are no orbits; [`estimate`] leaves it out.
/// Where a component reaches across `e = 0`, a Gaussian in `(phi, e)` describes the cloud poorly.
pub fn mass_below_zero(components: &[PlanarComponent]) -> f64 {
    let [all, above] = ordered_sum(components.len(), |i| [components[i].weight, components[i].above_zero().weight]);
    (1.0 - above / all).max(0.0)
}

/// The density, marginals and moments of a mixture: bin averages on `grid`, and moments of the whole part above
/// `e = 0`. Weights need not sum to 1; the result is normalised.
///
/// # Errors
/// [`MixtureError::NoGaussian`] and [`MixtureError::Weightless`].
pub fn estimate(components: &[PlanarComponent], grid: &Grid, critical_e: f64) -> Result<Estimate, MixtureError> {
    let (moments, circular) = moments(components, critical_e)?;
    let total: f64 = components.iter().map(|component| component.above_zero().weight).sum();
    let mut joint = bins::bin_averages(components, grid);
    joint.iter_mut().for_each(|bin| *bin /= total);
    Ok(Estimate::from_joint(*grid, joint, moments, circular))
}

//! The paper's density reconstruction: Delaunay triangulation over the final points, linear interpolation, binning.
//!
//! Eqs. 11-13 of Sun et al. (2022): the density weights `n` of the final points are interpolated linearly on a fine
//! grid of points ([`super::raster`]), averaged in each bin, and divided by their sum. The axes are not scaled
//! (radians, and eccentricity as it is): scaling them would change the triangulation, and the paper does not scale
//! them.
//!
//! Moments are exact integrals of the piecewise linear density over all triangles, the limit of an infinitely fine grid
//! that covers the whole hull; so is the probability above the critical eccentricity.

use std::f64::consts::PI;

use super::delaunay::triangulate;
use super::polygon::{Corner, moments, share_above};
use super::raster::PointGrid;
use super::{MeshError, check_column, check_points};
use crate::angle::{Circular, fold};
use crate::estimate::{Estimate, Moments, ordered_sum};
use crate::grid::Grid;

/// Where the circle of solar angles is cut open before triangulating.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Branch {
    /// At `phi = 0`, as in the paper; a cloud that straddles `phi = 0` is torn apart.
    AsPrinted,
    /// Opposite the middle of the comparison grid, away from the cloud.
    #[default]
    Grid,
}

impl Branch {
    fn low(self, grid: &Grid) -> f64 {
        match self {
            Self::AsPrinted => 0.0,
            Self::Grid => grid.branch_low(),
        }
    }
}

/// Density estimate from final points `(phi, e)` with densities `n` on any common scale. The densities are interpolated
/// over the points' Delaunay triangulation on `interpolation_points` x `interpolation_points` points of the comparison
/// grid.
///
/// Moments refer to the chosen branch of `phi`.
///
/// # Errors
/// [`MeshError`] if the columns differ in length or hold values out of range, the points span no triangle, the
/// interpolation grid is coarser than the bins, or no density is found on the grid.
pub fn hull_estimate(
    phi: &[f64],
    e: &[f64],
    n: &[f64],
    grid: &Grid,
    interpolation_points: usize,
    branch: Branch,
    critical_e: f64,
) -> Result<Estimate, MeshError> {
    check_points(phi, e, phi.len())?;
    check_column("n", n, phi.len(), "a finite density, zero or more", |n| n.is_finite() && n >= 0.0)?;
    let low = branch.low(grid);
    let point_grid = PointGrid::new(grid, interpolation_points)?;
    let phi: Vec<f64> = phi.iter().map(|&phi| fold(phi, low)).collect();
    let triangles = triangulate(&phi, e)?;
    let corner = |row: u32| [phi[row as usize], e[row as usize], n[row as usize]];
    let triangle = |k: usize| triangles[k].map(corner);

    let (moments, circular) = integrate(triangles.len(), triangle, critical_e)?;
    let joint = rasterise(&point_grid, grid, low, triangles.len(), triangle)?;
    Ok(Estimate::from_joint(*grid, joint, moments, circular))
}

/// Joint density on the grid, of unit mass (Eq. 12). Triangles are shifted by full turns to where the grid is.
fn rasterise(
    point_grid: &PointGrid,
    grid: &Grid,
    branch_low: f64,
    count: usize,
    triangle: impl Fn(usize) -> [Corner; 3] + Sync,
) -> Result<Vec<f64>, MeshError> {
    let turns = |angle: f64| ((angle - branch_low) / (2.0 * PI)).floor() as i32;
    let mut joint = vec![0.0; grid.len()];
    for turn in turns(grid.phi.low)..=turns(grid.phi.high) {
        let shift = 2.0 * PI * f64::from(turn);
        let shifted = |k: usize| triangle(k).map(|[phi, e, n]| [phi + shift, e, n]);
        let means = point_grid.bin_means(count, shifted);
        joint.iter_mut().zip(means).for_each(|(joint, mean)| *joint += mean);
    }
    let sum: f64 = joint.iter().sum();
    if !(sum > 0.0 && sum.is_finite()) {
        return Err(MeshError::NoDensity);
    }
    joint.iter_mut().for_each(|density| *density /= sum * grid.bin_area());
    Ok(joint)
}

/// Moments of the piecewise linear density, normalised by its integral.
fn integrate(
    count: usize,
    triangle: impl Fn(usize) -> [Corner; 3] + Sync,
    critical_e: f64,
) -> Result<(Moments, Circular), MeshError> {
    // Mass, first moments, and the mean vector by the midpoints of the edges, which is exact up to second order.
    let [mass, phi, e, sin, cos] = ordered_sum(count, |k| {
        let corners = triangle(k);
        let [mass, phi, e, ..] = moments(&corners, [0.0; 2]);
        let density = corners[0][2] + corners[1][2] + corners[2][2];
        let share = if density > 0.0 { mass / density } else { 0.0 };
        let (mut sin, mut cos) = (0.0, 0.0);
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let weight = share * corners[a][2].midpoint(corners[b][2]);
            let (s, c) = corners[a][0].midpoint(corners[b][0]).sin_cos();
            sin += weight * s;
            cos += weight * c;
        }
        [mass, phi, e, sin, cos]
    });
    if !(mass > 0.0 && mass.is_finite()) {
        return Err(MeshError::NoDensity);
    }
    let (mean_phi, mean_e) = (phi / mass, e / mass);
    let [var_phi, var_e, cov_phi_e, above] = ordered_sum(count, |k| {
        let corners = triangle(k);
        let [mass, _, _, phi_phi, e_e, phi_e] = moments(&corners, [mean_phi, mean_e]);
        [phi_phi, e_e, phi_e, if mass > 0.0 { mass * share_above(&corners, critical_e) } else { 0.0 }]
    })
    .map(|sum| sum / mass);
    let moments = Moments {
        mean_phi,
        std_phi: var_phi.max(0.0).sqrt(),
        mean_e,
        std_e: var_e.max(0.0).sqrt(),
        cov_phi_e,
        prob_above_critical_e: above.clamp(0.0, 1.0),
    };
    Ok((moments, Circular::from_mean_vector(sin / mass, cos / mass)))
}

//! The joint density on the comparison grid as exact bin averages.

use crate::angle::nearest;
use crate::grid::Grid;

use super::measure::Measure;

/// Bin averages of the joint density and what is known of their error.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Mean density in each bin \[1/rad\], `phi` outermost.
    pub density: Vec<f64>,
    /// Estimate of the L1 error of `density`.
    pub error: f64,
    /// Probability outside the grid.
    pub mass_outside: f64,
    /// Number of orbits followed.
    pub orbits: usize,
}

impl Joint {
    /// Whether another joint density is the same within both error estimates.
    pub(super) fn agrees_with(&self, other: &Self, grid: &Grid) -> bool {
        let apart: f64 = self.density.iter().zip(&other.density).map(|(a, b)| (a - b).abs() * grid.bin_area()).sum();
        let outside = (self.mass_outside - other.mass_outside).abs();
        apart + outside <= 2.0 * (self.error + other.error)
    }

    /// The initial Gaussian itself, from its distribution functions; `None` if the variables are not independent.
    pub(super) fn at_start(measure: &Measure, grid: &Grid) -> Option<Self> {
        if measure.gaussian.correlation != 0.0 {
            return None;
        }
        let (phi, e) = (&grid.phi, &grid.e);
        // Moves the edges to the turn of the circle that holds the mean.
        let shift = nearest(phi.low, measure.gaussian.mean_phi) - phi.low;
        let between = |i: usize| measure.phi_between(phi.edge(i) + shift, phi.edge(i + 1) + shift);
        let columns: Vec<f64> = (0..phi.bins).map(between).collect();
        let below = |j: usize| measure.e_probability(measure.e_sigmas(e.edge(j)));
        let rows: Vec<f64> = (0..e.bins).map(|j| below(j + 1) - below(j)).collect();
        let masses = columns.iter().flat_map(|column| rows.iter().map(move |row| column * row));
        let density: Vec<f64> = masses.map(|mass| mass / grid.bin_area()).collect();
        let inside = columns.iter().sum::<f64>() * rows.iter().sum::<f64>();
        Some(Self { density, error: grid.len() as f64 * f64::EPSILON, mass_outside: 1.0 - inside, orbits: 0 })
    }
}

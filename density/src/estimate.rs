//! The result of every method: a density on the comparison grid, its marginals and its moments.

use rayon::prelude::*;

use crate::angle::{Circular, nearest};
use crate::grid::Grid;

/// Moments of a cloud in the `(phi, e)` plane, `phi` on the branch of its circular mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    /// Mean solar angle \[rad\].
    pub mean_phi: f64,
    /// Standard deviation of the solar angle \[rad\].
    pub std_phi: f64,
    /// Mean eccentricity.
    pub mean_e: f64,
    /// Standard deviation of the eccentricity.
    pub std_e: f64,
    /// Covariance of solar angle and eccentricity \[rad\].
    pub cov_phi_e: f64,
    /// Probability that the eccentricity exceeds its critical value at the time of the snapshot.
    pub prob_above_critical_e: f64,
}

impl Moments {
    /// No value at all, as the standard error of a method that has none.
    pub const NONE: Self = Self {
        mean_phi: f64::NAN,
        std_phi: f64::NAN,
        mean_e: f64::NAN,
        std_e: f64::NAN,
        cov_phi_e: f64::NAN,
        prob_above_critical_e: f64::NAN,
    };

    /// As an array, in the order of the fields.
    pub fn to_array(self) -> [f64; 6] {
        [self.mean_phi, self.std_phi, self.mean_e, self.std_e, self.cov_phi_e, self.prob_above_critical_e]
    }

    /// The inverse of [`Moments::to_array`].
    pub fn from_array([mean_phi, std_phi, mean_e, std_e, cov_phi_e, prob_above_critical_e]: [f64; 6]) -> Self {
        Self { mean_phi, std_phi, mean_e, std_e, cov_phi_e, prob_above_critical_e }
    }
}

/// A density estimate at one snapshot.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The comparison grid.
    pub grid: Grid,
    /// Mean density in each bin \[1/rad\], `phi` outermost.
    pub joint: Vec<f64>,
    /// Mean marginal density of the solar angle in each of its bins \[1/rad\].
    pub marginal_phi: Vec<f64>,
    /// Mean marginal density of the eccentricity in each of its bins.
    pub marginal_e: Vec<f64>,
    /// Moments of the whole cloud, also of what lies outside the grid.
    pub moments: Moments,
    /// Standard errors of the moments; [`Moments::NONE`] where the method has none.
    pub standard_errors: Moments,
    /// Circular mean and resultant length of the solar angle.
    pub circular: Circular,
}

impl Estimate {
    /// Completes a joint density by its marginals, the sums of its rows and columns (Eqs. 10 and 13).
    pub fn from_joint(grid: Grid, joint: Vec<f64>, moments: Moments, circular: Circular) -> Self {
        let marginal_phi = joint.chunks(grid.e.bins).map(|row| row.iter().sum::<f64>() * grid.e.width()).collect();
        let marginal_e = (0..grid.e.bins)
            .map(|j| joint.iter().skip(j).step_by(grid.e.bins).sum::<f64>() * grid.phi.width())
            .collect();
        Self { grid, joint, marginal_phi, marginal_e, moments, standard_errors: Moments::NONE, circular }
    }

    /// Probability on the grid; the rest up to 1 lies outside the grid or was lost.
    pub fn mass(&self) -> f64 {
        self.joint.iter().sum::<f64>() * self.grid.bin_area()
    }
}

/// Number of points that a thread sums at a time. Sums of chunks are added in order, so a result does not depend on the
/// threads.
const CHUNK: usize = 8192;

/// Circular mean and moments of weighted points. Weights need not be normalised; `None` gives all points the same
/// weight.
///
/// # Panics
/// If the slices differ in length.
pub fn weighted_moments(phi: &[f64], e: &[f64], weights: Option<&[f64]>, critical_e: f64) -> (Moments, Circular) {
    assert!(phi.len() == e.len() && weights.is_none_or(|w| w.len() == e.len()), "one weight for every point");
    let weight = |i: usize| weights.map_or(1.0, |w| w[i]);
    let [total, sin, cos] = ordered_sum(phi.len(), |i| {
        let (sin, cos) = phi[i].sin_cos();
        [1.0, sin, cos].map(|term| weight(i) * term)
    });
    let circular = Circular::from_mean_vector(sin / total, cos / total);
    let on_branch = |i: usize| nearest(phi[i], circular.mean);
    let [mean_phi, mean_e, above] =
        ordered_sum(phi.len(), |i| [on_branch(i), e[i], f64::from(e[i] > critical_e)].map(|term| weight(i) * term))
            .map(|sum| sum / total);
    let [var_phi, var_e, cov_phi_e] = ordered_sum(phi.len(), |i| {
        let (dphi, de) = (on_branch(i) - mean_phi, e[i] - mean_e);
        [dphi * dphi, de * de, dphi * de].map(|term| weight(i) * term)
    })
    .map(|sum| sum / total);
    let moments = Moments {
        mean_phi,
        std_phi: var_phi.sqrt(),
        mean_e,
        std_e: var_e.sqrt(),
        cov_phi_e,
        prob_above_critical_e: above,
    };
    (moments, circular)
}

/// The sum of `term` over `0..count`, in an order that does not depend on the number of threads.
pub fn ordered_sum<const K: usize>(count: usize, term: impl Fn(usize) -> [f64; K] + Sync) -> [f64; K] {
    let add = |mut sum: [f64; K], term: [f64; K]| {
        sum.iter_mut().zip(term).for_each(|(sum, term)| *sum += term);
        sum
    };
    let chunks: Vec<[f64; K]> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| (chunk * CHUNK..count.min((chunk + 1) * CHUNK)).map(&term).fold([0.0; K], add))
        .collect();
    chunks.into_iter().fold([0.0; K], add)
}

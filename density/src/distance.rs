//! How far one density lies from another on the same grid.
//!
//! `p` (method) and `q` (reference) are the probabilities of the cells. One further cell, "outside the grid", holds
//! what each of the two falls short of 1.
//!
//! ```text
//! total variation    TV = 1/2 Σ |p - q|              largest difference of the probability of any set of cells
//! Hellinger          h  = sqrt(1/2 Σ (√p - √q)²)     between 0 and 1; h² <= TV <= √2 h
//! Kullback-Leibler   D  = Σ [p ln(p/q) - p + q]      of the METHOD from the REFERENCE, D(method‖reference) [nat]
//! L2                 L2 = sqrt(Σ (p - q)² / A)       A the area of a cell; the outside has none and is left out
//! Kolmogorov         K  = max |F_p - F_q|            marginals only; F the distribution function at the bins' edges
//! ```
//!
//! Gibbs & Su, *On choosing and bounding probability metrics* (Int. Stat. Rev. 70, 2002) give the first three and their
//! inequalities; `D` is in Csiszár's form (Ann. Probab. 3, 1975), which is the usual one for densities of mass 1 and
//! stays nonnegative, term by term, for a method that lost mass. Distances between cell averages never exceed the
//! distances between the densities themselves, and converge to them with the square of the cells' width.
//!
//! Where the method's probability is zero, its term of `D` is `q`: empty bins of a Monte Carlo run do no harm, which is
//! why the method comes first. Where the reference is below [`FLOOR`] and the method above it, `q` is taken as
//! [`FLOOR`]: infinity would say no more than that one cell far out is filled. Probabilities below zero count as zero,
//! except in TV, L2 and K.

use crate::estimate::Estimate;
use crate::grid::Grid;

/// Probability of a cell below which the reference is not distinguished from zero, in the Kullback-Leibler divergence
/// only: the rounding of a probability of order 1.
pub const FLOOR: f64 = 1e-16;

/// Distances of a method's density from a reference; formulas in the [module's text](self).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distances {
    /// Half the L1 distance, in `[0, 1]` for densities of mass 1.
    pub total_variation: f64,
    /// L2 distance, in the square root of the density's unit (`1/sqrt(rad)` for the joint density).
    pub l2: f64,
    /// Hellinger distance, in `[0, 1]`.
    pub hellinger: f64,
    /// Kullback-Leibler divergence of the method relative to the reference \[nat\].
    pub kullback_leibler: f64,
    /// Largest difference of the distribution functions; NaN for a joint density.
    pub kolmogorov: f64,
}

/// A method's estimate against a reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// Distances between the joint densities.
    pub joint: Distances,
    /// Distances between the marginals of the solar angle. The Kolmogorov distance compares distribution functions that
    /// start at the grid's lower edge; on another branch of the circle it could be up to twice or down to half as large
    /// (Kuiper).
    pub marginal_phi: Distances,
    /// Distances between the marginals of the eccentricity.
    pub marginal_e: Distances,
    /// Probability that the method's density on the grid falls short of 1: it is outside the grid or lost.
    pub mass_outside: f64,
    /// The same for the reference.
    pub reference_mass_outside: f64,
}

/// Two estimates that cannot be compared.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "the method's density is on the grid {method:?}, the reference on {reference:?}: both must be estimated on one grid"
)]
pub struct DifferentGrids {
    /// The method's grid.
    pub method: Grid,
    /// The reference's grid.
    pub reference: Grid,
}

/// Distances of `method` from `reference`, of the joint densities and of both marginals.
///
/// # Errors
/// [`DifferentGrids`] if the two are not on the same grid.
///
/// # Panics
/// If a density does not have one value for every bin of its grid.
pub fn compare(method: &Estimate, reference: &Estimate) -> Result<Comparison, DifferentGrids> {
    if method.grid != reference.grid {
        return Err(DifferentGrids { method: method.grid, reference: reference.grid });
    }
    let Grid { phi, e } = method.grid;
    Ok(Comparison {
        joint: between(&method.joint, &reference.joint, method.grid.bin_area()),
        marginal_phi: between_marginals(&method.marginal_phi, &reference.marginal_phi, phi.width()),
        marginal_e: between_marginals(&method.marginal_e, &reference.marginal_e, e.width()),
        mass_outside: 1.0 - method.mass(),
        reference_mass_outside: 1.0 - reference.mass(),
    })
}

/// Distances of densities averaged over cells of area `cell`; the Kolmogorov distance, which needs an order of the
/// cells, is NaN.
///
/// # Panics
/// If the slices differ in length.
pub fn between(density: &[f64], reference: &[f64], cell: f64) -> Distances {
    assert_eq!(density.len(), reference.len(), "one reference value for every density");
    let probabilities = || density.iter().zip(reference).map(|(p, q)| (p * cell, q * cell));
    let (mass, reference_mass) = probabilities().fold((0.0, 0.0), |sum, (p, q)| (sum.0 + p, sum.1 + q));
    let outside = (1.0 - mass, 1.0 - reference_mass);
    let cells = || probabilities().chain([outside]);
    let squares: f64 = probabilities().map(|(p, q)| (p - q).powi(2)).sum();
    Distances {
        total_variation: 0.5 * cells().map(|(p, q)| (p - q).abs()).sum::<f64>(),
        l2: (squares / cell).sqrt(),
        hellinger: (0.5 * cells().map(root_difference_squared).sum::<f64>()).sqrt(),
        kullback_leibler: cells().map(divergence).sum(),
        kolmogorov: f64::NAN,
    }
}

/// Distances of marginal densities averaged over bins of width `width`, in ascending order.
///
/// # Panics
/// If the slices differ in length.
pub fn between_marginals(density: &[f64], reference: &[f64], width: f64) -> Distances {
    let differences = density.iter().zip(reference).scan(0.0, |sum: &mut f64, (p, q)| {
        *sum += (p - q) * width;
        Some(sum.abs())
    });
    Distances { kolmogorov: differences.fold(0.0, f64::max), ..between(density, reference, width) }
}

fn root_difference_squared((p, q): (f64, f64)) -> f64 {
    (p.max(0.0).sqrt() - q.max(0.0).sqrt()).powi(2)
}

/// A cell's share of the Kullback-Leibler divergence.
fn divergence((p, q): (f64, f64)) -> f64 {
    let (p, q) = (p.max(0.0), q.max(0.0));
    if p == 0.0 {
        return q;
    }
    let q = q.max(p.min(FLOOR));
    p * (p / q).ln() - p + q
}

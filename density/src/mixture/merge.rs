//! Fewer components with the same mean and covariance.
//!
//! Two components are replaced by the Gaussian with their common moments (Eq. 16), again and again, each time the pair for
//! which that costs least. The cost is Runnalls' upper bound on the Kullback-Leibler divergence that a merger adds (Runnalls,
//! IEEE Trans. Aerosp. Electron. Syst. 43(3), 2007, Eq. 16):
//!
//! ```text
//! B(i, j) = ½ [(w_i + w_j) ln det P_ij - w_i ln det P_i - w_j ln det P_j]
//! ```
//!
//! Mean and covariance of the mixture stay as they are to rounding. Every component keeps its cheapest partner; the time is that of
//! a few comparisons of all pairs, about a second for 5,000 components.

use rayon::prelude::*;

use super::{Component, MixtureError, check};
use crate::angle::nearest;

/// Merges components until at most `most` are left.
///
/// # Errors
/// [`MixtureError::NoGaussian`] and [`MixtureError::Weightless`].
pub fn merge(components: &[Component], most: usize) -> Result<Vec<Component>, MixtureError> {
    check(components)?;
    let mut left: Vec<Component> = components.iter().filter(|component| component.weight > 0.0).copied().collect();
    let mut partners: Vec<Partner> = (0..left.len()).into_par_iter().map(|i| cheapest_partner(&left, i)).collect();
    while left.len() > most.max(1) {
        let Some(i) = (0..left.len()).min_by(|&a, &b| partners[a].cost.total_cmp(&partners[b].cost)) else { break };
        let j = partners[i].index;
        left[i] = merged(&left[i], &left[j]);
        let last = left.len() - 1;
        left.swap_remove(j);
        partners.swap_remove(j);
        let moved = |index: usize| if index == last { j } else { index };
        let i = moved(i);
        let renewed = left[i];
        partners.par_iter_mut().enumerate().for_each(|(k, partner)| {
            let lost = partner.index == j || moved(partner.index) == i;
            partner.index = moved(partner.index);
            if k == i || lost {
                *partner = cheapest_partner(&left, k);
            } else {
                let cost = cost(&left[k], &renewed);
                if cost < partner.cost {
                    *partner = Partner { index: i, cost };
                }
            }
        });
    }
    Ok(left)
}

/// The partner with which a component merges at the least cost.
#[derive(Clone, Copy)]
struct Partner {
    index: usize,
    cost: f64,
}

fn cheapest_partner(components: &[Component], i: usize) -> Partner {
    let nobody = Partner { index: i, cost: f64::INFINITY };
    (0..components.len()).filter(|&j| j != i).fold(nobody, |best, index| {
        let cost = cost(&components[i], &components[index]);
        if cost < best.cost { Partner { index, cost } } else { best }
    })
}

/// Runnalls' bound.
fn cost(a: &Component, b: &Component) -> f64 {
    let together = merged(a, b);
    let entropy = |c: &Component| c.weight * determinant(c).ln();
    0.5 * (entropy(&together) - entropy(a) - entropy(b))
}

/// Kept above zero for components that the flow has drawn out to a line.
fn determinant(component: &Component) -> f64 {
    let product = component.var_phi * component.var_e;
    (product - component.cov_phi_e * component.cov_phi_e).max(1e-14 * product)
}

/// The Gaussian with the moments of two.
fn merged(a: &Component, b: &Component) -> Component {
    let weight = a.weight + b.weight;
    let (share, other) = (a.weight / weight, b.weight / weight);
    let (dphi, de) = (nearest(b.mean_phi, a.mean_phi) - a.mean_phi, b.mean_e - a.mean_e);
    let between = share * other;
    Component {
        weight,
        mean_phi: a.mean_phi + other * dphi,
        mean_e: a.mean_e + other * de,
        var_phi: share * a.var_phi + other * b.var_phi + between * dphi * dphi,
        cov_phi_e: share * a.cov_phi_e + other * b.cov_phi_e + between * dphi * de,
        var_e: share * a.var_e + other * b.var_e + between * de * de,
    }
}

//! Splitting criteria by the names that the field uses: in which one direction a Gaussian is best split.
//!
//! A Gaussian `N(m, P)`, `P = S S^T`, is carried by a flow `g` with first derivatives `G` and second derivatives `G²`
//! at `m`. Each criterion is a measure of a direction `x`; the Gaussian is split where it is largest. The linear
//! prediction is `P_z = G P G^T = S_z S_z^T`.
//!
//! | name | measure | constraint | source |
//! |---|---|---|---|
//! | `variance` | `\|x\|` | `\|S^{-1} x\| = 1` | Kulik & LeGrand 2024 |
//! | `fos` | `\|G x\|` | `\|x\| = 1` | the same |
//! | `safos` | `E[(u^T x)² \|G u\|²]`, `u ~ N(0, P)` | `\|x\| = 1` | the same |
//! | `usfos` | `\|G x\|` | `\|S^{-1} x\| = 1` | the same |
//! | `sos` | `\|G² x²\|` | `\|x\| = 1` | the same |
//! | `wussos` | `\|S_z^{-1} G² x²\|` | `\|S^{-1} x\| = 1` | the same |
//! | `solc` | `\|G² x\|_F` | `\|x\| = 1` | Tuggle & Zanetti 2018 |
//! | `ussolc` | `\|G²(x) S\|_F` | `\|S^{-1} x\| = 1` | Tuggle & Zanetti 2018 |
//! | `wussolc` | `\|S_z^{-1} G²(x) S\|_F` | `\|S^{-1} x\| = 1` | Kulik & LeGrand 2024 |
//! | `sasos` | `E[(u^T x)² \|G² u²\|²]` | `\|x\| = 1` | the same |
//! | `wsasos` | `E[(u^T x)² \|S_z^{-1} G² u²\|²]` | `\|x\| = 1` | the same |
//! | `alodt` | bend of the sigma points on a principal axis | principal axes | Faubel & Klakow 2010 |
//! | `sadl` | `\|(G_SL - G) x\|`, `G_SL` from sigma points | `\|S^{-1} x\| = 1` | Kulik & LeGrand 2024 |
//! | `wussadl` | `\|S_z^{-1} (G_SL - G) x\|` | `\|S^{-1} x\| = 1` | the same |
//!
//! Names, measures and sources are those stated in the documentation of PyEst 0.7.2 (K. LeGrand, MIT license), which
//! has all of them: J. Kulik & K. A. LeGrand, *Nonlinearity and Uncertainty Informed Moment-Matching Gaussian Mixture
//! Splitting*, arXiv:2412.00343 (2024); K. Tuggle & R. Zanetti, J. Guid. Control Dyn. 41(3), 725-734 (2018); F. Faubel
//! & D. Klakow, 18th European Signal Processing Conference, 850-854 (2010). PyEst states `|x| = 1` for `sadl` and
//! computes what is said above.
//!
//! Criteria that measure `x` or the bend in the units of the variables (all but `wussos`, `wussolc` and `wussadl`)
//! depend on these units: here a radian of an angle counts as much as one of the eccentricity.
//!
//! # Where to find what
//! | file | idea |
//! |---|---|
//! | `criteria` | the names |
//! | `search` | the preferred direction of a Gaussian that a model moves |
//! | `local_flow` | the derivatives and sigma points that criteria look at |
//! | `first_order`, `second_order`, `sigma_points` | the criteria |
//! | `spectral` | where forms and quadratic maps are largest |

mod criteria;
mod first_order;
mod local_flow;
mod search;
mod second_order;
mod sigma_points;
mod spectral;

#[cfg(test)]
mod tests;

pub use criteria::Criterion;
pub use search::{Found, search};
pub use spectral::Preferred;

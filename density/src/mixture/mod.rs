//! Gaussian mixtures carried by the unscented transform (GMM-UT; Sun et al. 2022, Sect. 3.3).
//!
//! The initial Gaussian is split into components (Eq. 15), each component into sigma points (Eq. 17); the flow moves
//! the sigma points, and at a snapshot they give each component's mean and covariance in `(phi, e)` (Eq. 18). The
//! density is the weighted sum of the components (Eq. 14).
//!
//! ```text
//! settings -> split -> SigmaPoints -> PlanarMixturePropagator -> Mixture: rows (w, m_phi, m_e, P_phiphi, P_phie, P_ee)
//! rows, grid -> estimate -> Estimate
//! ```
//!
//! The two lines may run in different processes: only the rows pass between them.
//!
//! | file | idea |
//! |---|---|
//! | `settings`, `error` | the settings of a mixture, and what can be wrong with one |
//! | [`library`] | the best homoscedastic mixture for a standard normal in one dimension |
//! | [`split`] | the initial Gaussian as components along one or two directions |
//! | [`lattice`] | the same on an even lattice, where neighbours share their sigma points |
//! | [`plan`] | which lattice a given problem needs |
//! | [`direction`] | in which direction the flow of a given problem bends the cloud most |
//! | [`criterion`] | the splitting criteria of the literature by their names, in any number of variables |
//! | [`unscented`] | sigma points and the moments they carry |
//! | [`component`] | a component in any number of variables |
//! | `normal` | the normal distribution function and the exponential, as fast as bins need them |
//! | `pilot` | derivatives of the flow over the initial Gaussian, from a coarse lattice of orbits |
//! | [`planar_component`] | a component in the plane, and what of it lies above `e = 0` |
//! | [`propagator`] | the sigma points, moved from snapshot to snapshot |
//! | [`linearity`] | how far the flow over a component is from linear, which says when to distrust the density |
//! | [`merge`] | fewer components with the same mean and covariance |
//! | [`moments`], [`bins`] | the results of a mixture: moments, and bin averages of its density |
//! | `exact_joint` | the exact joint density, for the tests |
//! | [`any_model`] | the transform and the mixture over the variables of a model that is not planar |
//! | [`adaptive`] | the same, split where the flow is not linear |
//! | `splitting` | where and how the adaptive mixture is split |
//! | `fifth_degree` | the sigma points of the adaptive mixture, and how far its moments are off |
//! | `differences`, `triangular` | derivatives of the flow by differences, and square roots of covariances |
//! | `pieces`, `curvature`, `part` | its parts, how far the flow over a part is from linear and in which direction, and how far it may be |
//!
//! # What the paper's form can do and what it cannot
//! [`MixtureSettings::paper`] is the method of Table 3: 39 components split along `e` (the text says along `phi`, but
//! the numbers are those of a split along `e`), 195 sigma points. Means are accurate to 0.3 %, standard deviations to a
//! few per cent. The density is poor: the components stay a full `sigma_phi` wide in the direction that was not split,
//! and a Gaussian cannot follow where the flow bends them.
//!
//! The default, [`MixtureSettings::default`], plans an even lattice in both directions; its points are propagated once
//! through all snapshots. Measured (C = 0.15, W = 0.40921):
//!
//! | scenario | form | sigma points | components | worst moment | `L1` at 0.5, 1, ... yr |
//! |---|---|---|---|---|---|
//! | 1 | paper | 195 | 39 | 4.0 % | 0.06, 0.56, 0.16, 1.01 |
//! | 1 | default | 4,620 | 4,155 | 0.0006 % | 0.002, 0.003, 0.001, 0.001 |
//! | 2 | paper | 195 | 39 | 2.0 % | 0.01, 0.10, 1.46, 0.78, 0.21, 1.15 |
//! | 2 | default | 1,174 | 877 | 0.002 % | 0.004, 0.001, 0.006, 0.001, 0.001, 0.004 |
//! | 3 | paper | 195 | 39 | 9.4 % | 0.04, 0.19, 0.44, 0.53 |
//! | 3 | default | 1,962 | 1,641 | 0.02 % | 0.002, 0.002, 0.002, 0.002 |
//!
//! The number of sigma points counts all that were propagated, including the 161 of the plan's pilot. The worst moment
//! is the largest relative error of the two means and two standard deviations over the snapshots. `L1` is the integral
//! of the absolute difference from the exact joint density on the comparison grid of 100 x 100 bins, at most 2; the
//! exact density used here is itself accurate to about 0.002. The defaults (tolerance, reach) and
//! [`linearity::DISTRUST`] were chosen while looking at these same three scenarios; no other problem was tried.
//!
//! # Limits
//! Probabilities above `e_cri` far out in the tail (below about 1e-6) are those of Gaussians cut at 5.5 standard
//! deviations, not those of the flow: at two years in scenario 1 the exact value is 1e-12, and a mixture gives 1e-57. A
//! component that reaches across `e = 0` is not Gaussian in `(phi, e)`. In scenario 1 at two years the cloud passes the
//! origin at 3.3 standard deviations, which fine components survive (`L1` 0.001) and coarse ones do not.

pub mod adaptive;
pub mod any_model;
pub mod bins;
pub mod component;
pub mod criterion;
mod curvature;
mod differences;
pub mod direction;
mod error;
mod fifth_degree;
pub mod lattice;
pub mod library;
pub mod linearity;
pub mod merge;
pub mod moments;
mod normal;
mod part;
mod pieces;
mod pilot;
pub mod plan;
pub mod planar_component;
pub mod propagator;
mod settings;
pub mod split;
mod splitting;
mod triangular;
pub mod unscented;

#[cfg(test)]
mod exact_joint;
#[cfg(test)]
mod tests;

pub use error::MixtureError;
pub use moments::{estimate, mass_below_zero};
pub use planar_component::PlanarComponent;
pub use propagator::{Mixture, PlanarMixturePropagator};
pub use settings::{MixtureSettings, Split};

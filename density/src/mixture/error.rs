//! What can be wrong with a mixture or its settings.

use crate::flow::Escaped;

/// What can be wrong with a mixture or its settings.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MixtureError {
    /// A library that cannot be made.
    #[error("a splitting library has an odd number of components from 1 (no split) to {most}, not {components}")]
    LibrarySize {
        /// The number asked for.
        components: usize,
        /// The largest number.
        most: usize,
    },
    /// A library whose optimisation did not converge.
    #[error("the splitting library of {0} components did not converge; choose another odd number of components")]
    LibraryDiverged(usize),
    /// Sigma points at no distance from their centre.
    #[error("n + zeta = alpha² (n + beta) must be positive and finite, but is {0}")]
    SigmaDistance(f64),
    /// Covariance weights that can make a variance negative.
    #[error("the central covariance weight is {weight}; below {least} a variance can turn negative: raise eta")]
    CovarianceWeight {
        /// The weight that the parameters give.
        weight: f64,
        /// The smallest weight that is safe.
        least: f64,
    },
    /// Lattice spacings that cannot reproduce the initial Gaussian.
    #[error(
        "a lattice needs a spacing above 0 and below {limit:.3} standard deviations in both directions \
         and a reach from 3 to 8, not spacings {spacing:?} and reach {reach}"
    )]
    Lattice {
        /// The spacings given.
        spacing: [f64; 2],
        /// The reach given.
        reach: f64,
        /// The spacing they must stay below.
        limit: f64,
    },
    /// A plan without room.
    #[error("a plan needs a tolerance above 0 and at least {least} sigma points, not {tolerance} and {points}")]
    SplitPlan {
        /// The tolerance given.
        tolerance: f64,
        /// The sigma points allowed.
        points: usize,
        /// The smallest number of sigma points that is enough.
        least: usize,
    },
    /// No part of the initial Gaussian is inside `0 < e < 1`.
    #[error(
        "no component of the initial Gaussian has all its sigma points inside 0 < e < 1; check its mean and deviation"
    )]
    NothingInside,
    /// A snapshot time that is not a finite number.
    #[error("cannot propagate to t = {0} yr; a snapshot time is a finite number")]
    Time(f64),
    /// A row that is not a Gaussian.
    #[error(
        "component {index} is no Gaussian: {row:?} (w, m_phi, m_e, P_phiphi, P_phie, P_ee) must be finite, the weight not \
         negative, the variances positive and the covariance not indefinite"
    )]
    NoGaussian {
        /// Index of the component.
        index: usize,
        /// Its row.
        row: [f64; 6],
    },
    /// A mixture without probability.
    #[error("the mixture has no weight: it needs at least one component of positive weight")]
    Weightless,
    /// A sigma point could not be followed by the equations of motion.
    #[error("a sigma point cannot be propagated")]
    Escaped(#[from] Escaped),
}

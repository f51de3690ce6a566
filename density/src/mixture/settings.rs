//! The settings of a mixture method.

use super::{lattice, library, plan, split, unscented};

/// Settings of a mixture method.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MixtureSettings {
    /// How the initial Gaussian is split.
    pub split: Split,
    /// How the sigma points of a component are placed and weighed.
    pub unscented: unscented::Unscented,
}

impl MixtureSettings {
    /// Table 3 of the paper: 39 components along `e`, `alpha = 0.8`, `beta = 0`, `eta = 2`.
    pub fn paper() -> Self {
        Self {
            split: Split::Library {
                along: split::Direction::Eccentricity,
                components: 39,
                across: 1,
                variance: library::Variance::Free,
            },
            unscented: unscented::Unscented::PAPER,
        }
    }
}

/// How the initial Gaussian is split. All lengths are in standard deviations of the initial Gaussian.
#[derive(Debug, Clone, PartialEq)]
pub enum Split {
    /// By the univariate splitting library (Eq. 15): `components` along a direction times `across` perpendicular to it.
    /// Both are odd; 1 does not split.
    Library {
        /// The direction.
        along: split::Direction,
        /// Components along it.
        components: usize,
        /// Components perpendicular to it.
        across: usize,
        /// Whether the library keeps the variance.
        variance: library::Variance,
    },
    /// On a given lattice.
    Lattice(lattice::Lattice),
    /// On a lattice planned for the problem.
    Adaptive(plan::Adaptive),
}

impl Default for Split {
    fn default() -> Self {
        Self::Adaptive(plan::Adaptive::default())
    }
}

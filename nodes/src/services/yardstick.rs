//! What a figure is compared with at a snapshot: the first reference that states it.
//!
//! A method may withhold a figure (NaN in a message). Each quantity is a figure of its own, and all densities
//! together are one figure. A reference that has failed states nothing.

use crate::services::reading::Reading;
use density::trust::Diagnosis;
use kit::diagnosis;
use kit::space::{Quantity, Space};

/// A figure that is stated or withheld as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Figure {
    /// A quantity of the cloud.
    Quantity(Quantity),
    /// The densities on all projections.
    Densities,
}

impl Figure {
    /// All figures of a space.
    pub fn all(space: &Space) -> impl Iterator<Item = Self> {
        space.quantities().into_iter().map(Self::Quantity).chain([Self::Densities])
    }

    /// Its name in a sentence.
    pub fn in_words(self, space: &Space) -> String {
        match self {
            Self::Quantity(quantity) => space.in_words(quantity),
            Self::Densities => "the joint density".into(),
        }
    }

    /// Whether a snapshot states it.
    pub fn is_stated(self, reading: &Reading) -> bool {
        match self {
            Self::Quantity(quantity) => reading.value(quantity).is_finite(),
            Self::Densities => reading.header.mass_on_grid.is_finite(),
        }
    }

    /// The method's own estimate of the figure's error, in the units of [`Diagnosis::Stated`]; NaN if it has
    /// none.
    pub fn error_estimate(self, reading: &Reading) -> f64 {
        let Diagnosis::Stated { moments, resultant, probability, joint } = diagnosis::of(&reading.header) else {
            return f64::NAN;
        };
        match self {
            Self::Quantity(Quantity::AboveCritical) => probability,
            Self::Quantity(Quantity::CircularMean(_) | Quantity::ResultantLength(_)) => resultant,
            Self::Quantity(Quantity::Mean(_) | Quantity::Deviation(_) | Quantity::Covariance(..)) => moments,
            Self::Densities => joint,
        }
    }
}

/// The label of the first of the references, given by label and snapshot, that states a figure.
pub fn stand_for<'l, 'r>(
    references: impl IntoIterator<Item = (&'l str, &'r Reading)>,
    figure: Figure,
) -> Option<&'l str> {
    references.into_iter().find(|(_, reading)| figure.is_stated(reading)).map(|(label, _)| label)
}

//! What a figure is compared with at a snapshot: the first reference that states it.
//!
//! A method may withhold a figure (NaN in a message). Each quantity is a figure of its own, and all densities
//! together are one figure. A reference that has failed states nothing.

use messages::layout::diagnostic;

use crate::services::reading::Reading;
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

    /// The method's own estimate of the figure's error, in the units of [`diagnostic::NUMERICAL`]; NaN if it has
    /// none.
    pub fn error_estimate(self, reading: &Reading) -> f64 {
        let [moments, circular, probability, joint] = reading.header.diagnostics;
        match self {
            _ if reading.header.diagnostic != diagnostic::NUMERICAL => f64::NAN,
            Self::Quantity(Quantity::AboveCritical) => probability,
            Self::Quantity(Quantity::CircularMean(_) | Quantity::ResultantLength(_)) => circular,
            Self::Quantity(_) => moments,
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

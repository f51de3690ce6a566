//! How accurate a probability is to be.

/// Target for the absolute error of probabilities.
pub(crate) const PROBABILITY_ERROR: f64 = 1e-9;
/// Probabilities below this value need no correct digits.
const SMALLEST_PROBABILITY: f64 = 1e-15;

/// Target for the relative error of rare probabilities.
const RELATIVE_ERROR: f64 = 1e-6;

/// How accurate a probability is to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ProbabilityTolerance {
    /// To an absolute error, and rare ones to a relative one.
    RareToo(f64),
    /// To an absolute error alone, for one of many probabilities of which a mean is taken.
    Absolute(f64),
}

impl ProbabilityTolerance {
    /// The tolerance of this probability.
    pub(crate) fn of(self, probability: f64) -> f64 {
        match self {
            Self::RareToo(absolute) => {
                absolute.min(RELATIVE_ERROR * probability.abs()).max(RELATIVE_ERROR * SMALLEST_PROBABILITY)
            }
            Self::Absolute(absolute) => absolute,
        }
    }

    /// The tolerance of a probability that is not rare.
    pub(crate) fn absolute(self) -> f64 {
        let (Self::RareToo(absolute) | Self::Absolute(absolute)) = self;
        absolute
    }
}

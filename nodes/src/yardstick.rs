//! What a quantity is compared with at a snapshot: the first reference that states it.
//!
//! A method may withhold what it does not stand behind (NaN in a message). Each moment is a quantity of its own, joint density and
//! marginals are one. A reference that has failed states nothing.

use messages::layout::{DensityHeader, diagnostic};

use crate::comparator::QUANTITIES;

/// What is stated or withheld as one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// One of [`QUANTITIES`], by its position.
    Moment(usize),
    /// The joint density and both marginals.
    Densities,
}

impl Quantity {
    /// All there are.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..QUANTITIES.len()).map(Self::Moment).chain([Self::Densities])
    }

    /// Its name in a sentence.
    pub fn in_words(self) -> &'static str {
        const MOMENTS: [&str; QUANTITIES.len()] = [
            "the mean of phi",
            "the deviation of phi",
            "the mean of e",
            "the deviation of e",
            "the covariance",
            "the probability above the critical eccentricity",
            "the circular mean of phi",
            "the resultant length of phi",
        ];
        match self {
            Self::Moment(moment) => MOMENTS.get(moment).copied().unwrap_or("a moment"),
            Self::Densities => "the joint density",
        }
    }

    /// Whether a snapshot states it.
    pub fn is_stated(self, header: &DensityHeader) -> bool {
        match self {
            Self::Moment(moment) => values_of(header).get(moment).is_some_and(|value| value.is_finite()),
            Self::Densities => header.mass_on_grid.is_finite(),
        }
    }

    /// The method's own estimate of its error, in the units of [`diagnostic::NUMERICAL`]; NaN if it has none.
    pub fn error_estimate(self, header: &DensityHeader) -> f64 {
        let [moments, circular, probability, joint] = header.diagnostics;
        match self {
            _ if header.diagnostic != diagnostic::NUMERICAL => f64::NAN,
            Self::Moment(5) => probability,
            Self::Moment(6 | 7) => circular,
            Self::Moment(_) => moments,
            Self::Densities => joint,
        }
    }
}

/// The moments of a snapshot in the order of [`QUANTITIES`].
pub fn values_of(header: &DensityHeader) -> [f64; QUANTITIES.len()] {
    let [a, b, c, d, e, f] = header.moments;
    [a, b, c, d, e, f, header.circular_mean, header.resultant]
}

/// The label of the first of the references, given by label and snapshot, that states a quantity.
pub fn stand_for<'l, 'h>(
    references: impl IntoIterator<Item = (&'l str, &'h DensityHeader)>,
    quantity: Quantity,
) -> Option<&'l str> {
    references.into_iter().find(|(_, header)| quantity.is_stated(header)).map(|(label, _)| label)
}

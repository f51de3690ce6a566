//! Gaussian mixtures.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use super::{Kind, kind, split};
use crate::describe::{Described, Field, FieldType, header};

header! {
    /// The details of a mixture.
    #[type_name("phasecloud/SnapshotHeader/5/Mixture")]
    pub struct MixtureDetails {
        /// How far the flow over a component is from linear, as a weighted mean over the components; NaN if not
        /// known.
        pub disagreement: f64,
    }
}

/// A Gaussian mixture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mixture {
    /// How far the flow over a component is from linear, as a weighted mean over the components; NaN if not known.
    pub disagreement: f64,
}

impl Mixture {
    /// A mixture for which it is not known how far the flow over a component is from linear.
    pub const UNJUDGED: Self = Self { disagreement: f64::NAN };

    /// Writes a component into its row: its weight, its means, and the upper triangle of its covariance, row by row.
    /// In the plane these are weight, mean `phi` \[rad\], mean `e`, variance of `phi` \[rad²\], covariance \[rad\],
    /// variance of `e`.
    pub fn write_row<const N: usize>(items: &mut [f64], row: usize, component: [f64; N]) {
        for (column, value) in split::<N>(items).into_iter().zip(component) {
            column[row] = value;
        }
    }
}

impl Kind for Mixture {
    const CODE: u32 = kind::MIXTURE;
    const COLUMNS: &'static [&'static str] =
        &["weight", "mean phi [rad]", "mean e", "variance of phi [rad²]", "covariance [rad]", "variance of e"];
    type Details = MixtureDetails;

    fn column_count(variables: usize) -> usize {
        1 + variables + variables * (variables + 1) / 2
    }

    fn to_details(self) -> MixtureDetails {
        MixtureDetails { disagreement: self.disagreement }
    }

    fn from_details(MixtureDetails { disagreement }: MixtureDetails) -> Result<Self, String> {
        Ok(Self { disagreement })
    }
}

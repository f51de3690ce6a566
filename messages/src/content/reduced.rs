//! Samples that their propagator has reduced to counts and sums.

use super::{Kind, NoDetails, kind};

/// Samples that their propagator has reduced to counts and sums.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reduced;

impl Kind for Reduced {
    const CODE: u32 = kind::REDUCED;
    const COLUMNS: &'static [&'static str] = &["counts and sums of samples"];
    type Details = NoDetails;

    fn column_count(_: usize) -> usize {
        1
    }

    fn to_details(self) -> NoDetails {
        NoDetails::default()
    }

    fn from_details(_: NoDetails) -> Result<Self, String> {
        Ok(Self)
    }
}

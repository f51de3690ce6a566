//! Densities that the propagator itself has put on the comparison grid.

use super::{Kind, NoDetails, kind};

/// Numbers before the joint density in a snapshot of kind [`kind::DENSITY`] in the plane; with more variables there are
/// more moments.
pub const DENSITY_HEAD: usize = 12;

/// A density on the comparison grid, with its moments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Density;

impl Kind for Density {
    const CODE: u32 = kind::DENSITY;
    const COLUMNS: &'static [&'static str] = &["moments, error estimates, joint density [1/rad]"];
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

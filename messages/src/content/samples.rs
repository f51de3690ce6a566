//! Equally weighted samples.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use super::{Kind, kind, split};
use crate::describe::{Described, Field, FieldType, header};

header! {
    /// The details of samples.
    #[type_name("phasecloud/SnapshotHeader/5/Samples")]
    pub struct SamplesDetails {
        /// Number of independent groups in which the samples were drawn: consecutive pairs of samples belong to the
        /// groups in turn; 0 or 1 if all samples are independent.
        pub replicates: u32,
        /// 0.
        pub reserved: u32,
    }
}

/// Equally weighted samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Samples {
    /// Number of independent groups in which the samples were drawn: consecutive pairs of samples belong to the
    /// groups in turn; 0 or 1 if all samples are independent.
    pub replicates: u32,
}

impl Samples {
    /// Samples that do not depend on one another.
    pub const INDEPENDENT: Self = Self { replicates: 0 };

    /// The columns to write, one per variable of the scenario: in the plane `phi` \[rad\] and `e`.
    pub fn columns<const N: usize>(items: &mut [f64]) -> [&mut [f64]; N] {
        split(items)
    }
}

impl Kind for Samples {
    const CODE: u32 = kind::SAMPLES;
    const COLUMNS: &'static [&'static str] = &["phi [rad]", "e"];
    type Details = SamplesDetails;

    fn column_count(variables: usize) -> usize {
        variables
    }

    fn to_details(self) -> SamplesDetails {
        SamplesDetails { replicates: self.replicates, reserved: 0 }
    }

    fn from_details(SamplesDetails { replicates, .. }: SamplesDetails) -> Result<Self, String> {
        Ok(Self { replicates })
    }
}

//! Points that carry a density along, and how the estimator computes the density from them.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use super::{Kind, kind, split, treatment};
use crate::describe::{Described, Field, FieldType, header};

header! {
    /// The details of characteristics.
    #[type_name("phasecloud/SnapshotHeader/5/Characteristics")]
    pub struct CharacteristicsDetails {
        /// How to estimate the density, see [`treatment`].
        pub treatment: u32 [codes treatment::CODES],
        /// Hull meshes only: interpolation points per axis (the paper's Ngrid), at most 20,000.
        pub resolution: u32,
        /// Carried meshes only: points per side if the initial points form a square lattice in `e` and in `phi` less
        /// its mean given `e`, with `phi` outermost; else 0. Where the radiation parameter is uncertain they form as
        /// many such lattices, one after the other, at ascending and evenly spaced values of the third variable.
        pub lattice: u32,
        /// Carried lattices only: degree to which the flow is interpolated between the points; 0 or 1 is linear.
        pub degree: u32,
    }
}

/// Points that carry a density along, and how the estimator computes the density from them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Characteristics {
    /// Triangles of the initial points, carried by the flow, each with its probability.
    CarriedMesh {
        /// Points per side and degree of interpolation, if the initial points form a square lattice.
        lattice: Option<Lattice>,
    },
    /// Delaunay triangulation of the final points and linear interpolation of `n`.
    HullMesh {
        /// Interpolation points per axis.
        resolution: u32,
        /// Whether `phi` is cut open at 0, as the paper printed it.
        as_printed: bool,
    },
}

/// A square lattice of initial points, `phi` outermost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lattice {
    /// Points per side.
    pub side: u32,
    /// Degree to which the flow is interpolated between the points; 1 is linear.
    pub degree: u32,
}

/// Most interpolation points per axis of a hull mesh: four times as many as in the paper. The interpolation may take
/// that many steps for each triangle.
pub const MOST_RESOLUTION: u32 = 20_000;

impl Characteristics {
    /// The columns to write: `phi` \[rad\], `e` and the density `n` \[1/rad\].
    pub fn columns(items: &mut [f64]) -> [&mut [f64]; 3] {
        split(items)
    }
}

impl Kind for Characteristics {
    const CODE: u32 = kind::CHARACTERISTICS;
    const COLUMNS: &'static [&'static str] = &["phi [rad]", "e", "n [1/rad]"];
    type Details = CharacteristicsDetails;

    fn column_count(variables: usize) -> usize {
        variables + 1
    }

    fn to_details(self) -> CharacteristicsDetails {
        let unset = CharacteristicsDetails::default();
        match self {
            Self::CarriedMesh { lattice: None } => {
                CharacteristicsDetails { treatment: treatment::CARRIED_MESH, ..unset }
            }
            Self::CarriedMesh { lattice: Some(Lattice { side, degree }) } => {
                CharacteristicsDetails { treatment: treatment::CARRIED_MESH, lattice: side, degree, ..unset }
            }
            Self::HullMesh { resolution, as_printed } => {
                let treatment = if as_printed { treatment::HULL_MESH_AS_PRINTED } else { treatment::HULL_MESH };
                CharacteristicsDetails { treatment, resolution, ..unset }
            }
        }
    }

    fn from_details(details: CharacteristicsDetails) -> Result<Self, String> {
        let CharacteristicsDetails { treatment, resolution, lattice, degree } = details;
        let hull = |as_printed| match resolution {
            0..=MOST_RESOLUTION => Ok(Self::HullMesh { resolution, as_printed }),
            _ => Err(format!("its resolution is {resolution}, at most {MOST_RESOLUTION} are interpolated")),
        };
        match treatment {
            treatment::CARRIED_MESH => {
                let lattice = (lattice > 0).then_some(Lattice { side: lattice, degree: degree.max(1) });
                Ok(Self::CarriedMesh { lattice })
            }
            treatment::HULL_MESH => hull(false),
            treatment::HULL_MESH_AS_PRINTED => hull(true),
            other => Err(format!("its treatment {other} is unknown to this version")),
        }
    }
}

//! The settings of a DEE case.

use density::mesh::Placement;
use density::mesh::lattice::MOST_DEGREE;
use density::mesh::stack::cubic_side;
use kit::failure::Failure;
use kit::shard::Shard;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::files::input::{Mode, natural_option, positive, positive_option};
use crate::files::toml_words::{choice, choice_option};
use crate::methods::Misfit;
use crate::methods::accuracy::AccuracySetting;
use crate::methods::lattice_degree::usual_degree;

/// Where the characteristics start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PlacementChoice {
    /// Random draws from the initial Gaussian, as in the paper.
    Random,
    /// A square lattice.
    Lattice,
    /// A low-discrepancy sequence through the initial Gaussian.
    LowDiscrepancy,
}

/// How scattered densities become a density on the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MeshChoice {
    /// Triangles of the initial points, carried by the flow, each with its probability.
    Carried,
    /// Delaunay triangulation of the final points and linear interpolation, as in the paper.
    Hull,
}

/// Settings of a DEE case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Number of characteristics; on a lattice the largest square number up to it, and where the radiation parameter is
    /// uncertain the largest cubic number up to four times it.
    #[serde(deserialize_with = "positive")]
    pub samples: usize,
    /// Seed of points that are not on a lattice; 1 unless set.
    #[serde(deserialize_with = "natural_option", skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Where the characteristics start; by default on a lattice, in mode `as-printed` at random points.
    #[serde(deserialize_with = "choice_option", skip_serializing_if = "Option::is_none")]
    pub placement: Option<PlacementChoice>,
    /// How the density is computed; by default on a carried mesh, in mode `as-printed` on a hull mesh.
    #[serde(deserialize_with = "choice_option", skip_serializing_if = "Option::is_none")]
    pub mesh: Option<MeshChoice>,
    /// Interpolation points per axis of a hull mesh, the paper's Ngrid; 5000 unless set.
    #[serde(deserialize_with = "positive_option", skip_serializing_if = "Option::is_none")]
    pub resolution: Option<usize>,
    /// Degree to which a lattice interpolates between its points; 1 is linear. Unless set, it is 7, or the largest
    /// that fits.
    #[serde(deserialize_with = "positive_option", skip_serializing_if = "Option::is_none")]
    pub degree: Option<usize>,
    /// Corrected, or as the paper printed it: without the Jacobian, random points, hull interpolation.
    #[serde(deserialize_with = "choice")]
    pub mode: Mode,
    /// How accurately orbits are propagated; the launch file's `accuracy` unless set here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracySetting>,
}

/// With a third variable there are so many times the points of a case in the plane.
pub(super) const LAYERS: usize = 4;

/// Points at which the flow is read out in space.
pub(super) const POINTS: usize = 1 << 18;

/// Why a lattice with `side` points per side cannot have the degree `degree`.
pub(super) fn degree_problem(degree: usize, side: usize) -> String {
    if degree > MOST_DEGREE {
        return format!("{degree} is not allowed, it must be at most {MOST_DEGREE}");
    }
    let (least, most) = ((degree + 1).pow(2), side - 1);
    format!(
        "{degree} does not fit a lattice of {side} points per side; it must be at most {most}, or samples at least {least}"
    )
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            samples: 100_000,
            seed: None,
            placement: None,
            mesh: None,
            resolution: None,
            degree: None,
            mode: Mode::default(),
            accuracy: None,
        }
    }
}

impl Settings {
    /// Whether all that is set changes something.
    pub(super) fn check_effects(&self) -> Result<(), Misfit> {
        let on_lattice = self.placement() == Placement::Lattice;
        let carried = self.mesh() == MeshChoice::Carried;
        if self.seed.is_some() && on_lattice {
            return Err(Misfit::no_effect("seed", "where the points are on a lattice (placement = \"lattice\")"));
        }
        if self.degree.is_some() && !on_lattice {
            return Err(Misfit::no_effect("degree", "where the points are not on a lattice"));
        }
        if self.resolution.is_some() && carried {
            return Err(Misfit::no_effect("resolution", "where the mesh is carried; it is that of mesh = \"hull\""));
        }
        if self.mode == Mode::AsPrinted && self.placement.is_some() && carried {
            return Err(Misfit::no_effect("mode", "beside placement and mesh = \"carried\""));
        }
        Ok(())
    }

    /// The seed that is set, else 1.
    pub(super) fn seed(&self) -> u64 {
        self.seed.unwrap_or(1)
    }

    /// Interpolation points per axis of a hull mesh.
    pub(super) fn resolution(&self) -> usize {
        self.resolution.unwrap_or(5000)
    }

    /// Points per side of a lattice.
    pub(super) fn side(&self) -> usize {
        self.samples.isqrt()
    }

    /// The degree that is set, else the usual one.
    pub(super) fn degree(&self) -> usize {
        self.degree.unwrap_or_else(|| usual_degree(self.side()))
    }

    /// The degree for a lattice of `side` points per side where the radiation parameter is uncertain.
    fn degree_of(&self, side: usize) -> Result<usize, String> {
        match self.degree {
            Some(degree) if degree > MOST_DEGREE || degree >= side => {
                let (least, most) = ((degree + 1).pow(3).div_ceil(LAYERS), side.saturating_sub(1));
                Err(format!(
                    "degree: {degree} does not fit a cubic lattice of {side} points per side; it must be at most {most}, or samples at \
                     least {least}"
                ))
            }
            Some(degree) => Ok(degree),
            None => Ok(usual_degree(side)),
        }
    }

    /// The degree of the polynomials between layers, if the settings are for a scenario whose radiation parameter is
    /// uncertain.
    pub(super) fn check_layers(&self) -> Result<usize, String> {
        self.check_uncertain()?;
        self.degree_of(cubic_side(LAYERS.saturating_mul(self.samples)))
    }

    /// Whether the settings are for a scenario whose radiation parameter is uncertain.
    fn check_uncertain(&self) -> Result<(), String> {
        if self.placement() == Placement::Lattice && self.mesh() == MeshChoice::Carried {
            return Ok(());
        }
        Err("where the radiation parameter is uncertain, dee takes placement = \"lattice\" and mesh = \"carried\" alone, which are the \
             defaults of mode = \"corrected\""
            .into())
    }

    pub(super) fn placement_choice(&self) -> PlacementChoice {
        self.placement.unwrap_or(match self.mode {
            Mode::Corrected => PlacementChoice::Lattice,
            Mode::AsPrinted => PlacementChoice::Random,
        })
    }

    /// Where the characteristics start, in the terms of the science.
    pub(super) fn placement(&self) -> Placement {
        match self.placement_choice() {
            PlacementChoice::Random => Placement::Random,
            PlacementChoice::Lattice => Placement::Lattice,
            PlacementChoice::LowDiscrepancy => Placement::LowDiscrepancy,
        }
    }

    /// The mesh that is set, else that of the mode.
    pub(super) fn mesh(&self) -> MeshChoice {
        self.mesh.unwrap_or(match self.mode {
            Mode::Corrected => MeshChoice::Carried,
            Mode::AsPrinted => MeshChoice::Hull,
        })
    }

    /// Whether the settings are for clouds in space.
    ///
    /// # Errors
    /// [`Failure::Refused`] with a setting that is for the plane.
    pub(super) fn check_in_space(&self, shard: Shard) -> Result<(), Failure> {
        let Self { placement, mesh, mode, .. } = self;
        let wrong = match () {
            () if *mode == Mode::AsPrinted => "mode = \"as-printed\"",
            () if placement.is_some_and(|placement| placement != PlacementChoice::Lattice) => "placement",
            () if mesh.is_some_and(|mesh| mesh != MeshChoice::Carried) => "mesh",
            () if !shard.is_whole() => "shards",
            () => return Ok(()),
        };
        Err(Failure::Refused(format!(
            "{wrong}: in space dee reads out the flow between characteristics on a lattice that it chooses itself; it takes samples, which is the most \
             characteristics, and accuracy alone; degree has no effect"
        )))
    }
}

#[cfg(test)]
mod tests;

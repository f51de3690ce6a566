//! What the processes know of each kind of snapshot: the registry.
//!
//! A kind is one file here, with an `impl` of [`Kind`] for its content, and one line of [`of`]. Its columns and its fields are
//! declared in [`messages::content`]. Beyond these files only `phasecloud check` asks which kind a snapshot is of, for rules of its own.

mod characteristics;
mod mixture;
mod ready_density;
mod reduced;
mod samples;

use density::estimate::Estimate;
use density::grid::Grid;
use density::mesh::CarriedMesh;
use messages::content::{Content, kind as code};
use messages::layout::{DensityHeader, SnapshotHeader, diagnostic};

use crate::assignment::Assignment;
use crate::carried_density::CarriedDensity;
use crate::snapshot_rules::{Breach, Rule};

pub use samples::groups;

/// A kind of snapshot, with the fields that its content has.
pub trait Kind {
    /// The first number that cannot be right in columns that are `rows` long each.
    fn breach(&self, rows: usize, items: &[f64]) -> Option<Breach>;

    /// Whether a density on a grid of so many bins can be made of it.
    ///
    /// # Errors
    /// Why not.
    fn check_grid(&self, _bins: (usize, usize)) -> Result<(), String> {
        Ok(())
    }

    /// The density of a snapshot on a grid, its moments, and what the method says of its own reliability.
    ///
    /// # Errors
    /// What makes the numbers impossible.
    fn estimate(&self, snapshot: &Snapshot, memory: &mut Memory, at: &Place) -> Result<Estimated, String>;

    /// What a snapshot says that was put together of those of all shards.
    ///
    /// # Errors
    /// Why snapshots of this kind cannot be split.
    fn of_all_shards(&self) -> Result<Content, String>;

    /// Whether a shard sends the rows of its range, one for each of the whole's.
    fn has_a_row_for_each(&self) -> bool {
        true
    }

    /// Whether it can be reduced before it is sent.
    fn may_be_reduced(&self) -> bool {
        false
    }

    /// Whether its sender may withhold numbers, by NaN.
    fn may_withhold(&self) -> bool {
        false
    }

    /// Whether a sender that withholds what it may has stated nothing at all.
    fn withholds_all(&self, _items: &[f64]) -> bool {
        false
    }

    /// What its rows are of trajectories: points whose first columns are the variables of an orbit.
    fn trajectories(&self) -> Trajectories {
        Trajectories::None
    }
}

/// What the rows of a snapshot are of trajectories.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trajectories {
    /// None.
    None,
    /// Points of trajectories, which may change places from snapshot to snapshot.
    Unordered,
    /// Points of trajectories that keep their places.
    Ordered,
}

/// What is known of a content's kind.
pub fn of(content: &Content) -> &dyn Kind {
    match content {
        Content::Samples(samples) => samples,
        Content::Characteristics(characteristics) => characteristics,
        Content::Mixture(mixture) => mixture,
        Content::Density(density) => density,
        Content::Reduced(reduced) => reduced,
    }
}

/// The samples that a density was counted from; `None` if it is of something else.
pub fn counted_samples(density: &DensityHeader) -> Option<u32> {
    (density.kind == code::SAMPLES).then_some(density.rows)
}

/// Trajectories behind a density: its samples or characteristics, or the five sigma points of each component of a mixture
/// (shared ones counted for each); NaN of a method that follows none.
pub fn trajectories_behind(density: &DensityHeader) -> f64 {
    match density.kind {
        code::SAMPLES | code::CHARACTERISTICS => f64::from(density.rows),
        code::MIXTURE => 5.0 * f64::from(density.rows),
        _ => f64::NAN,
    }
}

/// A snapshot that has been decoded.
#[derive(Debug, Clone, Copy)]
pub struct Snapshot<'a> {
    /// Its header.
    pub header: &'a SnapshotHeader,
    /// What its header says that it is.
    pub content: Content,
    /// Its columns, one after the other.
    pub items: &'a [f64],
}

impl Snapshot<'_> {
    /// Its columns, of which its kind has `N`.
    ///
    /// # Errors
    /// If there are not so many.
    pub fn columns<const N: usize>(&self) -> Result<[&[f64]; N], String> {
        let columns: Vec<&[f64]> = self.items.chunks_exact(self.header.rows.max(1) as usize).collect();
        let count = columns.len();
        columns.try_into().map_err(|_| format!("it has {count} columns, its kind has {N}"))
    }
}

/// Where a snapshot belongs.
#[derive(Debug)]
pub struct Place<'a> {
    /// The scenario.
    pub assignment: &'a Assignment,
    /// The comparison grid at its time.
    pub grid: Grid,
}

/// What is remembered of a case between its snapshots.
#[derive(Debug, Default)]
pub struct Memory {
    mesh: Option<CarriedMesh>,
    carried: Option<CarriedDensity>,
}

/// A density, and what the method says of its own reliability.
#[derive(Debug)]
pub struct Estimated {
    /// The density.
    pub estimate: Estimate,
    /// What the diagnostics are, see [`messages::layout::diagnostic`].
    pub diagnostic: u32,
    /// The diagnostics; NaN where there is nothing to say.
    pub diagnostics: [f64; 4],
    /// Of characteristics on a carried mesh: how far their densities are off from what the points imply; else NaN.
    pub carried_density_error: f64,
    /// How many samples there are, if they were reduced before they came here.
    pub reduced: Option<u32>,
}

impl From<Estimate> for Estimated {
    fn from(estimate: Estimate) -> Self {
        Self {
            estimate,
            diagnostic: diagnostic::NONE,
            diagnostics: [f64::NAN; 4],
            carried_density_error: f64::NAN,
            reduced: None,
        }
    }
}

/// The first number that is not finite.
fn not_finite(rows: usize, items: &[f64]) -> Option<Breach> {
    let position = items.iter().position(|value| !value.is_finite())?;
    let (column, row) = (position / rows, position % rows);
    Some(Breach { rule: Rule::Finite, what: format!("row {row} of column {column} is {}", items[position]) })
}

/// The first number of trajectories that is not finite, or the first eccentricity that none can have, in the second column.
fn not_of_trajectories(rows: usize, items: &[f64]) -> Option<Breach> {
    let no_eccentricity = || {
        let e = items.get(rows..2 * rows)?;
        let row = e.iter().position(|e| !(0.0..1.0).contains(e))?;
        let what = format!("row {row} has e = {}, outside [0, 1)", e[row]);
        Some(Breach { rule: Rule::Eccentricity, what })
    };
    not_finite(rows, items).or_else(no_eccentricity)
}

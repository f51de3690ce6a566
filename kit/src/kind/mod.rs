//! The registry of the kinds of snapshots: how each kind is checked and estimated.
//!
//! Each kind has one file here, with an `impl` of [`Kind`] for its content, and one line in [`of`]. Its columns and its
//! fields are declared in [`messages::content`]. Beyond these files kinds of snapshots are told apart in
//! [`counted_samples`], where one of them is made (each propagator makes one kind, and [`crate::reduced`] another), by
//! the rules of `phasecloud check` that hold for single kinds, and where the Python package gives the columns of a
//! snapshot their names.

mod characteristics;
mod mixture;
mod ready_density;
mod reduced;
mod samples;

use density::angle::Circular;
use density::estimate::Estimate;
use density::grid::{Axis, Grid};
use density::mesh::CarriedMesh;
use density::model::registry::Planar;
use density::problem::Problem;
use density::projected::{Cloud, Projection, Question};
use density::trust::Diagnosis;
use messages::content::{Content, SnapshotKind};
use messages::layout::{DensityHeader, SnapshotHeader};
use messages::scenario::Range;

use crate::assignment::Assignment;
use crate::breach::{Breach, Rule};
use crate::carried_density::CarriedDensity;
use crate::space::{Quantity, Space};

pub use samples::groups;

/// A kind of snapshot, with the fields that its content has.
pub trait Kind {
    /// The first number that cannot be right in columns of `rows` numbers, of a cloud in this space.
    fn breach(&self, space: &Space, rows: usize, items: &[f64]) -> Option<Breach>;

    /// Checks that a density can be computed from it on axes with at most this number of bins.
    ///
    /// # Errors
    /// Why not.
    fn check_grid(&self, _bins: usize) -> Result<(), String> {
        Ok(())
    }

    /// The density of a snapshot on a grid, its moments, and the method's diagnostics.
    ///
    /// # Errors
    /// What makes the numbers impossible.
    fn estimate(&self, snapshot: &Snapshot, memory: &mut Memory, at: &Place) -> Result<Estimated, String>;

    /// The content of the snapshot that is put together from those of all shards.
    ///
    /// # Errors
    /// Why snapshots of this kind cannot be split.
    fn of_all_shards(&self) -> Result<Content, String>;

    /// Whether a shard sends one row for each row of its range.
    fn has_a_row_for_each(&self) -> bool {
        true
    }

    /// Whether it can be reduced before it is sent.
    fn may_be_reduced(&self) -> bool {
        false
    }

    /// Whether its sender may withhold numbers by writing NaN.
    fn may_withhold(&self) -> bool {
        false
    }

    /// Whether it has columns of NaN, for variables that its sender's model does not have.
    fn lacks_variables(&self, _rows: usize, _items: &[f64]) -> bool {
        false
    }

    /// Whether the sender has withheld everything that it may withhold, so that the snapshot states nothing.
    fn withholds_all(&self, _items: &[f64]) -> bool {
        false
    }

    /// Whether its rows are points of trajectories, with the variables of an orbit in the first columns.
    fn trajectories(&self) -> Trajectories {
        Trajectories::None
    }
}

/// Whether the rows of a snapshot are points of trajectories.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trajectories {
    /// They are not.
    None,
    /// They are, and may change places from snapshot to snapshot.
    Unordered,
    /// They are, and keep their places.
    Ordered,
}

/// The rules and methods of a content's kind.
pub fn of(content: &Content) -> &dyn Kind {
    match content {
        Content::Samples(samples) => samples,
        Content::Characteristics(characteristics) => characteristics,
        Content::Mixture(mixture) => mixture,
        Content::Density(density) => density,
        Content::Reduced(reduced) => reduced,
    }
}

/// Number of samples from which a density was counted; `None` if it was not counted from samples.
pub fn counted_samples(density: &DensityHeader) -> Option<u32> {
    (SnapshotKind::of_code(density.kind) == Some(SnapshotKind::Samples)).then_some(density.rows)
}

/// Trajectories that were followed for a snapshot, as its propagator counts them. If it does not say, each row counts
/// as one where rows are points of trajectories.
pub fn trajectories_behind(snapshot: &SnapshotHeader) -> u64 {
    let are_rows = |content: Content| of(&content).trajectories() != Trajectories::None;
    match snapshot.trajectories {
        0 if snapshot.content().is_ok_and(are_rows) => snapshot.rows.into(),
        said => said,
    }
}

/// A snapshot that has been decoded.
#[derive(Debug, Clone, Copy)]
pub struct Snapshot<'a> {
    /// Its header.
    pub header: &'a SnapshotHeader,
    /// Its kind, with the fields of this kind.
    pub content: Content,
    /// Its columns, one after the other.
    pub items: &'a [f64],
}

impl Snapshot<'_> {
    /// Its columns, of which its kind has `N`.
    ///
    /// # Errors
    /// If their number is not `N`.
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
    /// Its position in the scenario.
    pub index: usize,
}

impl Place<'_> {
    /// The problem in the plane, and the comparison grid at the snapshot's time.
    ///
    /// # Errors
    /// If the scenario's model is not planar.
    pub fn in_plane(&self) -> Result<(&Problem<Planar>, Grid), String> {
        let plane = self.assignment.plane.as_ref();
        let plane = plane.ok_or_else(|| {
            format!("a model in {} variables has no such density", self.assignment.space.variables.len())
        })?;
        let grid = plane.grids.get(self.index).ok_or("it is one too many")?;
        Ok((&plane.problem, *grid))
    }

    /// The comparison grid in the plane at the snapshot's time, also where the radiation parameter is uncertain.
    ///
    /// # Errors
    /// If the scenario's model is not planar.
    pub fn grid(&self) -> Result<Grid, String> {
        match &self.assignment.uncertain {
            Some(uncertain) => uncertain.grids.get(self.index).copied().ok_or_else(|| "it is one too many".into()),
            None => self.in_plane().map(|(_, grid)| grid),
        }
    }

    /// Calls `read` with the description of the figures to compute of a cloud in the scenario's space.
    pub fn ask<T>(&self, read: impl FnOnce(&Question<'_>) -> T) -> T {
        let Assignment { space, description, .. } = self.assignment;
        let circles: Vec<bool> = (0..space.variables.len()).map(|k| space.is_circle(k)).collect();
        let on = |projection: &messages::scenario::Projection| Projection {
            axes: projection
                .axes()
                .map(|(variable, _)| variable)
                .zip(self.assignment.axes_of(projection, self.index))
                .collect(),
        };
        let projections: Vec<Projection> = space.projections.iter().map(on).collect();
        read(&Question {
            circles: &circles,
            projections: &projections,
            critical: (space.reentry, description.critical),
        })
    }
}

/// What is remembered of a case between its snapshots.
#[derive(Debug, Default)]
pub struct Memory {
    mesh: Option<CarriedMesh>,
    carried: Option<CarriedDensity>,
    stack: Option<characteristics::RememberedStack>,
}

/// The figures of a cloud at a snapshot, and the method's diagnostics.
#[derive(Debug)]
pub struct Estimated {
    /// The quantities of the scenario's space, in their order; NaN if the method withholds one.
    pub values: Vec<f64>,
    /// Their standard errors; NaN where the method has none.
    pub errors: Vec<f64>,
    /// The density on each projection of the space, first variable outermost.
    pub densities: Vec<Vec<f64>>,
    /// Probability on the grid of the first projection.
    pub mass_on_grid: f64,
    /// What the method says of its own reliability.
    pub diagnosis: Diagnosis,
    /// For characteristics on a carried mesh, the mean relative error of their densities against those that follow from
    /// the points; else NaN.
    pub carried_density_error: f64,
    /// Number of samples, if they were reduced before they were sent.
    pub reduced: Option<u32>,
}

impl From<Estimate> for Estimated {
    /// The figures of an estimate in the plane.
    fn from(estimate: Estimate) -> Self {
        let mass_on_grid = estimate.mass();
        let Estimate { joint, marginal_phi, marginal_e, moments, standard_errors, circular, .. } = estimate;
        Self {
            values: [&moments.to_array()[..], &[circular.mean, circular.resultant]].concat(),
            errors: [&standard_errors.to_array()[..], &[f64::NAN; 2]].concat(),
            densities: vec![joint, marginal_phi, marginal_e],
            mass_on_grid,
            diagnosis: Diagnosis::None,
            carried_density_error: f64::NAN,
            reduced: None,
        }
    }
}

impl Estimated {
    /// The payload of the density message.
    pub fn numbers(&self) -> Vec<f64> {
        [&self.values, &self.errors].into_iter().chain(&self.densities).flatten().copied().collect()
    }

    /// The figures of a cloud in any space.
    pub fn of_cloud(cloud: &Cloud, place: &Place<'_>) -> Self {
        let space = &place.assignment.space;
        let circular = |k: usize| cloud.circular[k].unwrap_or(Circular { mean: f64::NAN, resultant: f64::NAN });
        let value = |quantity: &Quantity| match *quantity {
            Quantity::Mean(k) => cloud.mean[k],
            Quantity::Deviation(k) => cloud.covariance[k][k].sqrt(),
            Quantity::Covariance(a, b) => cloud.covariance[a][b],
            Quantity::AboveCritical => cloud.above,
            Quantity::CircularMean(k) => circular(k).mean,
            Quantity::ResultantLength(k) => circular(k).resultant,
        };
        let error = |quantity: &Quantity| {
            let Some(errors) = &cloud.errors else { return f64::NAN };
            match *quantity {
                Quantity::Mean(k) => errors.mean[k],
                Quantity::Deviation(k) => errors.deviation[k],
                Quantity::Covariance(a, b) => errors.covariance[a][b],
                Quantity::AboveCritical => errors.above,
                Quantity::CircularMean(_) | Quantity::ResultantLength(_) => f64::NAN,
            }
        };
        let quantities = space.quantities();
        let cell: f64 = place.assignment.axes_of(&space.projections[0], place.index).iter().map(Axis::width).product();
        Self {
            values: quantities.iter().map(value).collect(),
            errors: quantities.iter().map(error).collect(),
            mass_on_grid: cloud.densities[0].iter().sum::<f64>() * cell,
            densities: cloud.densities.clone(),
            diagnosis: Diagnosis::None,
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

/// The first number of trajectories that is not finite, or that no orbit can have, in the columns of the space's
/// variables. A column of NaN is right for a variable that `may_be_absent`.
fn not_of_trajectories(
    space: &Space,
    rows: usize,
    items: &[f64],
    may_be_absent: impl Fn(usize) -> bool,
) -> Option<Breach> {
    let is_absent = |column: &[f64], k: usize| may_be_absent(k) && column.iter().all(|value| value.is_nan());
    let columns = || items.chunks_exact(rows.max(1)).enumerate().filter(|(k, column)| !is_absent(column, *k));
    let not_finite = columns().find_map(|(k, column)| not_finite_in(k, column));
    let no_orbit = |(k, column): (usize, &[f64])| {
        let variable = space.variables.get(k)?;
        let Range::Interval { low, high } = variable.range else { return None };
        let row = column.iter().position(|value| !(low..high).contains(value))?;
        let what = format!("row {row} has {} = {}, outside [{low}, {high})", variable.symbol, column[row]);
        Some(Breach { rule: Rule::Range, what })
    };
    not_finite.or_else(|| columns().find_map(no_orbit))
}

/// The first number of a column that is not finite.
fn not_finite_in(column: usize, values: &[f64]) -> Option<Breach> {
    let row = values.iter().position(|value| !value.is_finite())?;
    Some(Breach { rule: Rule::Finite, what: format!("row {row} of column {column} is {}", values[row]) })
}

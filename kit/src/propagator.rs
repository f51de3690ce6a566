//! What a propagator must say of itself: the trait [`Propagator`], and the form of its snapshots.
//!
//! A propagator only turns a scenario into snapshots, each written directly into the shared memory in which the
//! estimator will read it.

use density::grid::Grid;
use density::sample_sums::{SampleSums, TooFar};
use messages::content::Content;
use messages::layout::GIVEN_COLUMNS;

use crate::assignment::Assignment;
use crate::failure::Failure;
use crate::passage::Passage;
use crate::shard::Shard;

/// A method that propagates the initial density.
pub trait Propagator {
    /// Called before a scenario begins, if this process is one of several that share the case: from now on every
    /// snapshot has the rows in `shard.range(total)` of the `total` rows of the whole case, see [`Form::total_rows`].
    /// A row must depend only on its number. Not called for a case without shards.
    ///
    /// # Errors
    /// A method that cannot be split refuses; without this function it does.
    fn take_shard(&mut self, shard: Shard) -> Result<(), Failure> {
        let _ = shard;
        Err(Failure::no_shards())
    }

    /// Prepares for a scenario.
    ///
    /// # Errors
    /// Whatever makes the scenario impossible for this method.
    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure>;

    /// Moves a part of the way to snapshot `index` and returns how much of that way is behind it; `None` if nothing is
    /// left but [`Propagator::advance`]. A method that takes minutes between snapshots shows its progress in this way.
    ///
    /// # Errors
    /// Whatever makes it impossible to go on.
    fn approach(&mut self, index: usize) -> Result<Option<f64>, Failure> {
        let _ = index;
        Ok(None)
    }

    /// Moves to snapshot `index`, the next after the last one, and returns how many rows it has.
    ///
    /// # Errors
    /// Whatever makes it impossible to go on.
    fn advance(&mut self, index: usize) -> Result<usize, Failure>;

    /// The content of the snapshot that has been reached, if it is not the same for all snapshots; `planned` is the
    /// content that [`Propagator::begin`] returned.
    fn content(&self, planned: Content) -> Content {
        planned
    }

    /// The probability that the eccentricity has ever reached its critical value by each of `times` \[yr\].
    ///
    /// # Errors
    /// Whatever makes it impossible to go on; a method without a curve returns [`Passage::Cannot`].
    fn first_passage(&mut self, times: &[f64]) -> Result<Passage, Failure> {
        let _ = times;
        Ok(Passage::Cannot("this propagator does not compute first passages".into()))
    }

    /// What re-entry, and none, says of an uncertain radiation parameter by each time of the curve that
    /// [`Propagator::first_passage`] has just returned ([`GIVEN_COLUMNS`] numbers each); nothing where the parameter is
    /// certain or the method does not know.
    fn given_re_entry(&self) -> Vec<[f64; GIVEN_COLUMNS]> {
        Vec::new()
    }

    /// Trajectories that were followed for the snapshot that has been reached; 0 if there is one per row of samples
    /// or characteristics, or if none is followed.
    fn trajectories(&self) -> u64 {
        0
    }

    /// The propagator's own estimate of the largest error of a coordinate of a trajectory, where trajectories are
    /// interpolated; 0 where it makes none. It stands among the diagnostics of the case.
    fn trajectory_error(&self) -> f64 {
        0.0
    }

    /// The samples of the snapshot that has been reached, reduced to counts and sums on the comparison grid; `None` if
    /// what [`Propagator::write`] writes is to be reduced. Asked for only if the case sends reduced samples. A
    /// propagator that reduces its samples as it makes them needs no memory for them.
    fn reduce(&self, grid: &Grid, critical_e: f64) -> Option<Result<SampleSums, TooFar>> {
        let _ = (grid, critical_e);
        None
    }

    /// Writes the snapshot that [`Propagator::advance`] has reached: the columns of its kind, one after the other.
    fn write(&self, columns: &mut [f64]);
}

/// What a propagator's snapshots look like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Form {
    /// Their kind, with the fields of this kind; [`messages::content`] lists the kinds.
    pub content: Content,
    /// The most rows that a snapshot of the scenario can have; for a shard, only its own rows.
    pub most_rows: usize,
    /// Rows that all shards together have in each snapshot.
    pub total_rows: usize,
}

impl Form {
    /// The form of the snapshots of a case that is not split into shards.
    pub fn whole(content: impl Into<Content>, most_rows: usize) -> Self {
        Self { content: content.into(), most_rows, total_rows: most_rows }
    }
}

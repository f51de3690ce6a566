//! What a built-in method says of itself.

use kit::Propagator;
use kit::assignment::Assignment;
use kit::failure::Failure;
use kit::shard::Shard;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::methods::accuracy::AccuracySetting;

/// A setting that does not go with the others.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{key}: {problem}")]
pub struct Misfit {
    /// Its key.
    pub key: &'static str,
    /// What is wrong and what would be right.
    pub problem: String,
}

impl Misfit {
    pub(crate) fn new(key: &'static str, problem: impl Into<String>) -> Self {
        Self { key, problem: problem.into() }
    }

    /// A setting that changes nothing, given what else is set.
    pub(crate) fn no_effect(key: &'static str, because: &str) -> Self {
        Self::new(key, format!("has no effect {because}; leave it out"))
    }
}

/// The settings of a built-in method, from which its propagator is made.
pub trait Method: Clone + Serialize + DeserializeOwned {
    /// The name that a launch file gives as `node`.
    const NAME: &'static str;

    /// What propagates.
    type Propagator: Propagator;

    /// The propagator with these settings.
    fn propagator(self) -> Self::Propagator;

    /// Whether settings that are fine one by one go together.
    ///
    /// # Errors
    /// What is wrong and what would be right.
    fn check(&self) -> Result<(), Misfit>;

    /// Whether its density can be put on a grid with these numbers of bins in `phi` and `e`.
    ///
    /// # Errors
    /// What is wrong and what would be right.
    fn check_bins(&self, _bins: (usize, usize)) -> Result<(), Misfit> {
        Ok(())
    }

    /// Whether the method can do a scenario, as far as that is known before anything is computed. The assignment has no
    /// grids.
    ///
    /// # Errors
    /// Why not, in the words of the run.
    fn check_scenario(&self, assignment: &Assignment, shard: Shard) -> Result<(), Failure>;

    /// The same settings with every one that has an effect filled in, and no other.
    fn resolved(&self) -> Self {
        self.clone()
    }

    /// How accurately it propagates, if that is set.
    fn accuracy_mut(&mut self) -> &mut Option<AccuracySetting>;

    /// The most numbers that a snapshot can hold, with these numbers of bins in `phi` and `e` and of variables of the
    /// cloud.
    fn most_numbers(&self, bins: (usize, usize), variables: usize) -> usize;

    /// Whether its first-passage curve follows from the snapshots, so that it is computed after all of them.
    fn curve_needs_snapshots(&self) -> bool {
        true
    }

    /// The rows that the processes of a case in parts would share.
    ///
    /// # Errors
    /// Why the case cannot be split.
    fn rows_to_share(&self) -> Result<usize, String>;

    /// Whether the samples of the case can be reduced before they are sent.
    ///
    /// # Errors
    /// Why not.
    fn check_reduce(&self) -> Result<(), String> {
        Err("this method sends no independent samples, and only such can be reduced; leave out `reduce`".into())
    }
}

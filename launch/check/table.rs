//! A snapshot that has been decoded, with its columns.

use density::model::plane::State;
use kit::kind::{self, Snapshot, Trajectories};

/// A snapshot with its position and its columns.
#[derive(Debug)]
pub struct Table<'a> {
    /// Its position.
    pub index: usize,
    /// The snapshot.
    pub snapshot: Snapshot<'a>,
    /// Its columns.
    pub columns: Vec<&'a [f64]>,
}

impl Table<'_> {
    /// The states of its rows, in the plane.
    pub fn states(&self) -> Vec<State> {
        let pairs = self.columns[0].iter().zip(self.columns[1]);
        pairs.map(|(&phi, &e)| State::from_polar(phi, e)).collect()
    }

    /// Whether NaN in it stands for a figure that its sender withholds.
    pub fn may_withhold(&self) -> bool {
        kind::of(&self.snapshot.content).may_withhold()
    }

    /// Whether its rows are points of trajectories.
    pub fn trajectories(&self) -> Trajectories {
        kind::of(&self.snapshot.content).trajectories()
    }

    /// Its time \[yr\].
    pub fn time(&self) -> f64 {
        self.snapshot.header.time
    }

    /// Its number of rows.
    pub fn rows(&self) -> f64 {
        f64::from(self.snapshot.header.rows)
    }
}

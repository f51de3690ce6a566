//! The header of a snapshot.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use super::{Content, Details, kind};
use crate::describe::{Described, Field, FieldType, header};
use crate::text::Label;

header! {
    /// What a propagator computed at one time. Payload: the columns of its [`kind`], one after the other, `rows` long
    /// each.
    #[type_name("phasecloud/SnapshotHeader/5")]
    pub struct SnapshotHeader {
        /// Names the run.
        pub run_id: u64,
        /// Time of the snapshot \[yr\].
        pub time: f64 [unit "yr"],
        /// CPU time that the propagator spent on this snapshot \[s\].
        pub seconds: f64 [unit "s"],
        /// Rows of all shards together; for reduced samples, the number of samples of all shards; 0 if the case has
        /// no shards.
        pub total: u64,
        /// Trajectories that the propagator followed for this snapshot; 0 if it does not say. In that case each row
        /// of samples or characteristics counts as one.
        pub trajectories: u64,
        /// The propagator's own estimate of the largest error of a coordinate of a trajectory, if it interpolates
        /// trajectories; 0 if it does not say.
        pub trajectory_error: f64,
        /// Position of the scenario in the run.
        pub scenario: u32,
        /// Position of the snapshot in the scenario, from 0.
        pub index: u32,
        /// Snapshots in the scenario.
        pub count: u32,
        /// What the columns and the details are, see [`kind`].
        pub kind: u32 [codes kind::CODES],
        /// Length of a column.
        pub rows: u32,
        /// Number of columns.
        pub columns: u32,
        /// How often the propagator had been restarted. A snapshot with a higher number begins the scenario anew and
        /// replaces all those with lower numbers; if the case has shards, only those of the same shard.
        pub attempt: u32,
        /// Which shard of the case sent it, from 0.
        pub shard: u32,
        /// Shards of the case; 0 or 1 if the case is not split. Shard `k` of `n` has the rows from `total * k / n` up
        /// to `total * (k + 1) / n`.
        pub shards: u32,
        /// The most rows that a snapshot of this process can have in the scenario; 0 if all its snapshots have `rows`
        /// rows.
        pub most_rows: u32,
        /// The propagator's label.
        pub label: Label,
        /// The further fields that snapshots of this kind have (their details), then zeros.
        pub details: Details,
    }
}

impl SnapshotHeader {
    /// What the snapshot is.
    ///
    /// # Errors
    /// As [`Content::decode`].
    pub fn content(&self) -> Result<Content, String> {
        Content::decode(self.kind, &self.details)
    }

    /// This header with the kind, the number of columns and the details of `content` in the plane.
    pub fn with(self, content: impl Into<Content>) -> Self {
        const PLANE: usize = 2;
        self.with_variables(content, PLANE)
    }

    /// This header with the kind, the number of columns and the details of `content` in a space of `variables`
    /// variables.
    pub fn with_variables(self, content: impl Into<Content>, variables: usize) -> Self {
        let content = content.into();
        let (kind, columns) = (content.kind().code(), content.column_count(variables) as u32);
        Self { kind, columns, details: content.details(), ..self }
    }
}

//! Equally weighted samples: counted into bins.

use density::binning;
use messages::content::{Content, Samples};

use super::{Estimated, Kind, Memory, Place, Snapshot, Trajectories, not_of_trajectories};
use crate::snapshot_rules::Breach;

impl Kind for Samples {
    fn breach(&self, rows: usize, items: &[f64]) -> Option<Breach> {
        not_of_trajectories(rows, items)
    }

    fn estimate(&self, snapshot: &Snapshot, _: &mut Memory, at: &Place) -> Result<Estimated, String> {
        let [phi, e] = snapshot.columns()?;
        let critical_e = at.assignment.problem.critical_e;
        Ok(match groups(self) {
            None => binning::estimate(phi, e, at.grid, critical_e).into(),
            Some(groups) => binning::estimate_in_groups(phi, e, at.grid, critical_e, groups).into(),
        })
    }

    fn of_all_shards(&self) -> Result<Content, String> {
        Ok((*self).into())
    }

    /// The standard errors of samples that were drawn in groups need each of them.
    fn may_be_reduced(&self) -> bool {
        groups(self).is_none()
    }

    fn trajectories(&self) -> Trajectories {
        Trajectories::Unordered
    }
}

/// How many groups samples were drawn in; `None` if they are independent.
pub fn groups(samples: &Samples) -> Option<usize> {
    (samples.replicates > 1).then_some(samples.replicates as usize)
}

//! Equally weighted samples: counted into bins.

use density::binning;
use density::projected::of_samples;
use messages::content::{Content, Samples};

use super::{Estimated, Kind, Memory, Place, Snapshot, Trajectories, not_of_trajectories};
use crate::breach::Breach;
use crate::space::Space;

/// A planar cloud has both of its variables.
const IN_PLANE: usize = 2;

impl Kind for Samples {
    /// A column of NaN is that of a variable that the sampled model does not have, which the re-entry variable is not.
    fn breach(&self, space: &Space, rows: usize, items: &[f64]) -> Option<Breach> {
        not_of_trajectories(space, rows, items, |variable| {
            variable != space.reentry && space.variables.len() > IN_PLANE
        })
    }

    fn estimate(&self, snapshot: &Snapshot, _: &mut Memory, at: &Place) -> Result<Estimated, String> {
        if at.assignment.plane.is_none() {
            return in_any_space(self, snapshot, at);
        }
        let [phi, e] = snapshot.columns()?;
        let (problem, grid) = at.in_plane()?;
        Ok(match groups(self) {
            None => binning::estimate(phi, e, grid, problem.critical_e).into(),
            Some(groups) => binning::estimate_in_groups(phi, e, grid, problem.critical_e, groups).into(),
        })
    }

    fn of_all_shards(&self) -> Result<Content, String> {
        Ok((*self).into())
    }

    fn lacks_variables(&self, rows: usize, items: &[f64]) -> bool {
        items.chunks_exact(rows.max(1)).any(|column| column.iter().all(|value| value.is_nan()))
    }

    /// Samples that were drawn in groups cannot be reduced: their standard errors need the samples of each group.
    fn may_be_reduced(&self) -> bool {
        groups(self).is_none()
    }

    fn trajectories(&self) -> Trajectories {
        Trajectories::Unordered
    }
}

/// The estimate in a space of any variables.
fn in_any_space(samples: &Samples, snapshot: &Snapshot, at: &Place) -> Result<Estimated, String> {
    let columns: Vec<&[f64]> = snapshot.items.chunks_exact(snapshot.header.rows.max(1) as usize).collect();
    Ok(Estimated::of_cloud(&at.ask(|question| of_samples(&columns, question, groups(samples))), at))
}

/// Number of groups in which samples were drawn; `None` if they are independent.
pub fn groups(samples: &Samples) -> Option<usize> {
    (samples.replicates > 1).then_some(samples.replicates as usize)
}

//! Gaussian mixtures: read out in closed form.

use density::estimate::ordered_sum;
use density::mixture::{self, Component};
use messages::content::{Content, Mixture};
use messages::layout::diagnostic;

use super::{Estimated, Kind, Memory, Place, Snapshot, not_finite};
use crate::snapshot_rules::Breach;

/// Wide enough for any cloud, and no more images of a component round the circle than can be summed \[rad\].
const FARTHEST: f64 = 100.0;

impl Kind for Mixture {
    fn breach(&self, rows: usize, items: &[f64]) -> Option<Breach> {
        not_finite(rows, items)
    }

    fn estimate(&self, snapshot: &Snapshot, _: &mut Memory, at: &Place) -> Result<Estimated, String> {
        let [w, mean_phi, mean_e, var_phi, cov, var_e] = snapshot.columns()?;
        let is_too_far = |&i: &usize| mean_phi[i].abs() > FARTHEST || var_phi[i] > FARTHEST * FARTHEST;
        if let Some(row) = (0..w.len()).find(is_too_far) {
            return Err(format!("component {row} lies or reaches more than {FARTHEST} rad from phi = 0"));
        }
        let row = |i: usize| Component::from_array([w[i], mean_phi[i], mean_e[i], var_phi[i], cov[i], var_e[i]]);
        let components: Vec<Component> = (0..w.len()).map(row).collect();
        let problem = &at.assignment.problem;
        let estimate = mixture::estimate(&components, &at.grid, problem.critical_e).map_err(|e| e.to_string())?;
        let [weights] = ordered_sum(components.len(), |i| [components[i].weight]);
        let below = mixture::mass_below_zero(&components);
        Ok(Estimated {
            diagnostic: diagnostic::MIXTURE,
            diagnostics: [self.disagreement, below, weights, problem.initial.mass_beyond_one()],
            ..estimate.into()
        })
    }

    /// How linear the flow is over the components of others, no shard knows.
    fn of_all_shards(&self) -> Result<Content, String> {
        Ok(Self::UNJUDGED.into())
    }
}

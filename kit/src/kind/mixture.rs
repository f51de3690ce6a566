//! Gaussian mixtures: read out in closed form.

use density::estimate::ordered_sum;
use density::mixture::{self, PlanarComponent};
use density::projected::{self, of_mixture};
use density::trust::Diagnosis;
use messages::content::{Content, Mixture};

use super::{Estimated, Kind, Memory, Place, Snapshot, not_finite};
use crate::breach::Breach;
use crate::space::Space;

/// Largest mean and standard deviation of an angle \[rad\]: large enough for any cloud, and small enough to sum the
/// images of a component round the circle.
const FARTHEST: f64 = 100.0;

impl Kind for Mixture {
    fn breach(&self, _: &Space, rows: usize, items: &[f64]) -> Option<Breach> {
        not_finite(rows, items)
    }

    fn estimate(&self, snapshot: &Snapshot, _: &mut Memory, at: &Place) -> Result<Estimated, String> {
        if at.assignment.plane.is_none() {
            return in_any_space(self, snapshot, at);
        }
        let [w, mean_phi, mean_e, var_phi, cov, var_e] = snapshot.columns()?;
        let is_too_far = |&i: &usize| mean_phi[i].abs() > FARTHEST || var_phi[i] > FARTHEST * FARTHEST;
        if let Some(row) = (0..w.len()).find(is_too_far) {
            return Err(format!("component {row} lies or reaches more than {FARTHEST} rad from phi = 0"));
        }
        let row = |i: usize| PlanarComponent::from_array([w[i], mean_phi[i], mean_e[i], var_phi[i], cov[i], var_e[i]]);
        let components: Vec<PlanarComponent> = (0..w.len()).map(row).collect();
        let (problem, grid) = at.in_plane()?;
        let estimate = mixture::estimate(&components, &grid, problem.critical_e).map_err(|e| e.to_string())?;
        let [weights] = ordered_sum(components.len(), |i| [components[i].weight]);
        let below = mixture::mass_below_zero(&components);
        Ok(Estimated {
            diagnosis: Diagnosis::Mixture {
                disagreement: self.disagreement,
                below_zero: below,
                weights,
                beyond_one: problem.initial.mass_beyond_one(),
            },
            ..estimate.into()
        })
    }

    /// No shard knows how linear the flow is over the components of the other shards.
    fn of_all_shards(&self) -> Result<Content, String> {
        Ok(Self::UNJUDGED.into())
    }
}

/// The estimate in a space of any variables: each row is a weight, the means, and the upper triangle of the
/// covariance, row by row.
fn in_any_space(mixture: &Mixture, snapshot: &Snapshot, at: &Place) -> Result<Estimated, String> {
    let space = &at.assignment.space;
    let count = space.variables.len();
    let columns: Vec<&[f64]> = snapshot.items.chunks_exact(snapshot.header.rows.max(1) as usize).collect();
    let upper = |a: usize, b: usize| 1 + count + a * count - a * (a + 1) / 2 + b;
    let row = |i: usize| projected::AnyComponent {
        weight: columns[0][i],
        mean: (0..count).map(|k| columns[1 + k][i]).collect(),
        covariance: (0..count).map(|a| (0..count).map(|b| columns[upper(a.min(b), a.max(b))][i]).collect()).collect(),
    };
    let components: Vec<projected::AnyComponent> = (0..snapshot.header.rows as usize).map(row).collect();
    for (i, component) in components.iter().enumerate() {
        let is_wide = |k: usize| component.covariance[k][k] > 0.0;
        let is_far =
            |k: usize| space.is_circle(k) && component.mean[k].abs().max(component.covariance[k][k].sqrt()) > FARTHEST;
        if let Some(k) = (0..count).find(|&k| !is_wide(k) || is_far(k)) {
            let (symbol, variance) = (space.symbol(k), component.covariance[k][k]);
            return Err(format!(
                "component {i} has a mean {symbol} of {} with a variance of {variance}; a variance is above 0, and an angle within \
                 {FARTHEST} rad",
                component.mean[k]
            ));
        }
    }
    let [weights] = ordered_sum(components.len(), |i| [components[i].weight]);
    if weights.is_nan() || weights <= 0.0 {
        return Err(format!("its weights add up to {weights}, they must add up to more than 0"));
    }
    let cloud = at.ask(|question| of_mixture(&components, question));
    Ok(Estimated {
        diagnosis: Diagnosis::Mixture { disagreement: mixture.disagreement, below_zero: 0.0, weights, beyond_one: 0.0 },
        ..Estimated::of_cloud(&cloud, at)
    })
}

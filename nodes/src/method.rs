//! Which density method belongs to which kind of snapshot.

use density::angle::{Circular, nearest};
use density::estimate::{Estimate, Moments, ordered_sum};
use density::mesh::{Branch, CarriedMesh, MeshDiagnostics, hull_estimate, unfold};
use density::mixture::{self, Component};
use density::sample_sums::SampleSums;
use density::{binning, grid::Grid};
use messages::layout::{DENSITY_HEAD, SnapshotHeader, diagnostic, kind, treatment};

use crate::assignment::Assignment;
use crate::carried_density::CarriedDensity;
use crate::reduced::from_numbers;
use crate::shard::Shard;

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

/// What the estimator remembers of a case between its snapshots.
#[derive(Debug, Default)]
pub struct Case {
    done: usize,
    mesh: Option<CarriedMesh>,
    carried: Option<CarriedDensity>,
}

impl Case {
    /// How many snapshots have been estimated.
    pub fn snapshots_done(&self) -> usize {
        self.done
    }

    /// Estimates the next snapshot from its columns.
    ///
    /// # Errors
    /// What makes the numbers impossible.
    pub fn estimate(
        &mut self,
        header: &SnapshotHeader,
        items: &[f64],
        assignment: &Assignment,
    ) -> Result<Estimated, String> {
        let grid = assignment.grids[self.done];
        let columns: Vec<&[f64]> = items.chunks_exact(header.rows as usize).collect();
        let estimate = match (header.kind, columns[..].as_ref()) {
            (kind::SAMPLES, &[phi, e]) => {
                samples(phi, e, grid, assignment.problem.critical_e, header.replicates as usize).into()
            }
            (kind::CHARACTERISTICS, &[phi, e, n]) => self.characteristics(header, [phi, e, n], &grid, assignment)?,
            (kind::MIXTURE, columns) => {
                let (estimate, [below, weights]) = mixture_estimate(columns, &grid, assignment.problem.critical_e)?;
                Estimated {
                    estimate,
                    diagnostic: diagnostic::MIXTURE,
                    diagnostics: [header.disagreement, below, weights, assignment.problem.initial.mass_beyond_one()],
                    carried_density_error: f64::NAN,
                    reduced: None,
                }
            }
            (kind::REDUCED, &[numbers]) => reduced_samples(header, numbers, grid)?,
            (kind::DENSITY, &[values]) => ready_density(values, grid)?,
            (other, _) => return Err(format!("kind {other} has no density method")),
        };
        check_finite(&estimate.estimate, header.kind == kind::DENSITY)?;
        self.done += 1;
        Ok(estimate)
    }

    fn characteristics(
        &mut self,
        header: &SnapshotHeader,
        [phi, e, n]: [&[f64]; 3],
        grid: &Grid,
        assignment: &Assignment,
    ) -> Result<Estimated, String> {
        let critical_e = assignment.problem.critical_e;
        let branch = match header.treatment {
            treatment::CARRIED_MESH => return self.carried(header, [phi, e, n], grid, assignment),
            treatment::HULL_MESH => Branch::Grid,
            treatment::HULL_MESH_AS_PRINTED => Branch::AsPrinted,
            other => return Err(format!("treatment {other} is unknown to this version")),
        };
        let estimate = hull_estimate(phi, e, n, grid, header.resolution as usize, branch, critical_e);
        estimate.map(Into::into).map_err(|e| e.to_string())
    }

    /// The points of the first snapshot, at `t = 0`, make the mesh that all later ones move.
    fn carried(
        &mut self,
        header: &SnapshotHeader,
        [phi, e, n]: [&[f64]; 3],
        grid: &Grid,
        assignment: &Assignment,
    ) -> Result<Estimated, String> {
        let initial = &assignment.problem.initial;
        let mesh = match self.mesh.take() {
            Some(mesh) => mesh,
            None => {
                let lattice = (header.lattice > 0).then_some(header.lattice as usize);
                let phi0 = match lattice {
                    Some(side) => unfold(initial, phi, side),
                    None => phi.iter().map(|&phi| nearest(phi, initial.mean_phi)).collect(),
                };
                CarriedMesh::new(initial, &phi0, e, lattice, header.degree.max(1) as usize)
                    .map_err(|e| e.to_string())?
            }
        };
        let (estimate, mesh_says) =
            mesh.estimate(phi, e, grid, assignment.problem.critical_e).map_err(|e| e.to_string())?;
        self.mesh = Some(mesh);
        let start = self.carried.get_or_insert_with(|| CarriedDensity::begin(initial, phi, e, n));
        let carried_density_error = start.error_of(phi, e, n);
        let MeshDiagnostics { measure_defect, flipped_mass, truncated_mass, misplaced_mass, .. } = mesh_says;
        Ok(Estimated {
            estimate,
            diagnostic: diagnostic::MESH,
            diagnostics: [measure_defect, flipped_mass, truncated_mass, misplaced_mass],
            carried_density_error,
            reduced: None,
        })
    }
}

/// Samples drawn in `replicates` groups, or independent ones if that is less than 2.
fn samples(phi: &[f64], e: &[f64], grid: Grid, critical_e: f64, replicates: usize) -> Estimate {
    if replicates < 2 {
        binning::estimate(phi, e, grid, critical_e)
    } else {
        binning::estimate_in_groups(phi, e, grid, critical_e, replicates)
    }
}

/// What shards have made of their samples, one after the other.
fn reduced_samples(header: &SnapshotHeader, numbers: &[f64], grid: Grid) -> Result<Estimated, String> {
    let mut whole = SampleSums::empty(grid.len());
    let mut rest = numbers;
    for shard in Shard::all(header.shards) {
        let (sums, others) = from_numbers(rest, grid.len()).map_err(|why| format!("shard {}: {why}", shard.index))?;
        let range = shard.range(header.total as usize);
        if !shard.is_whole() && sums.samples != range.len() as u64 {
            let (samples, total) = (sums.samples, header.total);
            return Err(format!(
                "shard {}: it has {samples} samples, but its range of {total} is {range:?}",
                shard.index
            ));
        }
        whole.add(&sums);
        rest = others;
    }
    match u32::try_from(whole.samples) {
        Ok(samples) if rest.is_empty() => Ok(Estimated { reduced: Some(samples), ..whole.finish(grid).into() }),
        _ => Err(format!("{} numbers follow {} reduced samples", rest.len(), whole.samples)),
    }
}

/// A density that its propagator has computed on the grid itself; NaN in what it withholds, see
/// [`crate::snapshot_rules::in_numbers`].
fn ready_density(values: &[f64], grid: Grid) -> Result<Estimated, String> {
    let bins = grid.len();
    let Some((&head, joint)) = values.split_first_chunk::<DENSITY_HEAD>().filter(|(_, joint)| joint.len() == bins)
    else {
        return Err(format!("it holds {} numbers, not {DENSITY_HEAD} and one for each of {bins} bins", values.len()));
    };
    let [a, b, c, d, e, f, mean, resultant, diagnostics @ ..] = head;
    let moments = Moments::from_array([a, b, c, d, e, f]);
    let estimate = Estimate::from_joint(grid, joint.to_vec(), moments, Circular { mean, resultant });
    let numerical = diagnostic::NUMERICAL;
    Ok(Estimated { diagnostic: numerical, diagnostics, ..estimate.into() })
}

/// A mixture's density, its probability below `e = 0`, and what its weights add up to.
fn mixture_estimate(columns: &[&[f64]], grid: &Grid, critical_e: f64) -> Result<(Estimate, [f64; 2]), String> {
    let &[w, mean_phi, mean_e, var_phi, cov, var_e] = columns else {
        return Err("a mixture has six columns".into());
    };
    // Wide enough for any cloud, and no more images of a component round the circle than can be summed.
    const MOST_TURNS: f64 = 100.0;
    if let Some(row) = (0..w.len()).find(|&i| mean_phi[i].abs() > MOST_TURNS || var_phi[i] > MOST_TURNS * MOST_TURNS) {
        return Err(format!("component {row} lies or reaches more than {MOST_TURNS} rad from phi = 0"));
    }
    let row = |i: usize| Component::from_array([w[i], mean_phi[i], mean_e[i], var_phi[i], cov[i], var_e[i]]);
    let components: Vec<Component> = (0..w.len()).map(row).collect();
    let estimate = mixture::estimate(&components, grid, critical_e).map_err(|e| e.to_string())?;
    let weights = ordered_sum(components.len(), |i| [components[i].weight]);
    Ok((estimate, [mixture::mass_below_zero(&components), weights[0]]))
}

/// Numbers that are fine one by one may still lead nowhere, such as `phi` = 1e308. NaN is what a method withholds that `may` do so.
fn check_finite(estimate: &Estimate, may: bool) -> Result<(), String> {
    let is_good = |number: f64| number.is_finite() || (may && number.is_nan());
    let moments = estimate.moments.to_array();
    let mut densities = estimate.joint.iter().chain(&estimate.marginal_phi).chain(&estimate.marginal_e);
    let is_withheld = may && estimate.joint.iter().all(|density| density.is_nan());
    match (is_withheld || densities.all(|density| density.is_finite())) && moments.into_iter().all(is_good) {
        true => Ok(()),
        false => Err("its density or moments are not finite".into()),
    }
}

#[cfg(test)]
mod tests {
    use density::grid::Axis;

    use super::*;
    use crate::reduced::to_numbers;

    #[test]
    fn a_density_that_is_withheld_stays_withheld_and_so_do_its_marginals_and_its_mass() {
        let grid = Grid { phi: Axis { low: 1.0, high: 2.0, bins: 4 }, e: Axis { low: 0.1, high: 0.3, bins: 3 } };
        let mut values = vec![0.25; DENSITY_HEAD];
        values[2] = f64::NAN;
        values.extend([f64::NAN; 12]);
        let Estimated { estimate, diagnostics, .. } = ready_density(&values, grid).unwrap();
        assert!(
            estimate.mass().is_nan() && estimate.marginal_phi.iter().chain(&estimate.marginal_e).all(|d| d.is_nan())
        );
        assert!(estimate.moments.mean_e.is_nan() && estimate.moments.mean_phi == 0.25);
        assert_eq!(diagnostics, [0.25; 4], "how far it came is told");
    }

    #[test]
    fn reduced_samples_that_are_not_of_the_shards_range_are_refused_and_the_shard_named() {
        let grid = Grid { phi: Axis { low: 1.0, high: 2.0, bins: 4 }, e: Axis { low: 0.1, high: 0.3, bins: 3 } };
        let samples = |count: usize| {
            let sums = SampleSums::reduce(&vec![1.5; count], &vec![0.2; count], &grid, 0.6).unwrap();
            to_numbers(&sums).unwrap()
        };
        let header = SnapshotHeader { kind: kind::REDUCED, shards: 2, total: 5, ..SnapshotHeader::default() };
        let estimated = reduced_samples(&header, &[samples(2), samples(3)].concat(), grid).unwrap();
        assert_eq!((estimated.reduced, estimated.estimate.mass()), (Some(5), 1.0));
        let refused = |numbers: &[f64], words: &str| {
            let why = reduced_samples(&header, numbers, grid).unwrap_err();
            assert!(why.contains(words), "{why}");
        };
        refused(&[samples(2), samples(2)].concat(), "shard 1: it has 2 samples, but its range of 5 is 2..5");
        refused(&samples(2), "shard 1: it ends before");
        refused(&[samples(2), samples(3), samples(1)].concat(), "follow 5 reduced samples");
    }
}

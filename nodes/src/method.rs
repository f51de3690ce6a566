//! Which density method belongs to which kind of snapshot.

use density::angle::nearest;
use density::estimate::Estimate;
use density::mesh::{Branch, CarriedMesh, hull_estimate};
use density::mixture::{self, Component};
use density::{binning, grid::Grid};
use messages::layout::{SnapshotHeader, kind, treatment};

use crate::assignment::Assignment;

/// What the estimator remembers of a case between its snapshots.
#[derive(Debug, Default)]
pub struct Case {
    done: usize,
    mesh: Option<CarriedMesh>,
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
    ) -> Result<Estimate, String> {
        let grid = assignment.grids[self.done];
        let columns: Vec<&[f64]> = items.chunks_exact(header.rows as usize).collect();
        let estimate = match (header.kind, columns[..].as_ref()) {
            (kind::SAMPLES, &[phi, e]) => {
                check_eccentricities(e)?;
                binning::estimate(phi, e, grid, assignment.problem.critical_e)
            }
            (kind::CHARACTERISTICS, &[phi, e, n]) => self.characteristics(header, [phi, e, n], &grid, assignment)?,
            (kind::MIXTURE, columns) => mixture_estimate(columns, &grid, assignment.problem.critical_e)?,
            (other, _) => return Err(format!("kind {other} has no density method")),
        };
        self.done += 1;
        Ok(estimate)
    }

    fn characteristics(
        &mut self,
        header: &SnapshotHeader,
        [phi, e, n]: [&[f64]; 3],
        grid: &Grid,
        assignment: &Assignment,
    ) -> Result<Estimate, String> {
        let critical_e = assignment.problem.critical_e;
        let branch = match header.treatment {
            treatment::CARRIED_MESH => return self.carried(header, phi, e, grid, assignment),
            treatment::HULL_MESH => Branch::Grid,
            treatment::HULL_MESH_AS_PRINTED => Branch::AsPrinted,
            other => return Err(format!("treatment {other} is unknown to this version")),
        };
        hull_estimate(phi, e, n, grid, header.resolution as usize, branch, critical_e).map_err(|e| e.to_string())
    }

    /// The points of the first snapshot, at `t = 0`, make the mesh that all later ones move.
    fn carried(
        &mut self,
        header: &SnapshotHeader,
        phi: &[f64],
        e: &[f64],
        grid: &Grid,
        assignment: &Assignment,
    ) -> Result<Estimate, String> {
        let initial = &assignment.problem.initial;
        let mesh = match self.mesh.take() {
            Some(mesh) => mesh,
            None => {
                let phi0: Vec<f64> = phi.iter().map(|&phi| nearest(phi, initial.mean_phi)).collect();
                let lattice = (header.lattice > 0).then_some(header.lattice as usize);
                CarriedMesh::new(initial, &phi0, e, lattice, header.degree.max(1) as usize)
                    .map_err(|e| e.to_string())?
            }
        };
        let (estimate, _diagnostics) =
            mesh.estimate(phi, e, grid, assignment.problem.critical_e).map_err(|e| e.to_string())?;
        self.mesh = Some(mesh);
        Ok(estimate)
    }
}

fn mixture_estimate(columns: &[&[f64]], grid: &Grid, critical_e: f64) -> Result<Estimate, String> {
    let &[w, mean_phi, mean_e, var_phi, cov, var_e] = columns else {
        return Err("a mixture has six columns".into());
    };
    let row = |i: usize| Component::from_array([w[i], mean_phi[i], mean_e[i], var_phi[i], cov[i], var_e[i]]);
    let components: Vec<Component> = (0..w.len()).map(row).collect();
    mixture::estimate(&components, grid, critical_e).map_err(|e| e.to_string())
}

fn check_eccentricities(e: &[f64]) -> Result<(), String> {
    match e.iter().position(|e| !(0.0..1.0).contains(e)) {
        Some(row) => Err(format!("row {row} has e = {}, outside [0, 1)", e[row])),
        None => Ok(()),
    }
}

//! Characteristics: points that carry a density along, on a carried mesh or on a hull mesh of their final positions.

use density::mesh::{Branch, CarriedMesh, MeshDiagnostics, hull_estimate, unfold};
use messages::content::{Characteristics, Content, Lattice};
use messages::layout::diagnostic;

use super::{Estimated, Kind, Memory, Place, Snapshot, Trajectories, not_of_trajectories};
use crate::breach::Breach;
use crate::carried_density::CarriedDensity;
use crate::space::Space;

impl Kind for Characteristics {
    fn breach(&self, space: &Space, rows: usize, items: &[f64]) -> Option<Breach> {
        not_of_trajectories(space, rows, items, |_| false)
    }

    /// If a hull mesh were interpolated more coarsely than the comparison grid, some bins would have no value.
    fn check_grid(&self, bins: usize) -> Result<(), String> {
        match *self {
            Self::HullMesh { resolution, .. } if (resolution as usize) < bins => {
                Err(format!("its resolution is {resolution}, less than the {bins} bins of the comparison grid"))
            }
            _ => Ok(()),
        }
    }

    fn estimate(&self, snapshot: &Snapshot, memory: &mut Memory, at: &Place) -> Result<Estimated, String> {
        let [phi, e, n] = snapshot.columns()?;
        match *self {
            Self::CarriedMesh { lattice } => carried(lattice, [phi, e, n], memory, at),
            Self::HullMesh { resolution, as_printed } => {
                let branch = if as_printed { Branch::AsPrinted } else { Branch::Grid };
                let (problem, grid) = at.in_plane()?;
                let estimate = hull_estimate(phi, e, n, &grid, resolution as usize, branch, problem.critical_e);
                estimate.map(Into::into).map_err(|e| e.to_string())
            }
        }
    }

    fn of_all_shards(&self) -> Result<Content, String> {
        Ok((*self).into())
    }

    fn trajectories(&self) -> Trajectories {
        Trajectories::Ordered
    }
}

/// The points of the first snapshot, at `t = 0`, form the mesh, which the points of all later snapshots move.
fn carried(
    lattice: Option<Lattice>,
    [phi, e, n]: [&[f64]; 3],
    memory: &mut Memory,
    at: &Place,
) -> Result<Estimated, String> {
    let (problem, grid) = at.in_plane()?;
    let initial = &problem.initial;
    let mesh = match memory.mesh.take() {
        Some(mesh) => mesh,
        None => {
            let (side, degree) = (lattice.map(|lattice| lattice.side as usize), lattice.map_or(1, |l| l.degree));
            let phi0 = unfold(initial, phi, e, side.unwrap_or(0));
            CarriedMesh::new(initial, &phi0, e, side, degree as usize).map_err(|e| e.to_string())?
        }
    };
    let (estimate, mesh_says) = mesh.estimate(phi, e, &grid, problem.critical_e).map_err(|e| e.to_string())?;
    memory.mesh = Some(mesh);
    let start = memory.carried.get_or_insert_with(|| CarriedDensity::begin(initial, phi, e, n));
    let carried_density_error = start.error_of(phi, e, n);
    let MeshDiagnostics { measure_defect, flipped_mass, truncated_mass, misplaced_mass, .. } = mesh_says;
    Ok(Estimated {
        diagnostic: diagnostic::MESH,
        diagnostics: [measure_defect, flipped_mass, truncated_mass, misplaced_mass],
        carried_density_error,
        ..estimate.into()
    })
}

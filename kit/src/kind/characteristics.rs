//! Characteristics: points that carry a density along, on a carried mesh or on a hull mesh of their final positions.

use density::angle::Circular;
use density::estimate::Estimate;
use density::mesh::stack::{Stack, StackEstimate};
use density::mesh::{Branch, CarriedMesh, MeshDiagnostics, hull_estimate, unfold};
use density::trust::Diagnosis;
use density::uncertain::{ThirdMoments, UncertainProblem};
use messages::content::{Characteristics, Content, Lattice};

use super::{Estimated, Kind, Memory, Place, Snapshot, Trajectories, not_of_trajectories};
use crate::assignment::Uncertain;
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
        if at.assignment.uncertain.is_some() {
            return layers(self, snapshot, memory, at);
        }
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

/// What is remembered of a stack between its snapshots.
#[derive(Debug)]
pub(super) struct RememberedStack {
    stack: Stack,
    /// The densities in the plane with which the points started.
    start: CarriedDensity,
    /// The density in the third variable at each point, which the flow keeps.
    third: Vec<f64>,
}

impl RememberedStack {
    fn begin(
        problem: &UncertainProblem,
        [phi, e, third, n]: [&[f64]; 4],
        Lattice { side, degree }: Lattice,
    ) -> Result<Self, String> {
        let stack = Stack::new(problem, [phi, e, third], side as usize, degree as usize).map_err(|e| e.to_string())?;
        let third: Vec<f64> = third.iter().map(|&third| problem.third_density(third)).collect();
        let start = CarriedDensity::begin(&problem.plane.initial, phi, e, &in_plane(n, &third));
        Ok(Self { stack, start, third })
    }
}

/// Densities in three variables, divided by those in the third.
fn in_plane(n: &[f64], third: &[f64]) -> Vec<f64> {
    n.iter().zip(third).map(|(n, third)| n / third).collect()
}

/// The estimate where the radiation parameter is uncertain: the columns are solar angle, eccentricity, third variable
/// and density of the three.
fn layers(
    content: &Characteristics,
    snapshot: &Snapshot,
    memory: &mut Memory,
    at: &Place,
) -> Result<Estimated, String> {
    let Characteristics::CarriedMesh { lattice: Some(lattice) } = *content else {
        return Err(
            "where the radiation parameter is uncertain, characteristics are a cubic lattice on a carried mesh".into(),
        );
    };
    let [phi, e, third, n] = snapshot.columns()?;
    let Some(Uncertain { problem, .. }) = &at.assignment.uncertain else {
        return Err("it has no third variable".into());
    };
    let remembered = match memory.stack.take() {
        Some(remembered) => remembered,
        None => RememberedStack::begin(problem, [phi, e, third, n], lattice)?,
    };
    let RememberedStack { stack, start, third } = memory.stack.insert(remembered);
    let StackEstimate { plane, third: of_third, diagnostics } =
        stack.estimate(phi, e, &at.grid()?, problem.plane.times[at.index]).map_err(|e| e.to_string())?;
    let values = with_third(&plane, of_third);
    let MeshDiagnostics { measure_defect, flipped_mass, truncated_mass, misplaced_mass, .. } = diagnostics;
    Ok(Estimated {
        errors: vec![f64::NAN; values.len()],
        values,
        diagnosis: Diagnosis::Mesh { measure_defect, flipped_mass, truncated_mass, misplaced_mass },
        carried_density_error: start.error_of(phi, e, &in_plane(n, third)),
        ..plane.into()
    })
}

/// The quantities of a cloud in `phi`, `e` and a third variable, in the order of [`Space::quantities`].
fn with_third(plane: &Estimate, third: ThirdMoments) -> Vec<f64> {
    let [mean_phi, std_phi, mean_e, std_e, cov_phi_e, above] = plane.moments.to_array();
    let ThirdMoments { mean, deviation, with_phi, with_e } = third;
    let Circular { mean: circular, resultant } = plane.circular;
    vec![mean_phi, std_phi, mean_e, std_e, mean, deviation, cov_phi_e, with_phi, with_e, above, circular, resultant]
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
        diagnosis: Diagnosis::Mesh { measure_defect, flipped_mass, truncated_mass, misplaced_mass },
        carried_density_error,
        ..estimate.into()
    })
}

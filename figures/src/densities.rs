//! Reads `densities.npz`.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use density::grid::{Axis, Grid};
use ndarray::{Array, Dimension, Ix1, Ix2};
use ndarray_npy::NpzReader;

use crate::folder_error::FolderError;
use crate::moments_row::MomentsRow;

/// The density of a case at a snapshot.
#[derive(Debug, Clone)]
pub struct Density {
    /// Its bins; `phi` is on the branch that keeps the cloud whole.
    pub grid: Grid,
    /// Joint density \[1/rad\], `phi` outermost.
    pub joint: Vec<f64>,
    /// Marginal of `phi` \[1/rad\].
    pub marginal_phi: Vec<f64>,
    /// Marginal of `e`.
    pub marginal_e: Vec<f64>,
}

impl Density {
    /// Whether the case withholds its density here: its values are then NaN.
    pub fn is_withheld(&self) -> bool {
        [&self.joint, &self.marginal_phi, &self.marginal_e].iter().any(|values| values.iter().any(|v| !v.is_finite()))
    }

    /// The highest joint density \[1/rad\].
    pub fn peak(&self) -> f64 {
        self.joint.iter().copied().fold(0.0, f64::max)
    }
}

/// Densities by scenario, then by case, one per snapshot.
pub type Densities = BTreeMap<String, BTreeMap<String, Vec<Density>>>;

/// Reads the densities of all snapshots that have a row in `moments`.
///
/// # Errors
/// [`FolderError`] if a density is missing or does not fit its edges.
pub fn read(path: &Path, moments: &[MomentsRow]) -> Result<Densities, FolderError> {
    let failed = |problem: String| FolderError::new(path, problem);
    let file = File::open(path).map_err(|e| failed(e.to_string()))?;
    let mut archive = NpzReader::new(BufReader::new(file)).map_err(|e| failed(e.to_string()))?;
    let mut densities = Densities::new();
    for row in moments {
        let snapshots = densities.entry(row.scenario.clone()).or_default().entry(row.method.clone()).or_default();
        let group = format!("{}/{}/{}", row.scenario, row.method, snapshots.len());
        let joint = array::<Ix2>(&mut archive, &format!("{group}/joint")).map_err(failed)?;
        let mut vector = |name: &str| array::<Ix1>(&mut archive, &format!("{group}/{name}")).map_err(failed);
        let (phi_edges, e_edges) = (vector("phi_edges")?, vector("e_edges")?);
        // A withheld density may come with withheld edges. Any edges will do then, because nothing is drawn on them.
        let is_withheld = joint.iter().all(|p| p.is_nan());
        let stand_in =
            |edges: &[f64]| is_withheld.then_some(Axis { low: 0.0, high: 1.0, bins: edges.len().max(2) - 1 });
        let axis = |name: &str, edges: &[f64]| {
            axis(edges).or(stand_in(edges)).ok_or_else(|| failed(format!("{group}/{name} do not ascend")))
        };
        let density = Density {
            grid: Grid { phi: axis("phi_edges", &phi_edges)?, e: axis("e_edges", &e_edges)? },
            joint,
            marginal_phi: vector("marginal_phi")?,
            marginal_e: vector("marginal_e")?,
        };
        let Grid { phi, e } = density.grid;
        let lengths = [density.joint.len(), density.marginal_phi.len(), density.marginal_e.len()];
        if lengths != [phi.bins * e.bins, phi.bins, e.bins] {
            return Err(failed(format!("{group}: {lengths:?} values do not fit {} x {} bins", phi.bins, e.bins)));
        }
        snapshots.push(density);
    }
    Ok(densities)
}

fn array<D: Dimension>(archive: &mut NpzReader<BufReader<File>>, name: &str) -> Result<Vec<f64>, String> {
    let array: Array<f64, D> =
        archive.by_name::<ndarray::OwnedRepr<f64>, D>(name).map_err(|e| format!("{name}: {e}"))?;
    Ok(array.iter().copied().collect())
}

fn axis(edges: &[f64]) -> Option<Axis> {
    let (&low, &high) = (edges.first()?, edges.last()?);
    (low.is_finite() && high.is_finite() && low < high).then_some(Axis { low, high, bins: edges.len() - 1 })
}

//! Reads `densities.npz`.

use std::collections::BTreeMap;
use std::path::Path;

use density::grid::{Axis, Grid};
use results::arrays::{ArrayReader, Place};
use results::files::DENSITIES;
use results::{FolderError, MomentsRow};

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
pub fn read(folder: &Path, moments: &[MomentsRow]) -> Result<Densities, FolderError> {
    let mut archive = ArrayReader::open(&folder.join(DENSITIES))?;
    let mut densities = Densities::new();
    for row in moments {
        let snapshots = densities.entry(row.scenario.clone()).or_default().entry(row.method.clone()).or_default();
        let place = Place::new(&row.scenario, &row.method, snapshots.len());
        let joint = archive.array(&place.name("joint"), 2)?;
        let mut vector = |name: &str| archive.array(&place.name(name), 1);
        let (phi_edges, e_edges) = (vector("phi_edges")?, vector("e_edges")?);
        let (marginal_phi, marginal_e) = (vector("marginal_phi")?, vector("marginal_e")?);
        // A withheld density may come with withheld edges. Any edges will do then, because nothing is drawn on them.
        let is_withheld = joint.iter().all(|p| p.is_nan());
        let stand_in =
            |edges: &[f64]| is_withheld.then_some(Axis { low: 0.0, high: 1.0, bins: edges.len().max(2) - 1 });
        let axis = |name: &str, edges: &[f64]| {
            let axis = axis(edges).or(stand_in(edges));
            axis.ok_or_else(|| archive.failed(format!("{} do not ascend", place.name(name))))
        };
        let grid = Grid { phi: axis("phi_edges", &phi_edges)?, e: axis("e_edges", &e_edges)? };
        let Grid { phi, e } = grid;
        let lengths = [joint.len(), marginal_phi.len(), marginal_e.len()];
        if lengths != [phi.bins * e.bins, phi.bins, e.bins] {
            let bins = format!("{} x {} bins", phi.bins, e.bins);
            return Err(archive.failed(format!("{}: {lengths:?} values do not fit {bins}", place.name(""))));
        }
        snapshots.push(Density { grid, joint, marginal_phi, marginal_e });
    }
    Ok(densities)
}

fn axis(edges: &[f64]) -> Option<Axis> {
    let (&low, &high) = (edges.first()?, edges.last()?);
    (low.is_finite() && high.is_finite() && low < high).then_some(Axis { low, high, bins: edges.len() - 1 })
}

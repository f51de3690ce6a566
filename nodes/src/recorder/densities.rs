//! `densities.npz`: the densities as numpy arrays.

use std::fs::File;
use std::io::BufWriter;
use std::mem::ManuallyDrop;
use std::path::{Path, PathBuf};

use density::grid::Axis;
use density::standard_errors::of_density;
use ndarray::ArrayView;
use ndarray_npy::NpzWriter;

use super::RecordedDensity;
use crate::failure::Failure;
use crate::kind::counted_samples;

/// The open archive.
pub(super) struct Densities {
    path: PathBuf,
    /// Left open if the run ends before it is finished: dropped then, it would write its own words to standard error.
    archive: ManuallyDrop<NpzWriter<BufWriter<File>>>,
}

impl Densities {
    pub(super) fn create(folder: &Path) -> Result<Self, Failure> {
        let path = folder.join("densities.npz");
        let file = File::create(&path).map_err(|e| Failure::file(&path, e))?;
        Ok(Self { path, archive: ManuallyDrop::new(NpzWriter::new(BufWriter::new(file))) })
    }

    /// Adds the density of `method` at a snapshot, as `SCENARIO/METHOD/INDEX/...`.
    pub(super) fn write(&mut self, scenario: &str, method: &str, density: &RecordedDensity) -> Result<(), Failure> {
        let header = &density.header;
        let (phi_bins, e_bins) = (header.phi_bins as usize, header.e_bins as usize);
        let parts = density.values.split_at_checked(phi_bins.saturating_mul(e_bins));
        let parts = parts.and_then(|(joint, rest)| Some((joint, rest.split_at_checked(phi_bins)?)));
        let Some((joint, (marginal_phi, marginal_e))) = parts else {
            return Err(Failure::Refused(format!("{method}: a density shorter than its grid")));
        };
        let [phi_low, phi_high, e_low, e_high] = header.grid;
        let phi = Axis { low: phi_low, high: phi_high, bins: phi_bins };
        let e = Axis { low: e_low, high: e_high, bins: e_bins };
        let group = format!("{scenario}/{method}/{}", header.index);
        let plane = [phi_bins, e_bins];
        self.array(&format!("{group}/joint"), &plane, joint)?;
        if let Some(samples) = counted_samples(header) {
            let errors = of_density(joint, samples as usize, phi.width() * e.width());
            self.array(&format!("{group}/joint_standard_error"), &plane, &errors)?;
        }
        self.array(&format!("{group}/marginal_phi"), &plane[..1], marginal_phi)?;
        self.array(&format!("{group}/marginal_e"), &plane[1..], marginal_e)?;
        self.array(&format!("{group}/phi_edges"), &[plane[0] + 1], &phi.edges())?;
        self.array(&format!("{group}/e_edges"), &[plane[1] + 1], &e.edges())
    }

    fn array(&mut self, name: &str, shape: &[usize], values: &[f64]) -> Result<(), Failure> {
        let array = ArrayView::from_shape(shape, values).map_err(|e| Failure::file(&self.path, e))?;
        self.archive.add_array(name, &array).map_err(|e| Failure::file(&self.path, e))
    }

    /// Closes the archive.
    pub(super) fn finish(self) -> Result<(), Failure> {
        let Self { path, archive } = self;
        let file = ManuallyDrop::into_inner(archive).finish().map_err(|e| Failure::file(&path, e))?;
        file.into_inner().map(drop).map_err(|e| Failure::file(&path, e.error()))
    }
}

//! `densities.npz`: the densities as numpy arrays.

use std::fs::File;
use std::io::BufWriter;
use std::mem::ManuallyDrop;
use std::path::{Path, PathBuf};

use density::standard_errors::of_density;
use ndarray::ArrayView;
use ndarray_npy::NpzWriter;

use crate::services::reading::Reading;
use kit::failure::Failure;
use kit::kind::counted_samples;

/// The open archive.
pub(super) struct Densities {
    path: PathBuf,
    /// Not dropped if the run ends before the archive is finished: dropping it would then print a message to standard
    /// error.
    archive: ManuallyDrop<NpzWriter<BufWriter<File>>>,
}

impl Densities {
    pub(super) fn create(folder: &Path) -> Result<Self, Failure> {
        let path = folder.join("densities.npz");
        let file = File::create(&path).map_err(|e| Failure::file(&path, e))?;
        Ok(Self { path, archive: ManuallyDrop::new(NpzWriter::new(BufWriter::new(file))) })
    }

    /// Adds the densities of `method` at a snapshot, as `SCENARIO/METHOD/INDEX/...`.
    pub(super) fn write(&mut self, scenario: &str, method: &str, reading: &Reading) -> Result<(), Failure> {
        let Reading { header, space, axes, .. } = reading;
        let group = format!("{scenario}/{method}/{}", header.index);
        for (place, projection) in space.projections.iter().enumerate() {
            let (name, density) = (space.density_name(projection), reading.density(place));
            let shape: Vec<usize> = projection.axes().map(|(_, bins)| bins).collect();
            self.array(&format!("{group}/{name}"), &shape, density)?;
            if let Some(samples) = counted_samples(header).filter(|_| shape.len() == 2) {
                let errors = of_density(density, samples as usize, reading.cell(place));
                self.array(&format!("{group}/{name}_standard_error"), &shape, &errors)?;
            }
        }
        for (variable, axis) in axes.iter().enumerate().filter(|(_, axis)| axis.bins > 0) {
            let name = format!("{group}/{}_edges", space.symbol(variable));
            self.array(&name, &[axis.bins + 1], &axis.edges())?;
        }
        Ok(())
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

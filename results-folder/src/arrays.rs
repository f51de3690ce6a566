//! `densities.npz`: the densities as numpy arrays, under the names `SCENARIO/METHOD/INDEX/ARRAY`.

use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::mem::ManuallyDrop;
use std::path::{Path, PathBuf};

use ndarray::{Array, ArrayView, IxDyn, OwnedRepr};
use ndarray_npy::{NpzReader, NpzWriter};

use crate::error::FolderError;

/// The array with the edges of the bins of the variable with this symbol.
pub fn edges(symbol: &str) -> String {
    format!("{symbol}_edges")
}

/// The array with the standard errors of a density that was counted from samples.
pub fn standard_error(density: &str) -> String {
    format!("{density}_standard_error")
}

/// The density of one case at one snapshot, by the place of its arrays in the archive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place(String);

impl Place {
    /// The arrays of `method` at the snapshot number `index` of `scenario`.
    pub fn new(scenario: &str, method: &str, index: usize) -> Self {
        Self(format!("{scenario}/{method}/{index}"))
    }

    /// The full name of an array.
    pub fn name(&self, array: &str) -> String {
        format!("{}/{array}", self.0)
    }
}

/// An archive that is being written.
pub struct ArrayWriter {
    path: PathBuf,
    /// Not dropped if the run ends before the archive is finished: dropping it would then print a message to standard
    /// error.
    archive: ManuallyDrop<NpzWriter<BufWriter<File>>>,
}

impl ArrayWriter {
    /// Begins an archive.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(path: &Path) -> Result<Self, FolderError> {
        let file = File::create(path).map_err(|e| FolderError::new(path, e))?;
        Ok(Self { path: path.into(), archive: ManuallyDrop::new(NpzWriter::new(BufWriter::new(file))) })
    }

    /// Adds an array. The last index of `shape` runs fastest.
    ///
    /// # Errors
    /// If the file cannot be written, or the values do not fit the shape.
    pub fn add(&mut self, name: &str, shape: &[usize], values: &[f64]) -> Result<(), FolderError> {
        let array = ArrayView::from_shape(shape, values).map_err(|e| FolderError::new(&self.path, e))?;
        self.archive.add_array(name, &array).map_err(|e| FolderError::new(&self.path, e))
    }

    /// Closes the archive.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn finish(self) -> Result<(), FolderError> {
        let Self { path, archive } = self;
        let file = ManuallyDrop::into_inner(archive).finish().map_err(|e| FolderError::new(&path, e))?;
        file.into_inner().map(drop).map_err(|e| FolderError::new(&path, e.error()))
    }
}

/// An archive that is being read.
pub struct ArrayReader {
    path: PathBuf,
    archive: NpzReader<BufReader<File>>,
}

impl ArrayReader {
    /// Opens an archive.
    ///
    /// # Errors
    /// If there is none that can be read.
    pub fn open(path: &Path) -> Result<Self, FolderError> {
        let file = File::open(path).map_err(|e| FolderError::new(path, e))?;
        let archive = NpzReader::new(BufReader::new(file)).map_err(|e| FolderError::new(path, e))?;
        Ok(Self { path: path.into(), archive })
    }

    /// The values of an array of `dimensions` dimensions, the last index running fastest.
    ///
    /// # Errors
    /// If there is no such array.
    pub fn array(&mut self, name: &str, dimensions: usize) -> Result<Vec<f64>, FolderError> {
        let found = self.archive.by_name::<OwnedRepr<f64>, IxDyn>(name);
        let array: Array<f64, IxDyn> = found.map_err(|e| self.failed(format!("{name}: {e}")))?;
        match array.ndim() == dimensions {
            true => Ok(array.iter().copied().collect()),
            false => Err(self.failed(format!("{name}: it has {} dimensions instead of {dimensions}", array.ndim()))),
        }
    }

    /// A problem with what the archive holds.
    pub fn failed(&self, problem: impl ToString) -> FolderError {
        FolderError::new(&self.path, problem)
    }
}

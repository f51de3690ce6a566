//! Why a results folder cannot be read, or a file of it not be written.

use std::path::{Path, PathBuf};

/// A file of a results folder could not be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct FolderError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub problem: String,
}

impl FolderError {
    /// A problem with the file at `path`.
    pub fn new(path: &Path, problem: impl ToString) -> Self {
        Self { path: path.into(), problem: problem.to_string() }
    }
}

//! Why a results folder cannot be read, or a file made from it not be written.

use std::path::{Path, PathBuf};

/// A results folder could not be read, or a file made from it could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct FolderError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub problem: String,
}

impl FolderError {
    pub(crate) fn new(path: &Path, problem: impl ToString) -> Self {
        Self { path: path.into(), problem: problem.to_string() }
    }
}

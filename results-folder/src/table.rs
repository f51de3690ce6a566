//! CSV tables with full precision. A number that a method does not have, or withholds, is `NaN`.

use std::fs::File;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::FolderError;

/// An open table. Its head is written even if there are no rows.
#[derive(Debug)]
pub struct Table {
    path: PathBuf,
    writer: csv::Writer<File>,
}

impl Table {
    /// A table whose columns are the fields of `R`.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create<R: Default + Serialize>(path: &Path) -> Result<Self, FolderError> {
        let head = head(&R::default()).map_err(|e| FolderError::new(path, e))?;
        Self::with_head(path, &head)
    }

    /// A table with these columns.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn with_head<H: AsRef<[u8]>>(path: &Path, head: impl IntoIterator<Item = H>) -> Result<Self, FolderError> {
        let failed = |e: csv::Error| FolderError::new(path, e);
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_path(path).map_err(failed)?;
        writer.write_record(head).map_err(failed)?;
        Ok(Self { path: path.into(), writer })
    }

    /// Adds rows.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&mut self, rows: impl IntoIterator<Item = impl Serialize>) -> Result<(), FolderError> {
        for row in rows {
            self.writer.serialize(row).map_err(|e| FolderError::new(&self.path, e))?;
        }
        Ok(())
    }

    /// Closes the file.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn finish(mut self) -> Result<(), FolderError> {
        self.writer.flush().map_err(|e| FolderError::new(&self.path, e))
    }
}

/// The columns of a row.
fn head(row: &impl Serialize) -> csv::Result<csv::StringRecord> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.serialize(row)?;
    let text = writer.into_inner().map_err(|e| std::io::Error::other(e.to_string()))?;
    csv::Reader::from_reader(&text[..]).headers().cloned()
}

/// All rows of a table.
///
/// # Errors
/// If the file is missing, or the first row that is not one of this table.
pub fn read<R: DeserializeOwned>(path: &Path) -> Result<Vec<R>, FolderError> {
    let mut reader = csv::Reader::from_path(path).map_err(|e| FolderError::new(path, e))?;
    reader.deserialize().collect::<Result<_, _>>().map_err(|e| FolderError::new(path, e))
}

/// All rows of a table that folders of earlier versions do not have; none if it is not there.
///
/// # Errors
/// The first row that is not one of this table.
pub fn read_if_there<R: DeserializeOwned>(path: &Path) -> Result<Vec<R>, FolderError> {
    if path.exists() { read(path) } else { Ok(Vec::new()) }
}

/// All rows of a table in a text.
///
/// # Errors
/// The first row that is not one of this table.
pub fn from_text<R: DeserializeOwned>(text: &str) -> csv::Result<Vec<R>> {
    csv::Reader::from_reader(text.as_bytes()).deserialize().collect()
}

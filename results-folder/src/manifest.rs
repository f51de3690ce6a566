//! `manifest.json`: what was run, how every process ended, and the checksums of all other files of the folder.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::FolderError;
use crate::files::MANIFEST;

/// The manifest of a results folder. What folders of earlier versions do not state is empty.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Name of the run.
    pub run_id: String,
    /// Hash of the launch file and the scenarios.
    #[serde(default)]
    pub configuration: String,
    /// Time of its start, in UTC.
    pub started: String,
    /// Versions of the program and of the message contract.
    pub versions: BTreeMap<String, String>,
    /// The text of the launch file.
    #[serde(default)]
    pub launch_file: String,
    /// The text of the scenario files, by scenario.
    pub scenarios: BTreeMap<String, String>,
    /// The case with which all others were compared: the first of the references.
    pub reference: String,
    /// That case and the cases that stand in where it withholds a figure, in their order.
    #[serde(default)]
    pub references: Vec<String>,
    /// The case in whose effort that of all cases is measured, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baseline: Option<String>,
    /// The tolerance against which methods were judged.
    #[serde(default)]
    pub tolerance: f64,
    /// The cases by label.
    pub cases: BTreeMap<String, CaseRecord>,
    /// How every process ended.
    #[serde(default)]
    pub nodes: BTreeMap<String, String>,
    /// Why cases failed, by label.
    pub failures: BTreeMap<String, String>,
    /// Whether everything that was asked for has been done or has failed by name.
    #[serde(default)]
    pub complete: bool,
    /// Why the results are incomplete, if they are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub incomplete_because: Option<String>,
    /// The other files of the folder.
    #[serde(default)]
    pub files: BTreeMap<String, FileRecord>,
}

/// What a case ran.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct CaseRecord {
    /// A node's name, or a command with its arguments.
    pub runs: Vec<String>,
    /// The node's settings, as `key=value`.
    pub settings: Vec<String>,
    /// The number of processes that shared its rows.
    #[serde(default)]
    pub shards: u32,
    /// Whether it sent counts and sums instead of samples.
    #[serde(default)]
    pub reduce: bool,
    /// The time that it was given for a scenario \[s\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub most_seconds: Option<f64>,
}

/// The manifest of a folder that holds results folders: those of a sweep or of a service.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct CollectionManifest {
    /// Name of the run.
    pub run_id: String,
    /// Hash of the launch file and the scenarios.
    pub configuration: String,
    /// Time of its start, in UTC.
    pub started: String,
    /// Versions of the program and of the message contract.
    pub versions: BTreeMap<String, String>,
    /// The text of the launch file.
    pub launch_file: String,
    /// The text of the sweep file; `None` for a service that takes requests.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep: Option<String>,
    /// Combinations or files that were refused, and why.
    pub refused: BTreeMap<String, String>,
    /// Whether everything that was asked for has been done or has failed by name.
    pub complete: bool,
    /// Why not all has been done, if it has not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub incomplete_because: Option<String>,
    /// The names of the results folders, one per scenario.
    pub folders: Vec<String>,
    /// The other files of the folder.
    pub files: BTreeMap<String, FileRecord>,
}

/// The files that a manifest lists, of a results folder or of a folder of such folders.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
pub struct Contents {
    /// The files, by their paths relative to the folder.
    pub files: BTreeMap<String, FileRecord>,
    /// The results folders in it.
    #[serde(default)]
    pub folders: BTreeSet<String>,
}

/// What a file of the folder must be.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileRecord {
    /// Its length.
    pub bytes: u64,
    /// Its SHA-256, in hexadecimal digits.
    pub sha256: String,
}

/// Reads the manifest of a folder, or the part of it that `M` describes.
///
/// # Errors
/// If there is none, or it is damaged.
pub fn read<M: for<'de> Deserialize<'de>>(folder: &Path) -> Result<M, FolderError> {
    let path = folder.join(MANIFEST);
    let cannot_be_read = |e: std::io::Error| format!("cannot be read ({e}); name a folder that `phasecloud run` wrote");
    let text = std::fs::read_to_string(&path).map_err(|e| FolderError::new(&path, cannot_be_read(e)))?;
    serde_json::from_str(&text).map_err(|e| FolderError::new(&path, e))
}

/// Writes the manifest of a folder, whole or not at all: an earlier one stays as it was if the disk is full.
///
/// # Errors
/// If it cannot be written.
pub fn write(folder: &Path, manifest: &impl Serialize) -> Result<(), FolderError> {
    let path = folder.join(MANIFEST);
    let text = serde_json::to_string_pretty(manifest).map_err(|e| FolderError::new(&path, e))?;
    let draft = folder.join(format!("{MANIFEST}.partial"));
    let written = std::fs::write(&draft, text + "\n").and_then(|()| std::fs::rename(&draft, &path));
    written.map_err(|e| {
        let _ = std::fs::remove_file(&draft);
        FolderError::new(&path, e)
    })
}

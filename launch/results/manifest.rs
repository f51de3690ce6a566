//! `manifest.json`: what was run, how every process ended, and the checksums of all other files of the folder.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::plan::cases::{Case, Runs};
use crate::plan::launch_file::Launch;
use crate::results::checksums::{self, FileRecord};
use crate::results::recording;

/// The manifest.
#[derive(Debug, Serialize)]
pub struct Manifest<'a> {
    run_id: String,
    configuration: String,
    started: &'a str,
    versions: BTreeMap<&'static str, &'static str>,
    launch_file: &'a str,
    scenarios: BTreeMap<&'a str, &'a str>,
    /// The first of the references.
    reference: &'a str,
    references: &'a [String],
    tolerance: f64,
    cases: BTreeMap<&'a str, CaseRecord>,
    nodes: &'a BTreeMap<String, String>,
    failures: &'a BTreeMap<String, String>,
    complete: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    incomplete_because: Option<&'a str>,
    files: BTreeMap<String, FileRecord>,
}

/// What a case ran.
#[derive(Debug, Serialize)]
struct CaseRecord {
    runs: Vec<String>,
    settings: Vec<String>,
    shards: u32,
    reduce: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    most_seconds: Option<f64>,
}

/// How a run went.
#[derive(Debug)]
pub struct Record<'a> {
    /// Names the run.
    pub run_id: u64,
    /// When it was started.
    pub started: String,
    /// How each process ended.
    pub nodes: &'a BTreeMap<String, String>,
    /// Why a case failed.
    pub failures: &'a BTreeMap<String, String>,
    /// Why the results are not whole, if they are not.
    pub incomplete: Option<&'a str>,
}

/// Writes the manifest into `folder`, still without checksums.
///
/// # Errors
/// If it cannot be written.
pub fn write(folder: &Path, launch: &Launch, record: &Record<'_>) -> Result<(), String> {
    let Record { run_id, started, nodes, failures, incomplete } = record;
    let manifest = Manifest {
        run_id: format!("{run_id:012x}"),
        configuration: recording::configuration(launch),
        started,
        versions: versions(),
        launch_file: &launch.text,
        scenarios: launch.scenarios.iter().map(|s| (s.content.name.as_str(), s.text.as_str())).collect(),
        reference: launch.references.first().map_or("", String::as_str),
        references: &launch.references,
        tolerance: launch.tolerance,
        cases: launch.cases.iter().map(|case| (case.label.as_str(), case_record(case))).collect(),
        nodes,
        failures,
        complete: incomplete.is_none(),
        incomplete_because: *incomplete,
        files: BTreeMap::new(),
    };
    write_json(folder, &manifest)
}

/// What a service or a sweep has done.
#[derive(Debug)]
pub struct Collection<'a> {
    /// Names the run.
    pub run_id: u64,
    /// When it was started.
    pub started: &'a str,
    /// The text of the sweep file; `None` for a service that takes requests.
    pub sweep: Option<&'a str>,
    /// The names of the results folders, one per scenario.
    pub folders: &'a [String],
    /// Combinations or files that were refused, and why.
    pub refused: &'a BTreeMap<String, String>,
    /// Why not all has been done, if it has not.
    pub incomplete: Option<&'a str>,
}

/// Writes the manifest of a folder that holds results folders, which have their own, with the checksums of its other
/// files.
///
/// # Errors
/// If it cannot be written.
pub fn write_collection(folder: &Path, launch: &Launch, collection: &Collection<'_>) -> Result<(), String> {
    #[derive(Serialize)]
    struct Written<'a> {
        run_id: String,
        configuration: String,
        started: &'a str,
        versions: BTreeMap<&'static str, &'static str>,
        launch_file: &'a str,
        #[serde(skip_serializing_if = "Option::is_none")]
        sweep: Option<&'a str>,
        refused: &'a BTreeMap<String, String>,
        complete: bool,
        #[serde(skip_serializing_if = "Option::is_none")]
        incomplete_because: Option<&'a str>,
        folders: &'a [String],
        files: BTreeMap<String, FileRecord>,
    }
    let Collection { run_id, started, sweep, folders, refused, incomplete } = *collection;
    let written = Written {
        run_id: format!("{run_id:012x}"),
        configuration: recording::configuration(launch),
        started,
        versions: versions(),
        launch_file: &launch.text,
        sweep,
        refused,
        complete: incomplete.is_none(),
        incomplete_because: incomplete,
        folders,
        files: checksums::of(folder)?,
    };
    write_json(folder, &written)
}

fn versions() -> BTreeMap<&'static str, &'static str> {
    BTreeMap::from([("phasecloud", env!("CARGO_PKG_VERSION")), ("iceoryx2", "0.10.0"), ("messages", "2")])
}

/// Writes the checksums of all other files of `folder` into its manifest; must be repeated after a file has changed.
///
/// # Errors
/// If there is no manifest, or it cannot be written.
pub fn seal(folder: &Path) -> Result<(), String> {
    let path = folder.join(checksums::MANIFEST);
    let failed = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
    let text = std::fs::read(&path).map_err(|e| failed(&e))?;
    let mut manifest: serde_json::Map<String, serde_json::Value> =
        serde_json::from_slice(&text).map_err(|e| failed(&e))?;
    let files = serde_json::to_value(checksums::of(folder)?).map_err(|e| failed(&e))?;
    manifest.insert("files".into(), files);
    write_json(folder, &manifest)
}

fn write_json(folder: &Path, manifest: &impl Serialize) -> Result<(), String> {
    let path = folder.join(checksums::MANIFEST);
    let text = serde_json::to_string_pretty(manifest).map_err(|e| format!("{}: {e}", path.display()))?;
    // The file is written whole or not at all: an earlier manifest stays as it was if the disk is full.
    let draft = folder.join(format!("{}.partial", checksums::MANIFEST));
    let written = std::fs::write(&draft, text + "\n").and_then(|()| std::fs::rename(&draft, &path));
    written.map_err(|e| {
        let _ = std::fs::remove_file(&draft);
        format!("{}: {e}", path.display())
    })
}

/// What a manifest says of a run.
pub struct Recorded {
    /// The launch file and the scenarios that it used.
    pub launch: Launch,
    /// Why cases failed.
    pub failures: BTreeMap<String, String>,
    /// Why the results are not whole, if they are not.
    pub incomplete: Option<String>,
}

/// What the manifest in `folder` says of run `run_id`; `None` if it is not there.
pub fn read(folder: &Path, run_id: &str) -> Option<Recorded> {
    #[derive(Deserialize)]
    struct Read {
        run_id: String,
        launch_file: String,
        scenarios: BTreeMap<String, String>,
        failures: BTreeMap<String, String>,
        #[serde(default)]
        incomplete_because: Option<String>,
    }
    let read: Read = serde_json::from_slice(&std::fs::read(folder.join("manifest.json")).ok()?).ok()?;
    let scenarios: Vec<_> = read.scenarios.into_iter().collect();
    let launch = Launch::from_record(&read.launch_file, &scenarios).ok()?;
    let Read { failures, incomplete_because: incomplete, .. } = read;
    (read.run_id == run_id).then_some(Recorded { launch, failures, incomplete })
}

/// Which cases of the run in `folder` failed, and why; `None` if there is no manifest.
pub fn failures(folder: &Path) -> Option<BTreeMap<String, String>> {
    #[derive(Deserialize)]
    struct Read {
        failures: BTreeMap<String, String>,
    }
    let read: Read = serde_json::from_slice(&std::fs::read(folder.join(checksums::MANIFEST)).ok()?).ok()?;
    Some(read.failures)
}

fn case_record(case: &Case) -> CaseRecord {
    let (runs, settings) = match &case.runs {
        Runs::BuiltIn { node, settings } => (vec![node.clone()], settings.to_lines().unwrap_or_default()),
        Runs::Recorded(file) => (vec!["recorded".into(), file.display().to_string()], Vec::new()),
        Runs::Command(command) => (command.clone(), Vec::new()),
    };
    CaseRecord { runs, settings, shards: case.shards, reduce: case.reduce, most_seconds: case.most_seconds }
}

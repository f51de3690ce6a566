//! What the launcher writes into `manifest.json`, and what it reads there.

use std::collections::BTreeMap;
use std::path::Path;

use results::manifest::{self, CaseRecord, CollectionManifest, Manifest};

use crate::plan::cases::{Case, Runs};
use crate::plan::launch_file::Launch;
use crate::record::{checksums, recording};

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
pub fn write(folder: &Path, launch: &Launch, record: Record<'_>) -> Result<(), String> {
    let Record { run_id, started, nodes, failures, incomplete } = record;
    let manifest = Manifest {
        run_id: format!("{run_id:012x}"),
        configuration: recording::configuration(launch),
        started,
        versions: versions(),
        launch_file: launch.text.clone(),
        scenarios: launch.scenarios.iter().map(|s| (s.content.name().to_owned(), s.text.clone())).collect(),
        reference: launch.references.first().cloned().unwrap_or_default(),
        references: launch.references.clone(),
        baseline: launch.baseline.clone(),
        tolerance: launch.tolerance,
        cases: launch.cases.iter().map(|case| (case.label.clone(), case_record(case))).collect(),
        nodes: nodes.clone(),
        failures: failures.clone(),
        complete: incomplete.is_none(),
        incomplete_because: incomplete.map(str::to_owned),
        files: BTreeMap::new(),
    };
    manifest::write(folder, &manifest).map_err(|e| e.to_string())
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
    let Collection { run_id, started, sweep, folders, refused, incomplete } = *collection;
    let manifest = CollectionManifest {
        run_id: format!("{run_id:012x}"),
        configuration: recording::configuration(launch),
        started: started.into(),
        versions: versions(),
        launch_file: launch.text.clone(),
        sweep: sweep.map(str::to_owned),
        refused: refused.clone(),
        complete: incomplete.is_none(),
        incomplete_because: incomplete.map(str::to_owned),
        folders: folders.to_vec(),
        files: checksums::of(folder)?,
    };
    manifest::write(folder, &manifest).map_err(|e| e.to_string())
}

fn versions() -> BTreeMap<String, String> {
    [("phasecloud", env!("CARGO_PKG_VERSION")), ("iceoryx2", "0.10.0"), ("messages", "2")]
        .map(|(name, version)| (name.to_owned(), version.to_owned()))
        .into()
}

/// Writes the checksums of all other files of `folder` into its manifest; must be repeated after a file has changed.
///
/// # Errors
/// If there is no manifest, or it cannot be written.
pub fn seal(folder: &Path) -> Result<(), String> {
    // Read as it stands, so that nothing is lost that another version has written.
    let mut manifest: serde_json::Map<String, serde_json::Value> = manifest::read(folder).map_err(|e| e.to_string())?;
    let files = serde_json::to_value(checksums::of(folder)?).map_err(|e| e.to_string())?;
    manifest.insert("files".into(), files);
    manifest::write(folder, &manifest).map_err(|e| e.to_string())
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
    let read: Manifest = manifest::read(folder).ok()?;
    let scenarios: Vec<_> = read.scenarios.into_iter().collect();
    let launch = Launch::from_record(&read.launch_file, &scenarios).ok()?;
    let (failures, incomplete) = (read.failures, read.incomplete_because);
    (read.run_id == run_id).then_some(Recorded { launch, failures, incomplete })
}

fn case_record(case: &Case) -> CaseRecord {
    let (runs, settings) = match &case.runs {
        Runs::BuiltIn { node, settings } => (vec![node.clone()], settings.to_lines().unwrap_or_default()),
        Runs::Recorded(file) => (vec!["recorded".into(), file.display().to_string()], Vec::new()),
        Runs::Command(command) => (command.clone(), Vec::new()),
    };
    CaseRecord { runs, settings, shards: case.shards, reduce: case.reduce, most_seconds: case.most_seconds }
}

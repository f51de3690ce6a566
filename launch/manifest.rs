//! `manifest.json`: what was run, and how every process ended, and the checksums of all other files of the folder.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use crate::checksums::{self, FileRecord};
use crate::launch_file::{Launch, Runs};

/// The manifest.
#[derive(Debug, Serialize)]
pub struct Manifest<'a> {
    run_id: String,
    started: String,
    versions: BTreeMap<&'static str, &'static str>,
    launch_file: &'a str,
    scenarios: BTreeMap<&'a str, &'a str>,
    reference: &'a str,
    cases: BTreeMap<&'a str, CaseRecord>,
    nodes: &'a BTreeMap<String, String>,
    failures: &'a BTreeMap<String, String>,
    files: BTreeMap<String, FileRecord>,
}

/// What a case ran.
#[derive(Debug, Serialize)]
struct CaseRecord {
    runs: Vec<String>,
    settings: Vec<String>,
}

/// Writes the manifest into `folder`, after every other file. `nodes` says how each process ended, `failures` why a case failed.
///
/// # Errors
/// If it cannot be written.
pub fn write(
    folder: &Path,
    launch: &Launch,
    run_id: u64,
    started: String,
    nodes: &BTreeMap<String, String>,
    failures: &BTreeMap<String, String>,
) -> Result<(), String> {
    let manifest = Manifest {
        run_id: format!("{run_id:012x}"),
        started,
        versions: BTreeMap::from([
            ("phasecloud", env!("CARGO_PKG_VERSION")),
            ("iceoryx2", "0.10.0"),
            ("messages", "1"),
        ]),
        launch_file: &launch.text,
        scenarios: launch.scenarios.iter().map(|s| (s.content.name.as_str(), s.text.as_str())).collect(),
        reference: &launch.reference,
        cases: launch.cases.iter().map(|case| (case.label.as_str(), record(&case.runs))).collect(),
        nodes,
        failures,
        files: checksums::of(folder)?,
    };
    let path = folder.join(checksums::MANIFEST);
    let text = serde_json::to_string_pretty(&manifest).map_err(|e| format!("{}: {e}", path.display()))?;
    std::fs::write(&path, text + "\n").map_err(|e| format!("{}: {e}", path.display()))
}

fn record(runs: &Runs) -> CaseRecord {
    match runs {
        Runs::BuiltIn { node, settings } => {
            CaseRecord { runs: vec![node.clone()], settings: settings.to_lines().unwrap_or_default() }
        }
        Runs::Command(command) => CaseRecord { runs: command.clone(), settings: Vec::new() },
    }
}

//! `manifest.json`: what was run, and how every process ended.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::launch_file::{Launch, Runs};
use crate::recording;

/// The manifest.
#[derive(Debug, Serialize)]
pub struct Manifest<'a> {
    run_id: String,
    configuration: String,
    started: String,
    versions: BTreeMap<&'static str, &'static str>,
    launch_file: &'a str,
    scenarios: BTreeMap<&'a str, &'a str>,
    reference: &'a str,
    cases: BTreeMap<&'a str, CaseRecord>,
    nodes: &'a BTreeMap<String, String>,
    failures: &'a BTreeMap<String, String>,
}

/// What a case ran.
#[derive(Debug, Serialize)]
struct CaseRecord {
    runs: Vec<String>,
    settings: Vec<String>,
}

/// Writes the manifest into `folder`. `nodes` says how each process ended, `failures` why a case failed.
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
        configuration: recording::configuration(launch),
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
    };
    let path = folder.join("manifest.json");
    let text = serde_json::to_string_pretty(&manifest).map_err(|e| format!("{}: {e}", path.display()))?;
    std::fs::write(&path, text + "\n").map_err(|e| format!("{}: {e}", path.display()))
}

/// What run `run_id` used and which of its cases failed, from the manifest in `folder`; `None` if it is not there.
pub fn read(folder: &Path, run_id: &str) -> Option<(Launch, BTreeMap<String, String>)> {
    #[derive(Deserialize)]
    struct Read {
        run_id: String,
        launch_file: String,
        scenarios: BTreeMap<String, String>,
        failures: BTreeMap<String, String>,
    }
    let read: Read = serde_json::from_slice(&std::fs::read(folder.join("manifest.json")).ok()?).ok()?;
    let scenarios: Vec<_> = read.scenarios.into_iter().collect();
    let launch = Launch::from_record(&read.launch_file, &scenarios).ok()?;
    (read.run_id == run_id).then_some((launch, read.failures))
}

fn record(runs: &Runs) -> CaseRecord {
    match runs {
        Runs::BuiltIn { node, settings } => {
            CaseRecord { runs: vec![node.clone()], settings: settings.to_lines().unwrap_or_default() }
        }
        Runs::Recorded(file) => {
            CaseRecord { runs: vec!["recorded".into(), file.display().to_string()], settings: Vec::new() }
        }
        Runs::Command(command) => CaseRecord { runs: command.clone(), settings: Vec::new() },
    }
}

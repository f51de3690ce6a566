//! A run as JSON: one object per line on standard output, events as they happen and the results at the end.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use serde_json::{Map, Value, json};

use super::progress::NodeState;

/// Writes an object as one line. The run goes on even if nobody reads it any more.
pub fn line(object: &Value) {
    say!("{object}");
}

/// Writes how far a node is.
pub fn progress(node: &NodeState, scenario: &str, now: Instant) {
    line(&json!({
        "event": "progress",
        "node": node.who.to_string(),
        "phase": node.phase,
        "scenario": scenario,
        "done": node.done,
        "of": node.of,
        "per_second": node.per_second(now),
        "seconds_left": node.seconds_left(now),
    }));
}

/// Writes that a service takes requests.
pub fn serving(run_id: u64) {
    line(&json!({"event": "serving", "run": format!("{run_id:012x}")}));
}

/// Writes the end of a service, with the folder that holds the results folders of all its scenarios.
pub fn served(folder: &Path, scenarios: usize, seconds: f64) {
    let folder = folder.display().to_string();
    line(&json!({"event": "served", "folder": folder, "scenarios": scenarios, "seconds": seconds}));
}

/// Writes that a case cannot be completed.
pub fn failure(name: &str, why: &str) {
    line(&json!({"event": "failure", "node": name, "problem": why}));
}

/// Writes the end of a run without results.
pub fn no_result(exit_code: u8, problem: &str) {
    line(&json!({"event": "result", "exit_code": exit_code, "problem": problem}));
}

/// Writes the end of a run, with the tables in its results folder, and why they are not whole if they are not.
pub fn result(exit_code: u8, folder: &Path, failures: &BTreeMap<String, String>, incomplete: Option<&str>) {
    let tables = tables(folder);
    let folder = folder.display().to_string();
    let complete = incomplete.is_none();
    let mut end = json!({
        "event": "result", "exit_code": exit_code, "folder": folder, "complete": complete, "failures": failures, "tables": tables,
    });
    if let (Some(why), Some(end)) = (incomplete, end.as_object_mut()) {
        end.insert("problem".into(), why.into());
    }
    line(&end);
}

/// All CSV files of a folder: for each a list of rows, from column to value; numbers that are not finite become null.
fn tables(folder: &Path) -> Map<String, Value> {
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut tables = Map::new();
    for path in files.filter(|path| path.extension().is_some_and(|extension| extension == "csv")) {
        let Ok(mut reader) = csv::Reader::from_path(&path) else { continue };
        let heads = reader.headers().cloned().unwrap_or_default();
        let row = |row: csv::StringRecord| -> Value {
            heads.iter().map(str::to_owned).zip(row.iter().map(value)).collect::<Map<_, _>>().into()
        };
        let rows: Vec<Value> = reader.records().flatten().map(row).collect();
        tables.insert(path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), rows.into());
    }
    tables
}

fn value(text: &str) -> Value {
    match text.parse::<f64>() {
        Ok(number) => number.into(),
        Err(_) => text.into(),
    }
}

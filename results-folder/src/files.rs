//! The names of the files of a results folder.

use std::path::{Path, PathBuf};

/// What was run, how every process ended, and the checksums of all other files.
pub const MANIFEST: &str = "manifest.json";
/// Moments of every case at every snapshot.
pub const MOMENTS: &str = "moments.csv";
/// Errors of the moments against a reference.
pub const ERRORS: &str = "errors.csv";
/// Distances of the densities from those of a reference.
pub const DISTANCES: &str = "distances.csv";
/// Computational effort of every case.
pub const EFFORT: &str = "effort.csv";
/// First-passage curves.
pub const FIRST_PASSAGE: &str = "first_passage.csv";
/// What re-entry, and none, says of an uncertain radiation parameter.
pub const GIVEN_RE_ENTRY: &str = "given_re_entry.csv";
/// What every method says of its own reliability, in numbers.
pub const DIAGNOSTICS: &str = "diagnostics.csv";
/// What is to be known of the results, in words.
pub const NOTES: &str = "notes.csv";
/// What every method is good for.
pub const VERDICTS: &str = "verdicts.csv";
/// The densities as numpy arrays.
pub const DENSITIES: &str = "densities.npz";
/// What every scenario is about: its variables, and which column or array has which quantity.
pub const DESCRIPTIONS: &str = "scenarios.jsonl";
/// The folder of the scenario files, as their authors wrote them.
pub const SCENARIOS: &str = "scenarios";
/// The file in the folder of a single scenario that says what was run.
pub const SCENARIO: &str = "scenario.toml";

/// The folder of the files of scenario number `scenario`, in the folder that the recorder writes to.
pub fn part(folder: &Path, scenario: u32) -> PathBuf {
    folder.join(format!("part-{scenario:06}"))
}

/// Whether a path is that of the folder of a single scenario, whether complete or not.
pub fn is_part(path: &Path) -> bool {
    path.is_dir() && path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("part-"))
}

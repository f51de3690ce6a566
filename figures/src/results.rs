//! Reads a results folder.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::densities::{self, Densities};
pub use crate::folder_error::FolderError;
pub use crate::moments_row::MomentsRow;

/// The program and the settings of a case.
#[derive(Debug, Clone, Deserialize)]
pub struct CaseSettings {
    /// A node's name, or a command with its arguments.
    pub runs: Vec<String>,
    /// The node's settings, as `key=value`.
    pub settings: Vec<String>,
}

/// `manifest.json`, as far as the figures and the report need it.
#[derive(Debug, Clone, Deserialize)]
pub struct Manifest {
    /// Name of the run.
    pub run_id: String,
    /// Time of its start, in UTC.
    pub started: String,
    /// Versions of the program and of the message contract.
    pub versions: BTreeMap<String, String>,
    /// The text of the scenario files, by scenario.
    pub scenarios: BTreeMap<String, String>,
    /// The case with which all others were compared.
    pub reference: String,
    /// That case and the cases that stand in where it withholds a figure, in their order; empty in folders of versions
    /// with one reference only.
    #[serde(default)]
    pub references: Vec<String>,
    /// The cases by label.
    pub cases: BTreeMap<String, CaseSettings>,
    /// Why cases failed, by label.
    pub failures: BTreeMap<String, String>,
    /// Why the results are incomplete, if they are.
    #[serde(default)]
    pub incomplete_because: Option<String>,
}

/// A row of `errors.csv`.
#[derive(Debug, Clone, Deserialize)]
#[expect(missing_docs, reason = "the columns are the documented ones of the results folder")]
pub struct ErrorRow {
    pub scenario: String,
    pub method: String,
    pub t_yr: f64,
    pub quantity: String,
    pub reference_value: f64,
    pub abs_error: f64,
    pub rel_error: f64,
}

/// A row of `distances.csv`.
#[derive(Debug, Clone, Deserialize)]
#[expect(missing_docs, reason = "the columns are the documented ones of the results folder")]
pub struct DistanceRow {
    pub scenario: String,
    pub method: String,
    pub t_yr: f64,
    pub density: String,
    pub measure: String,
    pub value: f64,
}

/// A row of `effort.csv`.
#[derive(Debug, Clone, Deserialize)]
#[expect(missing_docs, reason = "the columns are the documented ones of the results folder")]
pub struct EffortRow {
    pub scenario: String,
    pub method: String,
    pub t_prop_s: f64,
    pub t_int_s: f64,
    pub t_cal_s: f64,
    pub ratio_to_mc: f64,
    /// NaN for a method that follows no trajectories, and in folders of versions that did not record it.
    #[serde(default = "not_a_number")]
    pub trajectories: f64,
}

fn not_a_number() -> f64 {
    f64::NAN
}

/// A row of `first_passage.csv`.
#[derive(Debug, Clone, Deserialize)]
#[expect(missing_docs, reason = "the columns are the documented ones of the results folder")]
pub struct PassageRow {
    pub scenario: String,
    pub method: String,
    pub t_yr: f64,
    pub prob_reached_critical_e: f64,
    pub low: f64,
    pub high: f64,
    /// The meaning of `low` and `high`; empty without an interval, and in folders of versions that did not state it.
    #[serde(default)]
    pub interval: String,
}

/// A row of `diagnostics.csv`.
#[derive(Debug, Clone, Deserialize)]
#[expect(missing_docs, reason = "the columns are the documented ones of the results folder")]
pub struct DiagnosticRow {
    pub scenario: String,
    pub method: String,
    pub t_yr: f64,
    pub diagnostic: String,
    pub value: f64,
}

/// A row of `notes.csv`.
#[derive(Debug, Clone, Deserialize)]
#[expect(missing_docs, reason = "the columns are the documented ones of the results folder")]
pub struct NoteRow {
    pub scenario: String,
    pub method: String,
    pub t_yr: f64,
    pub note: String,
}

/// A row of `verdicts.csv`.
#[derive(Debug, Clone, Deserialize)]
#[expect(missing_docs, reason = "the columns are the documented ones of the results folder")]
pub struct VerdictRow {
    pub scenario: String,
    pub method: String,
    pub verdict: String,
    pub tolerance: f64,
    pub moments_error: f64,
    pub moments_noise: f64,
    pub moments_quantity: String,
    pub moments_t_yr: f64,
    pub moments_judged_by: String,
    pub density_error: f64,
    pub density_noise: f64,
    pub density_t_yr: f64,
    pub density_judged_by: String,
}

/// The contents of a results folder.
#[derive(Debug)]
#[expect(missing_docs, reason = "one field a file")]
pub struct Results {
    pub manifest: Manifest,
    pub moments: Vec<MomentsRow>,
    pub errors: Vec<ErrorRow>,
    pub distances: Vec<DistanceRow>,
    pub effort: Vec<EffortRow>,
    pub passages: Vec<PassageRow>,
    pub diagnostics: Vec<DiagnosticRow>,
    pub notes: Vec<NoteRow>,
    pub verdicts: Vec<VerdictRow>,
    pub densities: Densities,
}

impl Results {
    /// Reads the folder.
    ///
    /// # Errors
    /// [`FolderError`] names the first file that is missing or damaged.
    pub fn read(folder: &Path) -> Result<Self, FolderError> {
        let path = folder.join("manifest.json");
        let text = std::fs::read_to_string(&path).map_err(|e| FolderError::new(&path, no_results(&e)))?;
        let manifest = serde_json::from_str(&text).map_err(|e| FolderError::new(&path, e))?;
        let moments: Vec<MomentsRow> = table(&folder.join("moments.csv"))?;
        let densities = densities::read(&folder.join("densities.npz"), &moments)?;
        Ok(Self {
            manifest,
            errors: table(&folder.join("errors.csv"))?,
            distances: table(&folder.join("distances.csv"))?,
            effort: table(&folder.join("effort.csv"))?,
            passages: table(&folder.join("first_passage.csv"))?,
            diagnostics: table(&folder.join("diagnostics.csv"))?,
            notes: table(&folder.join("notes.csv"))?,
            verdicts: table_if_there(&folder.join("verdicts.csv"))?,
            moments,
            densities,
        })
    }
}

fn no_results(error: &std::io::Error) -> String {
    format!("cannot be read ({error}); name a folder that `phasecloud run` wrote")
}

/// A table that folders of earlier versions do not have.
fn table_if_there<T: DeserializeOwned>(path: &Path) -> Result<Vec<T>, FolderError> {
    if path.exists() { table(path) } else { Ok(Vec::new()) }
}

fn table<T: DeserializeOwned>(path: &Path) -> Result<Vec<T>, FolderError> {
    let mut reader = csv::Reader::from_path(path).map_err(|e| FolderError::new(path, e))?;
    reader.deserialize().collect::<Result<_, _>>().map_err(|e| FolderError::new(path, e))
}

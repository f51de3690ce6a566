//! Launch files, checked before anything is started; and tables of Python as TOML.

use std::path::PathBuf;

use launch::plan::launch_file::Launch;
use pyo3::prelude::*;

use crate::errors;

/// Checks a launch file with its scenarios, and that the programs which it names are there. Returns the labels of its
/// cases.
#[pyfunction]
pub(crate) fn check_launch(py: Python<'_>, path: PathBuf) -> PyResult<Vec<String>> {
    let launch = Launch::load_to_start(Some(&path), None).map_err(|error| errors::input(py, &error))?;
    Ok(launch.cases.into_iter().map(|case| case.label).collect())
}

/// A table, given as JSON, in TOML.
#[pyfunction]
pub(crate) fn toml_from_json(json: &str) -> PyResult<String> {
    let told = |why: String| errors::value(format!("this cannot be written into a file: {why}"));
    let table: toml::Table = serde_json::from_str(json).map_err(|error| told(error.to_string()))?;
    toml::to_string(&table).map_err(|error| told(error.to_string()))
}

/// The text of a TOML file as JSON.
#[pyfunction]
pub(crate) fn json_from_toml(text: &str) -> PyResult<String> {
    let table: toml::Table = toml::from_str(text).map_err(|error| errors::value(error.to_string()))?;
    serde_json::to_string(&table).map_err(|error| errors::value(error.to_string()))
}

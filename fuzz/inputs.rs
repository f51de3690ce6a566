//! Properties that must hold for every text that is given to phasecloud as a scenario file or launch file.
//!
//! Shared by the fuzz targets of this folder, the tests of the workspace and `examples/fuzz_inputs.rs`.

use std::path::Path;

use density::model::PlanarHamiltonian;
use launch::plan::launch_file::Launch;
use nodes::files::input::{InputError, InputFile, is_plain_name};
use nodes::files::scenario_file::{self, AnyScenario};
use toml::de::DeTable;

/// Reads `bytes` as a scenario file.
///
/// # Panics
/// If a file is accepted with a value out of range, or a refusal does not say file, line and key.
pub fn scenario_file(bytes: &[u8]) {
    let path = Path::new("folder/scenario.toml");
    match InputFile::from_bytes(path, bytes.to_vec()).and_then(|file| scenario_file::check_any(&file)) {
        Ok(AnyScenario::InSpace(scenario)) => {
            assert!(is_plain_name(&scenario.name));
            assert!(scenario.model.force_parameters().iter().all(|(_, value)| value.is_finite()), "{scenario:?}");
            assert!(scenario.times.len() <= 4096 && scenario.times.is_sorted_by(|a, b| a < b));
        }
        Ok(AnyScenario::InPlane { scenario, .. }) => {
            assert!(is_plain_name(&scenario.name));
            let problem = scenario.problem;
            let parameters = problem.model.parameters().into_iter().map(|(_, value)| value);
            let numbers: Vec<f64> = parameters.chain([problem.initial.mean_phi]).collect();
            assert!(numbers.iter().all(|number| number.is_finite()), "{numbers:?}");
            assert!(problem.initial.sigma_phi > 0.0 && problem.initial.sigma_e > 0.0);
            assert!(problem.times.len() <= 4096 && problem.times.is_sorted_by(|a, b| a < b));
        }
        Err(error) => check(path, bytes, &error),
    }
}

/// Reads `bytes` as a launch file whose scenario is the one built in.
///
/// # Panics
/// If a file is accepted with a value out of range, or a refusal does not say file, line and key.
pub fn launch_file(bytes: &[u8]) {
    // This file does not exist: a launch file that is good except for the scenarios that it names is refused for these.
    let path = Path::new("/nonexistent/launch.toml");
    let read = InputFile::from_bytes(path, bytes.to_vec()).and_then(|file| Launch::check(&file, Some(path), None));
    match read {
        Ok(launch) => {
            assert!(is_plain_name(&launch.name) && launch.cases.iter().all(|case| is_plain_name(&case.label)));
            assert!((1..=64).contains(&launch.cases.len()));
            assert!(launch.patience > 0.0 && launch.bins.0.max(launch.bins.1) <= 2000);
        }
        Err(error) => check(path, bytes, &error),
    }
}

/// Checks that file, line and key are named, and that the message cannot command a terminal.
fn check(path: &Path, bytes: &[u8], error: &InputError) {
    let text = String::from_utf8_lossy(bytes);
    assert_eq!(error.file, path);
    let lines = text.matches('\n').count() + 1;
    assert!((1..=lines).contains(&error.line), "{error} in {lines} lines of {text:?}");
    let is_toml = std::str::from_utf8(bytes).is_ok_and(|text| DeTable::parse(text).is_ok());
    assert!(!error.key.is_empty() || !is_toml, "no key: {error} in {text:?}");
    let message = error.to_string();
    assert!(!error.problem.is_empty() && message.chars().count() < 5000, "{message}");
    assert!(!message.chars().any(char::is_control), "{message:?}");
}

//! Scenarios in any model.

use std::path::Path;

use super::{
    ScenarioFile, ScenarioInSpace, check, in_space, model_name, orbit, shadowed_plane, text_in_space, to_text,
};
use crate::files::file_kind::FileKind;
use crate::files::input::{InputError, InputFile};

/// A scenario in any model.
#[derive(Debug, Clone, PartialEq)]
pub enum AnyScenario {
    /// In a planar model.
    InPlane {
        /// The scenario.
        scenario: ScenarioFile,
        /// The semi-major axis \[Earth radii\], if the file gives it.
        semi_major_axis: Option<f64>,
    },
    /// In a model in space.
    InSpace(ScenarioInSpace),
}

impl AnyScenario {
    /// Its name.
    pub fn name(&self) -> &str {
        match self {
            Self::InPlane { scenario, .. } => &scenario.name,
            Self::InSpace(scenario) => &scenario.name,
        }
    }

    /// Snapshot times \[yr\], ascending from zero.
    pub fn times(&self) -> &[f64] {
        match self {
            Self::InPlane { scenario, .. } => &scenario.problem.times,
            Self::InSpace(scenario) => &scenario.times,
        }
    }

    /// Eccentricity at which the satellite re-enters, if the scenario says it.
    pub fn critical_e(&self) -> Option<f64> {
        match self {
            Self::InPlane { scenario, .. } => Some(scenario.problem.critical_e),
            Self::InSpace(scenario) => scenario.critical_e,
        }
    }

    /// Number of variables of its cloud.
    pub fn variables(&self) -> usize {
        match self {
            Self::InPlane { scenario, .. } => 2 + usize::from(scenario.spread.is_some()),
            Self::InSpace(scenario) => scenario.cloud.as_ref().map_or(0, |cloud| cloud.variables().len()),
        }
    }

    /// The scenario, if its model is planar.
    pub fn in_plane(&self) -> Option<&ScenarioFile> {
        match self {
            Self::InPlane { scenario, .. } => Some(scenario),
            Self::InSpace(_) => None,
        }
    }

    /// The text of a scenario file that states it; `None` if it has no cloud.
    pub fn to_text(&self) -> Option<String> {
        match self {
            Self::InPlane { scenario: ScenarioFile { name, problem, spread, .. }, .. } => {
                Some(to_text(name, problem, *spread))
            }
            Self::InSpace(scenario) => Some(text_in_space::to_text(&scenario.name, scenario.cloud.as_ref()?)),
        }
    }
}

/// Checks a scenario file in any model that has been read. One in space may describe a single orbit, without a cloud
/// about it.
///
/// # Errors
/// [`InputError`] with file, line and key.
pub fn check_any(file: &InputFile) -> Result<AnyScenario, InputError> {
    file.expect(FileKind::Scenario)?;
    let model = model_name::read(file)?;
    if model.is_in_space() {
        return in_space::check(file, model, false).map(AnyScenario::InSpace);
    }
    if model_name::is_shadowed_plane(file)? {
        return shadowed_plane::check(file).map(AnyScenario::InSpace);
    }
    let scenario = check(file)?;
    let raw: super::Raw = file.parse()?;
    Ok(AnyScenario::InPlane { scenario, semi_major_axis: orbit::semi_major_axis(file, &raw.orbit)? })
}

/// The same for a scenario that must describe a cloud.
///
/// # Errors
/// [`InputError`] with file, line and key.
pub fn check_cloud(file: &InputFile) -> Result<AnyScenario, InputError> {
    file.expect(FileKind::Scenario)?;
    let model = model_name::read(file)?;
    match model.is_in_space() {
        true => in_space::check(file, model, true).map(AnyScenario::InSpace),
        false => check_any(file),
    }
}

/// Reads and checks a scenario file that must describe a cloud.
///
/// # Errors
/// [`InputError`] with file, line and key.
pub fn load_cloud(path: &Path) -> Result<AnyScenario, InputError> {
    check_cloud(&InputFile::read(path)?)
}

//! Scenario files: the problem as a user writes it.

use std::path::Path;

use density::model::PlanarHamiltonian;
use density::model::registry::{DEFAULT_FORCES, Planar};
use density::problem::Problem;
use density::problem_error::{Field, ProblemError};
use density::uncertain::{Distribution, Spread, UncertainProblem};
use kit::problem_key::key;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;
use toml::Spanned;

use crate::files::file_kind::FileKind;
use crate::files::input::{InputError, InputFile};

use disposal::Disposal;
use epoch::EpochTable;
use initial::Initial;
use orbit::{Model, Orbit};
use refusals::{check_name, in_words};
use times::Times;

mod angle;
mod any;
mod disposal;
mod epoch;
mod in_space;
mod initial;
mod measure;
mod model_name;
mod orbit;
mod refusals;
mod shadowed_plane;
mod start;
mod text_in_space;
mod times;

pub use any::{AnyScenario, check_any, check_cloud, load_cloud};
pub use epoch::Epoch;
pub use in_space::ScenarioInSpace;
pub use times::is_right_number_of_times;

/// A scenario as its file describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct ScenarioFile {
    /// Its name.
    pub name: String,
    /// The problem.
    pub problem: Problem<Planar>,
    /// How uncertain its radiation parameter is, if it is.
    pub spread: Option<Spread>,
    /// The date at `t = 0`, if the file says it.
    pub epoch: Option<Epoch>,
}

impl ScenarioFile {
    /// The problem with its uncertain radiation parameter; `None` if that is certain.
    pub fn uncertain(&self) -> Option<UncertainProblem> {
        self.spread.map(|spread| UncertainProblem { plane: self.problem.clone(), spread })
    }
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Raw {
    #[schemars(with = "String")]
    name: Spanned<String>,
    model: Option<Model>,
    epoch: Option<EpochTable>,
    #[schemars(with = "Orbit")]
    orbit: Spanned<Orbit>,
    #[schemars(with = "Initial")]
    initial: Spanned<Initial>,
    #[schemars(with = "Times")]
    times: Spanned<Times>,
    #[schemars(with = "Disposal")]
    disposal: Spanned<Disposal>,
}

/// The schemas of a scenario file: in a planar model, and in one in space.
pub(super) fn schemas(generator: &mut SchemaGenerator) -> [Schema; 2] {
    [Raw::json_schema(generator), in_space::schema(generator)]
}

/// Reads and checks a scenario file.
///
/// # Errors
/// [`InputError`] with file, line and key.
pub fn load(path: &Path) -> Result<ScenarioFile, InputError> {
    check(&InputFile::read(path)?)
}

/// Checks a scenario file that has been read.
///
/// # Errors
/// [`InputError`] with file, line and key.
pub fn check(file: &InputFile) -> Result<ScenarioFile, InputError> {
    file.expect(FileKind::Scenario)?;
    model_name::expect_plane(file)?;
    let raw: Raw = file.parse()?;
    if let Some(obliquity) = raw.model.as_ref().and_then(|model| model.obliquity.as_ref()) {
        return Err(file.error(obliquity, "has no effect: the planar model has the Sun in the equator; leave it out"));
    }
    check_name(file, &raw.name)?;
    let initial = Initial::read(file, &raw.initial)?;
    let model = orbit::read(file, raw.model.as_ref(), &raw.orbit)?;
    let epoch = raw.epoch.as_ref().map(|table| Epoch::read(file, table)).transpose()?;
    let times = times::read(file, &raw.times, epoch.as_ref())?;
    let critical_e = Disposal::read(file, &raw.disposal, orbit::semi_major_axis(file, &raw.orbit)?)?;
    let located = |error: ProblemError| raw.locate(file, &error);
    let problem = Problem::new(model, initial, times, critical_e).map_err(located)?;
    let spread = Initial::spread(file, &raw.initial)?;
    if let Some(spread) = spread {
        UncertainProblem::new(problem.clone(), spread).map_err(located)?;
    }
    Ok(ScenarioFile { name: raw.name.get_ref().clone(), problem, spread, epoch })
}

impl Raw {
    /// The line and key of what is wrong with the problem.
    fn locate(&self, file: &InputFile, error: &ProblemError) -> InputError {
        let problem = in_words(error);
        match error.field {
            Field::Parameter(name) => Orbit::locate(&self.orbit, file, name, &problem),
            Field::CriticalE | Field::ReentryAltitude => Disposal::locate(&self.disposal, file, &problem),
            Field::Times => Times::locate(&self.times, file, &problem),
            Field::Shadow if let Some(model) = &self.model => model.at_forces(file, &problem),
            field => match key(field).split_once('.') {
                Some(("initial", _)) => Initial::locate(&self.initial, file, field, &problem),
                _ => file.error_in_whole(&key(field), &problem),
            },
        }
    }
}

/// The text of a scenario file that states `problem`, whose radiation parameter may be uncertain.
pub fn to_text(name: &str, problem: &Problem<Planar>, spread: Option<Spread>) -> String {
    let Problem { model, initial, times, critical_e } = problem;
    let parameters = model.parameters();
    let forces: Vec<&str> = parameters.iter().map(|(parameter, _)| parameter.force).collect();
    let forces = if forces == DEFAULT_FORCES { String::new() } else { format!("[model]\nforces = {forces:?}\n\n") };
    let orbit: String =
        parameters.iter().map(|(parameter, value)| format!("{} = {value:?}\n", parameter.name)).collect();
    let correlation = match initial.correlation {
        0.0 => String::new(),
        correlation => format!("correlation = {correlation:?}\n"),
    };
    let uncertainty = spread.map_or(String::new(), |Spread { relative, distribution }| {
        let distribution = match distribution {
            Distribution::Gaussian => "",
            Distribution::LogNormal => "radiation_distribution = \"log-normal\"\n",
        };
        format!("sigma_radiation = {relative:?}\n{distribution}")
    });
    format!(
        "name = \"{name}\"\n\n{forces}[orbit]\n{orbit}\n[initial]\nphi = {:?}\ne = {:?}\n\
         delta_phi = {:?}\ndelta_e = {:?}\n{correlation}{uncertainty}\n[times]\nat = {times:?}\n\n[disposal]\ncritical_e = {critical_e:?}\n",
        initial.mean_phi,
        initial.mean_e,
        2.0 * initial.sigma_phi,
        2.0 * initial.sigma_e,
    )
}

#[cfg(test)]
mod tests;

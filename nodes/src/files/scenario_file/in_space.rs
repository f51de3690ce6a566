//! Scenario files whose model is one in space.

use std::f64::consts::FRAC_PI_2;

use density::in_space::SpaceProblem;
use density::model::ecliptic::OBLIQUITY_DEGREES;
use density::model::model_name::ModelName;
use density::model::osculating::Osculating;
use density::model::parameter::{Named, Parameter};
use density::model::planar::RADIATION;
use density::model::space_registry::SpaceModel;
use density::model::sun_moon::SunMoon;
use density::model::vectorial::Vectorial;
use density::problem::check_times;
use density::problem_error::{Field, ProblemError};
use kit::problem_key::key;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;
use toml::Spanned;

use super::angle::{angle, turn};
use super::disposal::Disposal;
use super::epoch::{Epoch, EpochInSpace};
use super::measure::{self, Dimension, Measure};
use super::orbit::{self, Model, Orbit};
use super::refusals::{check_name, in_words};
use super::start::Start;
use super::times::{self, Times};
use crate::files::input::{InputError, InputFile};
use crate::files::plain_number::plain;

/// A scenario in space, as its file describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct ScenarioInSpace {
    /// Its name.
    pub name: String,
    /// The model.
    pub model: SpaceModel,
    /// Solar angle, eccentricity, inclination and node of the orbit at `t = 0` \[rad\].
    pub start: [f64; 4],
    /// Snapshot times \[yr\], ascending from zero.
    pub times: Vec<f64>,
    /// Eccentricity at which the satellite re-enters, if the file gives it.
    pub critical_e: Option<f64>,
    /// Whether the satellite passes the Earth's shadow.
    pub shadow: bool,
    /// The date at `t = 0`, if the file has one.
    pub epoch: Option<Epoch>,
    /// The cloud about the orbit, if the file says how well it is known and when it re-enters.
    pub cloud: Option<Box<SpaceProblem>>,
}

impl ScenarioInSpace {
    /// The scenario of a cloud.
    pub fn of_cloud(name: String, cloud: SpaceProblem) -> Self {
        Self {
            name,
            model: cloud.model,
            start: cloud.initial.mean,
            times: cloud.times.clone(),
            critical_e: Some(cloud.critical_e),
            shadow: cloud.shadow,
            epoch: None,
            cloud: Some(Box::new(cloud)),
        }
    }
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Raw {
    #[schemars(with = "String")]
    name: Spanned<String>,
    model: Model,
    #[schemars(with = "EpochInSpace")]
    epoch: Spanned<EpochInSpace>,
    #[schemars(with = "Orbit")]
    orbit: Spanned<Orbit>,
    #[schemars(with = "Start")]
    initial: Spanned<Start>,
    #[schemars(with = "Times")]
    times: Spanned<Times>,
    #[schemars(with = "Option<Disposal>")]
    disposal: Option<Spanned<Disposal>>,
}

/// The schema of such a file.
pub(super) fn schema(generator: &mut SchemaGenerator) -> Schema {
    Raw::json_schema(generator)
}

/// Checks a scenario file whose model is this one, in space; it must describe a cloud if one `is_needed`.
///
/// # Errors
/// [`InputError`] with file, line and key.
pub(super) fn check(file: &InputFile, name: ModelName, is_needed: bool) -> Result<ScenarioInSpace, InputError> {
    let raw: Raw = file.parse()?;
    check_name(file, &raw.name)?;
    let axis = orbit::semi_major_axis(file, &raw.orbit)?;
    let forces = forces(file, Some(&raw.model), &raw.orbit, axis)?;
    let shadow = orbit::has_shadow(Some(&raw.model));
    if shadow && (axis.is_none() || forces.force.radiation == 0.0) {
        let problem = "\"shadow\" needs radiation pressure, which it takes away, and semi_major_axis (or altitude) in [orbit], which it changes";
        return Err(raw.model.at_forces(file, problem));
    }
    let obliquity = match &raw.model.obliquity {
        Some(obliquity) => angle(file, obliquity, -FRAC_PI_2, FRAC_PI_2, "between -π/2 and π/2 (90 degrees)")?,
        None => OBLIQUITY_DEGREES.to_radians(),
    };
    let epoch = raw.epoch.get_ref().read(file)?;
    let sun_longitude = EpochInSpace::sun(&raw.epoch, file, epoch)?;
    let start = raw.initial.get_ref();
    let variables = start.variables(file, &raw.initial, sun_longitude)?;
    let has_cloud = is_needed || start.has_uncertainty();
    let averaged = Vectorial { forces, obliquity, sun_longitude };
    let model = match name {
        ModelName::Planar => return Err(file.error_in_whole("model.name", "is no model in space")),
        ModelName::Vectorial => {
            refuse_what_is_averaged(file, name, &raw)?;
            SpaceModel::Vectorial { model: averaged, axis }
        }
        ModelName::Osculating => unaveraged(file, &raw, (averaged, axis), epoch, has_cloud)?,
    };
    model.check().map_err(|error| raw.locate(file, &error))?;
    let times = times::read(file, &raw.times, epoch.as_ref())?;
    check_times(&times).map_err(|error| raw.locate(file, &error))?;
    let critical_e = raw.disposal.as_ref().map(|disposal| critical_e(file, disposal, axis)).transpose()?;
    let mut scenario = ScenarioInSpace {
        name: raw.name.get_ref().clone(),
        model,
        start: variables,
        times,
        critical_e,
        shadow,
        epoch,
        cloud: None,
    };
    if has_cloud {
        scenario.cloud = Some(Box::new(cloud(file, &raw, &scenario)?));
    }
    Ok(scenario)
}

/// The unaveraged model with the parameters of this averaged one; a single orbit must have a place in its revolution.
fn unaveraged(
    file: &InputFile,
    raw: &Raw,
    (averaged, axis): (Vectorial, Option<f64>),
    epoch: Option<Epoch>,
    has_cloud: bool,
) -> Result<SpaceModel, InputError> {
    let Vectorial { forces, obliquity, sun_longitude } = averaged;
    let moon_longitude = EpochInSpace::moon(&raw.epoch, file, epoch, forces.moon != 0.0)?;
    let Some(semi_major_axis) = axis else {
        let problem = "must have semi_major_axis (or altitude), with radiation or with area_to_mass and reflectivity: without an \
                       average, the satellite goes round the Earth";
        return Err(file.error(&raw.orbit, problem));
    };
    let mean_anomaly = raw.initial.get_ref().mean_anomaly.as_ref().map(|anomaly| turn(file, anomaly)).transpose()?;
    if mean_anomaly.is_none() && !has_cloud {
        let name = ModelName::Osculating.text();
        return Err(file.error(&raw.initial, &format!("must have mean_anomaly: the model \"{name}\" has no average")));
    }
    let model = Osculating { semi_major_axis, forces, obliquity, sun_longitude, moon_longitude };
    Ok(SpaceModel::Osculating { model, mean_anomaly })
}

/// The cloud about the orbit of a scenario.
fn cloud(file: &InputFile, raw: &Raw, scenario: &ScenarioInSpace) -> Result<SpaceProblem, InputError> {
    let Some(critical_e) = scenario.critical_e else {
        let problem = "must have critical_e or altitude, at which the satellites of a cloud re-enter";
        return Err(file.error_in_whole("disposal", problem));
    };
    let model = scenario.model;
    let start = raw.initial.get_ref();
    let initial = start.gaussian(file, &raw.initial, scenario.start)?;
    // With a constant semi-major axis the height says no more than the critical eccentricity.
    let may_vary = scenario.shadow || !model.is_averaged();
    let altitude = raw.disposal.as_ref().filter(|_| may_vary).map(|table| table.get_ref().reentry_altitude(file));
    let problem = SpaceProblem {
        model,
        initial,
        spread: start.spread(file)?,
        times: scenario.times.clone(),
        critical_e,
        shadow: scenario.shadow,
        reentry_altitude: altitude.transpose()?.flatten(),
    };
    problem.checked().map_err(|error| raw.locate(file, &error))
}

impl Raw {
    /// The line and key of what is wrong with the problem.
    fn locate(&self, file: &InputFile, error: &ProblemError) -> InputError {
        let problem = in_words(error);
        match error.field {
            Field::Parameter(name) => Orbit::locate(&self.orbit, file, name, &problem),
            Field::Times => Times::locate(&self.times, file, &problem),
            Field::Shadow => self.model.at_forces(file, &problem),
            field => match key(field).split_once('.') {
                Some(("initial", key)) => Start::locate(&self.initial, file, key, &problem),
                _ => file.error_in_whole(&key(field), &problem),
            },
        }
    }
}

/// The parameters of the forces that act; those of the others are 0.
pub(super) fn forces(
    file: &InputFile,
    model: Option<&Model>,
    orbit: &Spanned<Orbit>,
    axis: Option<f64>,
) -> Result<SunMoon, InputError> {
    let table = orbit.get_ref();
    let (Some(axis), Some(radiation), None) = (axis, table.value(RADIATION.name), table.value("area_to_mass")) else {
        let planar = orbit::read(file, model, orbit)?;
        return SpaceModel::forces_of(&planar).map_err(|Parameter { force, .. }| {
            file.error(orbit, &format!("the force \"{force}\" acts in no model in space"))
        });
    };
    let acting = orbit::forces(file, model)?;
    if !acting.contains(&RADIATION.force) {
        return Err(file.error(radiation, &orbit::no_such_force(&RADIATION)));
    }
    let others = SunMoon::PARAMETERS.iter().filter(|parameter| **parameter != RADIATION);
    if let Some(value) = others.filter_map(|parameter| table.value(parameter.name)).next() {
        return Err(file.error(value, "follows from the semi-major axis, leave it out"));
    }
    let radiation = measure::read(file, radiation, Dimension::Number)?;
    let mut forces = SunMoon::of_satellite(axis, 0.0, 0.0)
        .map_err(|error| Orbit::locate(orbit, file, "semi_major_axis", &in_words(&error)))?;
    forces.force.radiation = radiation;
    Ok(forces.only(|force| acting.contains(&force)))
}

/// Refuses what an averaged model has no use for.
fn refuse_what_is_averaged(file: &InputFile, name: ModelName, raw: &Raw) -> Result<(), InputError> {
    let name = name.text();
    let refuse = |value: &Option<Spanned<Measure>>, what: &str| match value {
        Some(value) => Err(file.error(value, &format!("has no effect: the model \"{name}\" is averaged over {what}"))),
        None => Ok(()),
    };
    refuse(&raw.initial.get_ref().mean_anomaly, "the satellite's revolution")?;
    refuse(&raw.epoch.get_ref().moon_longitude, "the Moon's revolution")
}

fn critical_e(file: &InputFile, table: &Spanned<Disposal>, axis: Option<f64>) -> Result<f64, InputError> {
    let critical = Disposal::read(file, table, axis)?;
    match critical > 0.0 && critical < 1.0 {
        true => Ok(critical),
        false => {
            let problem = format!("{} is not allowed, it must be between 0 and 1, both excluded", plain(critical));
            Err(Disposal::locate(table, file, &problem))
        }
    }
}

#[cfg(test)]
mod tests;

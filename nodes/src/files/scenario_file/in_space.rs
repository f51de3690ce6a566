//! Scenario files whose model is one in space.

use std::f64::consts::FRAC_PI_2;

use density::in_space::models::{OSCULATING, SpaceModel, VECTORIAL};
use density::in_space::{SpaceProblem, SpaceProblemError};
use density::model::ecliptic::OBLIQUITY_DEGREES;
use density::model::osculating::Osculating;
use density::model::parameter::Parameter;
use density::model::planar::Force;
use density::model::sun_moon::SunMoon;
use density::model::vectorial::Vectorial;
use density::problem::check_times;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;
use toml::Spanned;

use super::angle::{angle, turn};
use super::disposal::Disposal;
use super::epoch::{Epoch, EpochInSpace};
use super::measure::{self, Dimension, Measure};
use super::orbit::{self, Model, Orbit};
use super::start::Start;
use super::times::{self, Times};
use super::{check_name, in_words};
use crate::files::input::{InputError, InputFile};
use crate::files::plain_number::plain;

/// A scenario in space, as its file describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct ScenarioInSpace {
    /// Its name.
    pub name: String,
    /// The model, with the orbit at `t = 0` in the model's variables.
    pub model: ModelInSpace,
    /// The semi-major axis at `t = 0` \[Earth radii\], if the file gives it.
    pub semi_major_axis: Option<f64>,
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
        let mean = cloud.initial.mean;
        let model = match cloud.model {
            SpaceModel::Vectorial { model, .. } => ModelInSpace::Vectorial(model, mean),
            SpaceModel::Osculating { model, mean_anomaly } => ModelInSpace::Osculating(model, mean, mean_anomaly),
        };
        let (times, critical_e, shadow) = (cloud.times.clone(), Some(cloud.critical_e), cloud.shadow);
        let semi_major_axis = cloud.model.axis();
        Self { name, model, semi_major_axis, times, critical_e, shadow, epoch: None, cloud: Some(Box::new(cloud)) }
    }
}

/// A model in space, with the orbit at `t = 0` in its variables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ModelInSpace {
    /// Averaged.
    Vectorial(Vectorial, [f64; 4]),
    /// Unaveraged, with the mean anomaly at `t = 0` \[rad\] if the file gives it.
    Osculating(Osculating, [f64; 4], Option<f64>),
}

impl ModelInSpace {
    /// Its name in a scenario file.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Vectorial(..) => VECTORIAL,
            Self::Osculating(..) => OSCULATING,
        }
    }

    /// The parameters `C`, `W`, `A` and `B` with their values.
    pub fn parameters(&self) -> [(Parameter, f64); 4] {
        match self {
            Self::Vectorial(model, _) => model.parameters(),
            Self::Osculating(Osculating { forces, obliquity, sun_longitude, .. }, ..) => {
                Vectorial { forces: *forces, obliquity: *obliquity, sun_longitude: *sun_longitude }.parameters()
            }
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

/// Checks a scenario file whose model is one in space; it must describe a cloud if one `is_needed`.
///
/// # Errors
/// [`InputError`] with file, line and key.
pub(super) fn check(file: &InputFile, is_needed: bool) -> Result<ScenarioInSpace, InputError> {
    let raw: Raw = file.parse()?;
    check_name(file, &raw.name)?;
    let is_osculating = raw.model.name.as_ref().is_some_and(|name| name.get_ref() == OSCULATING);
    let axis = orbit::semi_major_axis(file, &raw.orbit)?;
    let forces = forces(file, Some(&raw.model), &raw.orbit, axis)?;
    let shadow = orbit::has_shadow(Some(&raw.model));
    if shadow && (axis.is_none() || forces.force.radiation == 0.0) {
        let problem = "\"shadow\" needs radiation pressure, which it takes away, and semi_major_axis (or altitude) in [orbit], which it changes";
        return Err(file.error_in_whole("model.forces", problem));
    }
    let obliquity = match &raw.model.obliquity {
        Some(obliquity) => angle(file, obliquity, -FRAC_PI_2, FRAC_PI_2, "between -90 and 90 degrees")?,
        None => OBLIQUITY_DEGREES.to_radians(),
    };
    let epoch = raw.epoch.get_ref().read(file)?;
    let sun_longitude = EpochInSpace::sun(&raw.epoch, file, epoch)?;
    let start = raw.initial.get_ref();
    let variables = start.variables(file, &raw.initial, sun_longitude)?;
    let has_cloud = is_needed || start.has_uncertainty();
    let model = if is_osculating {
        let moon_longitude = EpochInSpace::moon(&raw.epoch, file, epoch, forces.moon != 0.0)?;
        let Some(semi_major_axis) = axis else {
            let problem = "must have semi_major_axis (or altitude), with radiation or with area_to_mass and reflectivity: without an \
                           average, the satellite goes round the Earth";
            return Err(file.error(&raw.orbit, problem));
        };
        let mean_anomaly = start.mean_anomaly.as_ref().map(|anomaly| turn(file, anomaly)).transpose()?;
        if mean_anomaly.is_none() && !has_cloud {
            return Err(file.error(&raw.initial, "must have mean_anomaly: the model \"osculating\" has no average"));
        }
        let model = Osculating { semi_major_axis, forces, obliquity, sun_longitude, moon_longitude };
        ModelInSpace::Osculating(model, variables, mean_anomaly)
    } else {
        refuse_what_is_averaged(file, &raw)?;
        ModelInSpace::Vectorial(Vectorial { forces, obliquity, sun_longitude }, variables)
    };
    check_parameters(file, &raw.orbit, &model)?;
    let times = times::read(file, &raw.times, epoch.as_ref())?;
    check_times(&times).map_err(|error| Times::locate(&raw.times, file, &in_words(&error)))?;
    let critical_e = raw.disposal.as_ref().map(|disposal| critical_e(file, disposal, axis)).transpose()?;
    let mut scenario = ScenarioInSpace {
        name: raw.name.get_ref().clone(),
        model,
        semi_major_axis: axis,
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

/// The cloud about the orbit of a scenario.
fn cloud(file: &InputFile, raw: &Raw, scenario: &ScenarioInSpace) -> Result<SpaceProblem, InputError> {
    let Some(critical_e) = scenario.critical_e else {
        let problem = "must have critical_e or altitude, at which the satellites of a cloud re-enter";
        return Err(file.error_in_whole("disposal", problem));
    };
    let (model, mean) = match scenario.model {
        ModelInSpace::Vectorial(model, mean) => (SpaceModel::Vectorial { model, axis: scenario.semi_major_axis }, mean),
        ModelInSpace::Osculating(model, mean, mean_anomaly) => (SpaceModel::Osculating { model, mean_anomaly }, mean),
    };
    let start = raw.initial.get_ref();
    let initial = start.gaussian(file, &raw.initial, mean)?;
    // With a constant semi-major axis the height says no more than the critical eccentricity.
    let may_vary = scenario.shadow || matches!(model, SpaceModel::Osculating { .. });
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
    problem.checked().map_err(|SpaceProblemError { key, problem }| match key.split_once('.') {
        Some(("initial", key)) => Start::locate(&raw.initial, file, key, &problem),
        Some(("orbit", key)) => Orbit::locate(&raw.orbit, file, key, &problem),
        _ => file.error_in_whole(&key, &problem),
    })
}

/// The parameters of the forces that act; those of the others are 0.
pub(super) fn forces(
    file: &InputFile,
    model: Option<&Model>,
    orbit: &Spanned<Orbit>,
    axis: Option<f64>,
) -> Result<SunMoon, InputError> {
    let table = orbit.get_ref();
    let (Some(axis), Some(radiation), None) = (axis, table.value("radiation"), table.value("area_to_mass")) else {
        let planar = orbit::read(file, model, orbit)?;
        let value = |name: &str| planar.value(name).unwrap_or(0.0);
        let force = Force { radiation: value("radiation"), oblateness: value("oblateness") };
        return Ok(SunMoon { force, sun: value("sun"), moon: value("moon") });
    };
    let acting = orbit::forces(file, model)?;
    if !acting.contains(&density::model::planar::RADIATION.force) {
        return Err(file.error(radiation, &orbit::no_such_force(&density::model::planar::RADIATION)));
    }
    for key in ["oblateness", "sun", "moon"] {
        if let Some(value) = table.value(key) {
            return Err(file.error(value, "follows from the semi-major axis, leave it out"));
        }
    }
    let radiation = measure::read(file, radiation, Dimension::Number)?;
    let Force { oblateness, .. } = Force::from_orbit(axis, 0.0, 0.0)
        .map_err(|error| Orbit::locate(orbit, file, "semi_major_axis", &in_words(&error)))?;
    let SunMoon { force, sun, moon } = SunMoon::at(axis, Force { radiation, oblateness });
    let acts = |force: &str, value: f64| if acting.contains(&force) { value } else { 0.0 };
    let force = Force { oblateness: acts("j2", force.oblateness), ..force };
    Ok(SunMoon { force, sun: acts("sun", sun), moon: acts("moon", moon) })
}

/// Refuses what an averaged model has no use for.
fn refuse_what_is_averaged(file: &InputFile, raw: &Raw) -> Result<(), InputError> {
    let refuse = |value: &Option<Spanned<Measure>>, what: &str| match value {
        Some(value) => {
            Err(file.error(value, &format!("has no effect: the model \"{VECTORIAL}\" is averaged over {what}")))
        }
        None => Ok(()),
    };
    refuse(&raw.initial.get_ref().mean_anomaly, "the satellite's revolution")?;
    refuse(&raw.epoch.get_ref().moon_longitude, "the Moon's revolution")
}

fn check_parameters(file: &InputFile, table: &Spanned<Orbit>, model: &ModelInSpace) -> Result<(), InputError> {
    let wrong = model.parameters().into_iter().find(|(p, value)| !(p.low..=p.high).contains(value));
    wrong.map_or(Ok(()), |(Parameter { name, low, high, .. }, value)| {
        let problem = format!("{} is not allowed, it must be between {low} and {high}", plain(value));
        Err(Orbit::locate(table, file, name, &problem))
    })
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

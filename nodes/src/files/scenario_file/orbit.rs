//! The forces on the satellite, as a scenario file gives them, and the parameters of the model in which they act.

use density::in_space::acting::SHADOW;
use density::model::earth;
use density::model::model_name::ModelName;
use density::model::parameter::Parameter;
use density::model::registry::{self, DEFAULT_FORCES, ModelError, Planar};
use density::problem_error::Field;
use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

use super::measure::{self, Dimension, Measure};
use super::refusals::in_words;
use crate::files::input::{InputError, InputFile};
use crate::files::plain_number::plain;
use crate::files::toml_words::quoted;

/// The table `[model]`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Model {
    #[schemars(with = "Option<String>", extend("enum" = ModelName::ALL.map(ModelName::text)))]
    #[serde(rename = "name")]
    _name: Option<Spanned<String>>, // `model_name` reads it before all else
    #[schemars(with = "Option<Measure>")]
    pub(super) obliquity: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Vec<String>>", extend("items" = { "type": "string", "enum": known_forces() }))]
    forces: Option<Spanned<Vec<Spanned<String>>>>,
}

impl Model {
    /// An error about the forces, at their place.
    pub(super) fn at_forces(&self, file: &InputFile, problem: &str) -> InputError {
        self.forces
            .as_ref()
            .map_or_else(|| file.error_in_whole("model.forces", problem), |forces| file.error(forces, problem))
    }
}

/// The table `[orbit]`: either a parameter for every force, or the satellite from which all of them follow.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Orbit {
    #[schemars(with = "Option<Measure>")]
    radiation: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    oblateness: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    sun: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    moon: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    semi_major_axis: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    altitude: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    area_to_mass: Option<Spanned<Measure>>,
    #[schemars(with = "Option<Measure>")]
    reflectivity: Option<Spanned<Measure>>,
}

impl Orbit {
    /// All values that the table may have, by key.
    fn values(&self) -> [(&'static str, &Option<Spanned<Measure>>); 8] {
        [
            ("radiation", &self.radiation),
            ("oblateness", &self.oblateness),
            ("sun", &self.sun),
            ("moon", &self.moon),
            ("semi_major_axis", &self.semi_major_axis),
            ("altitude", &self.altitude),
            ("area_to_mass", &self.area_to_mass),
            ("reflectivity", &self.reflectivity),
        ]
    }

    pub(super) fn value(&self, key: &str) -> Option<&Spanned<Measure>> {
        self.values().into_iter().find(|(known, _)| *known == key).and_then(|(_, value)| value.as_ref())
    }

    /// An error at the parameter `name`; at the whole table if the parameter follows from others.
    pub(super) fn locate(table: &Spanned<Self>, file: &InputFile, name: &str, problem: &str) -> InputError {
        // A semi-major axis may have been given by the altitude.
        let value = table.get_ref().value(name);
        match value.or_else(|| table.get_ref().altitude.as_ref().filter(|_| name == "semi_major_axis")) {
            Some(value) => file.error(value, problem),
            None => file.error(table, &format!("gives {name}: {problem}")),
        }
    }
}

/// The model that a file asks for.
pub(super) fn read(file: &InputFile, model: Option<&Model>, orbit: &Spanned<Orbit>) -> Result<Planar, InputError> {
    let forces = forces(file, model)?;
    let name = registry::with_forces(&forces).ok_or_else(|| {
        let problem = format!("no model has the forces {} together", forces.join(", "));
        let forces = model.and_then(|model| model.forces.as_ref());
        forces.map_or_else(|| file.error(orbit, &problem), |forces| file.error(forces, &problem))
    })?;
    let axis = semi_major_axis(file, orbit)?;
    let [ratio, reflectivity] = ["area_to_mass", "reflectivity"].map(|key| orbit.get_ref().value(key));
    let whole = match (axis, ratio, reflectivity) {
        (None, None, None) => parameters(file, name, &forces, orbit)?,
        (Some(axis), Some(ratio), Some(reflectivity)) => {
            refuse_parameters(file, name, orbit)?;
            let number = |value| measure::read(file, value, Dimension::Number);
            match Planar::of_satellite(name, axis, number(ratio)?, number(reflectivity)?) {
                Some(Ok(model)) => model,
                Some(Err(error)) => return Err(locate(file, orbit, error.field, &in_words(&error))),
                None => return Err(file.error(orbit, &format!("there is no model \"{name}\""))),
            }
        }
        _ => return Err(file.error(orbit, &what_is_needed(name, &forces))),
    };
    // A satellite determines the parameters of all forces of the model; those of forces that do not act are set to 0.
    let values: Vec<_> = density::model::PlanarHamiltonian::parameters(&whole)
        .into_iter()
        .map(|(parameter, value)| (parameter.name, if forces.contains(&parameter.force) { value } else { 0.0 }))
        .collect();
    Planar::by_name(name, &values).map_err(|error| file.error(orbit, &error.to_string()))
}

/// Largest height of a circular orbit \[km\]: that of the largest semi-major axis, 100 Earth radii.
const HIGHEST: f64 = 99.0 * earth::RADIUS / 1_000.0;

/// The semi-major axis \[Earth radii\], if the file gives it: by itself, or by the height above the equator of a
/// circular orbit.
pub(super) fn semi_major_axis(file: &InputFile, orbit: &Spanned<Orbit>) -> Result<Option<f64>, InputError> {
    match orbit.get_ref() {
        Orbit { semi_major_axis: Some(axis), altitude: None, .. } => {
            measure::read(file, axis, Dimension::Radius).map(Some)
        }
        Orbit { semi_major_axis: None, altitude: Some(height), .. } => {
            let kilometres = measure::read(file, height, Dimension::Height)?;
            match kilometres > 0.0 && kilometres <= HIGHEST {
                true => Ok(Some(1.0 + kilometres * 1_000.0 / earth::RADIUS)),
                false => {
                    let problem = format!(
                        "{} km is not allowed, it must be above 0 and at most {} km",
                        plain(kilometres),
                        plain(HIGHEST)
                    );
                    Err(file.error(height, &problem))
                }
            }
        }
        Orbit { semi_major_axis: Some(_), altitude: Some(height), .. } => {
            Err(file.error(height, "stands beside semi_major_axis, which says the same; leave out one of them"))
        }
        _ => Ok(None),
    }
}

/// Whether the forces name the Earth's shadow.
pub(super) fn has_shadow(model: Option<&Model>) -> bool {
    let forces = model.and_then(|model| model.forces.as_ref());
    forces.is_some_and(|forces| forces.get_ref().iter().any(|force| force.get_ref() == SHADOW))
}

/// The names of all forces, and of the shadow.
fn known_forces() -> Vec<&'static str> {
    registry::forces().into_iter().chain([SHADOW]).collect()
}

/// The forces that act, without the shadow.
pub(super) fn forces<'a>(file: &InputFile, model: Option<&'a Model>) -> Result<Vec<&'a str>, InputError> {
    let Some(Model { forces: Some(forces), .. }) = model else { return Ok(DEFAULT_FORCES.to_vec()) };
    let known = known_forces();
    let mut acting: Vec<&str> = Vec::new();
    for force in forces.get_ref() {
        let name = force.get_ref().as_str();
        if !known.contains(&name) {
            return Err(
                file.error(force, &format!("\"{name}\" is no force, there are {}", quoted(known.iter().copied())))
            );
        }
        if acting.contains(&name) {
            return Err(file.error(force, &format!("\"{name}\" stands in the list for the second time, leave it out")));
        }
        acting.push(name);
    }
    acting.retain(|force| *force != SHADOW);
    match acting.is_empty() {
        true => {
            let what = if forces.get_ref().is_empty() { "no force" } else { "no force but the shadow of one" };
            Err(file.error(forces, &format!("names {what}, there are {}", quoted(known.iter().copied()))))
        }
        false => Ok(acting),
    }
}

/// The model with a parameter for every force that acts.
fn parameters(file: &InputFile, name: &str, forces: &[&str], orbit: &Spanned<Orbit>) -> Result<Planar, InputError> {
    let mut given = Vec::new();
    for parameter in all_parameters() {
        let (acts, value) = (forces.contains(&parameter.force), orbit.get_ref().value(parameter.name));
        match (acts, value) {
            (true, Some(value)) => given.push((parameter.name, measure::read(file, value, Dimension::Number)?)),
            (true, None) => return Err(file.error(orbit, &what_is_needed(name, forces))),
            (false, Some(value)) => return Err(file.error(value, &no_such_force(parameter))),
            (false, None) if registry::parameters(name).contains(parameter) => given.push((parameter.name, 0.0)),
            (false, None) => {}
        }
    }
    Planar::by_name(name, &given).map_err(|error: ModelError| file.error(orbit, &error.to_string()))
}

/// Refuses parameters beside a satellite, which determines all of them.
fn refuse_parameters(file: &InputFile, name: &str, orbit: &Spanned<Orbit>) -> Result<(), InputError> {
    let given = all_parameters().find_map(|parameter| Some((parameter, orbit.get_ref().value(parameter.name)?)));
    match given {
        Some((parameter, value)) => {
            let acts = registry::parameters(name).contains(parameter);
            let problem = match acts {
                true => "follows from the satellite, leave it out".into(),
                false => no_such_force(parameter),
            };
            Err(file.error(value, &problem))
        }
        None => Ok(()),
    }
}

/// The parameters of all models, each once.
fn all_parameters() -> impl Iterator<Item = &'static Parameter> {
    let of_all = || Planar::ALL.iter().flat_map(|(_, parameters)| *parameters);
    of_all()
        .enumerate()
        .filter(move |(k, parameter)| of_all().take(*k).all(|other| other != *parameter))
        .map(|(_, p)| p)
}

pub(super) fn no_such_force(Parameter { force, .. }: &Parameter) -> String {
    format!("has no effect: its force \"{force}\" is not in model.forces; add it there, or leave this out")
}

fn what_is_needed(name: &str, forces: &[&str]) -> String {
    let acting = registry::parameters(name).iter().filter(|parameter| forces.contains(&parameter.force));
    let names: Vec<&str> = acting.map(|parameter| parameter.name).collect();
    let names = match names.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} and {last}", others.join(", ")),
        _ => names.concat(),
    };
    format!("must have either {names}, or semi_major_axis (or altitude), area_to_mass and reflectivity")
}

fn locate(file: &InputFile, orbit: &Spanned<Orbit>, field: Field, problem: &str) -> InputError {
    match field {
        Field::Parameter(name) => Orbit::locate(orbit, file, name, problem),
        _ => file.error(orbit, problem),
    }
}

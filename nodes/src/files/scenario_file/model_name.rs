//! Which model a scenario file names.

use density::in_space::acting::SHADOW;
use density::model::model_name::ModelName;
use serde::Deserialize;
use toml::Spanned;

use crate::files::input::{InputError, InputFile};

/// As much of a file as names its model.
#[derive(Debug, Deserialize)]
struct File {
    model: Option<Table>,
}

#[derive(Debug, Deserialize)]
struct Table {
    name: Option<Spanned<String>>,
    forces: Option<Spanned<Vec<Spanned<String>>>>,
}

/// Where the forces name the Earth's shadow, if they do.
fn shadow(file: &InputFile) -> Result<Option<Spanned<String>>, InputError> {
    let forces = file.parse::<File>()?.model.and_then(|model| model.forces);
    Ok(forces.and_then(|forces| forces.into_inner().into_iter().find(|force| force.get_ref() == SHADOW)))
}

/// Whether the file describes an orbit in the plane that passes the Earth's shadow.
pub(super) fn is_shadowed_plane(file: &InputFile) -> Result<bool, InputError> {
    Ok(!read(file)?.is_in_space() && shadow(file)?.is_some())
}

/// A model that a file names.
struct NamedModel {
    name: ModelName,
    /// Where the file names it.
    place: Spanned<String>,
}

/// The model that the file names, if it names one.
fn named(file: &InputFile) -> Result<Option<NamedModel>, InputError> {
    let Some(place) = file.parse::<File>()?.model.and_then(|model| model.name) else { return Ok(None) };
    let Some(name) = ModelName::read(place.get_ref()) else {
        let known = ModelName::listed(|_| true);
        return Err(file.error(&place, &format!("\"{}\" is no model, there are {known}", place.get_ref())));
    };
    Ok(Some(NamedModel { name, place }))
}

/// The model that the file names; the planar one, if it names none.
pub(super) fn read(file: &InputFile) -> Result<ModelName, InputError> {
    Ok(named(file)?.map_or(ModelName::Planar, |named| named.name))
}

/// Refuses a model in space.
pub(super) fn expect_plane(file: &InputFile) -> Result<(), InputError> {
    match named(file)? {
        Some(NamedModel { name, place }) if name.is_in_space() => {
            let problem = format!(
                "\"{}\" is a model in space, which this command cannot do yet; it needs \"{}\" (`run`, `serve`, `submit`, `orbit` and \
                 `validate` take models in space)",
                name.text(),
                ModelName::Planar.text()
            );
            Err(file.error(&place, &problem))
        }
        _ => match shadow(file)? {
            Some(force) => {
                let problem = "\"shadow\" takes the Hamiltonian from the planar model, which this command needs; leave it out (`run`, `serve`, `submit`, \
                               `orbit`, `fidelity` and `validate` take it)";
                Err(file.error(&force, problem))
            }
            None => Ok(()),
        },
    }
}

//! Which model a scenario file names.

use density::in_space::acting::SHADOW;
use density::model::space_registry::{OSCULATING, PLANAR as IN_PLANE, VECTORIAL};
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
    Ok(!is_in_space(file)? && shadow(file)?.is_some())
}

/// The name that the file gives, if it gives one.
fn named(file: &InputFile) -> Result<Option<Spanned<String>>, InputError> {
    let named = file.parse::<File>()?.model.and_then(|model| model.name);
    match named.as_ref().map(|name| name.get_ref().as_str()) {
        None | Some(IN_PLANE | VECTORIAL | OSCULATING) => Ok(named),
        Some(other) => {
            let problem =
                format!("\"{other}\" is no model, there are \"{IN_PLANE}\", \"{VECTORIAL}\", \"{OSCULATING}\"");
            Err(named.as_ref().map_or_else(|| file.error_in_whole("model.name", &problem), |n| file.error(n, &problem)))
        }
    }
}

/// Whether the file names a model in space.
pub(super) fn is_in_space(file: &InputFile) -> Result<bool, InputError> {
    Ok(named(file)?.is_some_and(|name| name.get_ref() != IN_PLANE))
}

/// Refuses a model in space.
pub(super) fn expect_plane(file: &InputFile) -> Result<(), InputError> {
    match named(file)? {
        Some(name) if name.get_ref() != IN_PLANE => {
            let problem = format!(
                "\"{}\" is a model in space, which this command cannot do yet; it needs \"{IN_PLANE}\" (`run`, `serve`, `submit`, `orbit` and \
                 `validate` take models in space)",
                name.get_ref()
            );
            Err(file.error(&name, &problem))
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

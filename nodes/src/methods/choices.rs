//! What a sampling case may choose for itself: a simpler model than the scenario's, or some of its forces.

use std::borrow::Cow;

use density::in_space::acting::{self, SHADOW};
use density::model::model_name::ModelName;
use density::model::planar::RADIATION;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};

use crate::files::toml_words::quoted;
use crate::methods::Misfit;

/// The model in which a case moves its orbits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "&str")]
pub struct ModelChoice(ModelName);

impl From<ModelChoice> for ModelName {
    fn from(ModelChoice(simplification): ModelChoice) -> Self {
        simplification
    }
}

impl From<ModelChoice> for &str {
    fn from(ModelChoice(simplification): ModelChoice) -> Self {
        simplification.text()
    }
}

impl TryFrom<String> for ModelChoice {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let unknown = || format!("\"{name}\" is no model, there are {}", ModelName::listed(|_| true));
        ModelName::read(&name).map(Self).ok_or_else(unknown)
    }
}

impl JsonSchema for ModelChoice {
    fn schema_name() -> Cow<'static, str> {
        "ModelChoice".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let names = ModelName::ALL.map(ModelName::text);
        json_schema!({"description": "The model in which a case moves its orbits.", "type": "string", "enum": names})
    }
}

/// A force in space, or the Earth's shadow, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(into = "&str")]
pub struct ForceChoice(pub(super) &'static str);

impl<'de> Deserialize<'de> for ForceChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.try_into().map_err(D::Error::custom)
    }
}

impl From<ForceChoice> for &str {
    fn from(ForceChoice(name): ForceChoice) -> Self {
        name
    }
}

impl TryFrom<String> for ForceChoice {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let unknown = || format!("\"{name}\" is no force, there are {}", quoted(acting::all()));
        acting::all().into_iter().find(|known| *known == name).map(Self).ok_or_else(unknown)
    }
}

impl JsonSchema for ForceChoice {
    fn schema_name() -> Cow<'static, str> {
        "ForceChoice".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"description": "A force in space, or the Earth's shadow.", "type": "string", "enum": acting::all()})
    }
}

/// The forces of a case that has its own.
pub type Forces = Vec<ForceChoice>;

/// Checks the forces that a case names.
///
/// # Errors
/// What is wrong with the list.
pub(super) fn check_forces(forces: Option<&Forces>) -> Result<(), Misfit> {
    let Some(forces) = forces else { return Ok(()) };
    let twice = forces.iter().enumerate().find(|(k, force)| forces[..*k].contains(force));
    match twice {
        _ if forces.iter().all(|ForceChoice(name)| *name == SHADOW) => {
            let others = acting::all().into_iter().filter(|name| *name != SHADOW);
            let problem = format!(
                "names no force, there are {}, and \"{SHADOW}\" beside \"{}\"",
                quoted(others),
                RADIATION.force
            );
            Err(Misfit::new("forces", problem))
        }
        Some((_, ForceChoice(name))) => {
            let problem = format!("\"{name}\" stands in the list for the second time, leave it out");
            Err(Misfit::new("forces", problem))
        }
        None => Ok(()),
    }
}

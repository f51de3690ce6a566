//! The orbits that a sampling method draws, in the scenario's model or in a simpler one.

use std::borrow::Cow;
use std::ops::Range;

use density::flow::{Accuracy, Flow};
use density::in_space::SpaceProblem;
use density::in_space::acting::SHADOW;
use density::in_space::cloud::Cloud;
use density::in_space::draws::{Distributed, Start};
use density::in_space::sampled::Sampled;
use density::model::Model;
use density::model::model_name::ModelName;
use density::model::uncertain_radiation::{Scale, UncertainRadiation};
use density::orbits::Orbits;
use density::sampling::{Draws, SamplingPlan, draw_variables};
use density::uncertain::{UncertainProblem, UncertainTask};
use kit::assignment::{Assignment, Uncertain};
use kit::failure::Failure;
use kit::problem_key::by_key;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

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
        let names = || ModelName::ALL.map(|one| format!("\"{}\"", one.text())).join(", ");
        let unknown = || format!("\"{name}\" is no model, there are {}", names());
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

/// A force, or the Earth's shadow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Force {
    /// Solar radiation pressure.
    Srp,
    /// Earth's oblateness.
    J2,
    /// The Sun's gravity.
    Sun,
    /// The Moon's gravity.
    Moon,
    /// The Earth's shadow.
    Shadow,
}

impl Force {
    /// Its name.
    fn name(self) -> &'static str {
        match self {
            Self::Srp => "srp",
            Self::J2 => "j2",
            Self::Sun => "sun",
            Self::Moon => "moon",
            Self::Shadow => SHADOW,
        }
    }
}

/// The forces of a case that has its own.
pub type Forces = Vec<Force>;

/// Checks the forces that a case names.
///
/// # Errors
/// What is wrong with the list.
pub(super) fn check_forces(forces: Option<&Forces>) -> Result<(), Misfit> {
    let Some(forces) = forces else { return Ok(()) };
    let twice = forces.iter().enumerate().find(|(k, force)| forces[..*k].contains(force));
    match twice {
        _ if forces.iter().all(|force| *force == Force::Shadow) => Err(Misfit::new(
            "forces",
            "names no force, there are \"srp\", \"j2\", \"sun\", \"moon\", and \"shadow\" beside \"srp\"",
        )),
        Some((_, force)) => {
            let problem = format!("\"{}\" stands in the list for the second time, leave it out", force.name());
            Err(Misfit::new("forces", problem))
        }
        None => Ok(()),
    }
}

/// The problem with these of its forces alone.
fn with_only(problem: &SpaceProblem, forces: &Forces) -> Result<SpaceProblem, Failure> {
    let names: Vec<&str> = forces.iter().map(|force| force.name()).collect();
    let acting = problem.acting();
    if let Some(other) = names.iter().find(|name| !acting.contains(name)) {
        let acting = acting.join(", ");
        return Err(Failure::Refused(format!(
            "forces: \"{other}\" does not act in the scenario, in which there are {acting}"
        )));
    }
    if problem.spread.is_some() && !forces.contains(&Force::Srp) {
        let why = "forces: without \"srp\" the radiation parameter, a variable of the cloud, would have no effect; name it, or ask phasecloud fidelity";
        return Err(Failure::Refused(why.into()));
    }
    Ok(problem.with_only(&names))
}

/// Which orbits are drawn, and how they are moved.
#[derive(Debug, Clone)]
pub(super) struct Drawing {
    pub(super) plan: SamplingPlan,
    /// The model, if not the scenario's.
    pub(super) simplification: Option<ModelName>,
    /// The forces, if not all of the scenario's.
    pub(super) forces: Option<Forces>,
    pub(super) accuracy: Accuracy,
    /// The numbers of the orbits.
    pub(super) range: Range<usize>,
}

impl Drawing {
    /// The orbits.
    pub(super) fn cloud(self, assignment: &Assignment) -> Result<Box<dyn Cloud>, Failure> {
        let Self { plan, simplification, forces, accuracy, range } = self;
        if let Some(problem) = &assignment.in_space {
            let problem = forces.as_ref().map_or_else(|| Ok(problem.clone()), |forces| with_only(problem, forces))?;
            let sampled = Sampled { problem: &problem, simplification, plan, accuracy };
            return sampled.cloud(range).map_err(|why| Failure::Refused(by_key(&why)));
        }
        if forces.is_some() {
            let why = "forces: a case may have forces of its own where the scenario's model is \"vectorial\" or \"osculating\"; leave it out";
            return Err(Failure::Refused(why.into()));
        }
        if let Some(other) = simplification.filter(|model| *model != ModelName::Planar) {
            let (own, other) = (assignment.model_in_words(), other.text());
            return Err(Failure::Refused(format!(
                "model: the scenario's model is {own}; a case may have a simpler one, which \"{other}\" is not"
            )));
        }
        if let Some(Uncertain { problem, .. }) = &assignment.uncertain {
            return problem.perform(Uncertainly { problem, plan, accuracy, range });
        }
        let problem = &assignment.plane()?.problem;
        let (x1, x2) = plan.draw_range(&problem.initial, range);
        Ok(Box::new(Orbits::new(Flow { model: problem.model, accuracy }, x1, x2)))
    }
}

/// Draws orbits in the plane whose radiation parameter is uncertain.
struct Uncertainly<'a> {
    problem: &'a UncertainProblem,
    plan: SamplingPlan,
    accuracy: Accuracy,
    range: Range<usize>,
}

impl UncertainTask for Uncertainly<'_> {
    type Output = Result<Box<dyn Cloud>, Failure>;

    fn with<S: Scale>(self, model: UncertainRadiation<S>) -> Self::Output {
        let Self { problem, plan, accuracy, range } = self;
        let start = match plan.draws {
            Draws::Independent => {
                let variables = UncertainRadiation::<S>::VARIABLES;
                draw_variables(&problem.gaussian(), variables, plan.seed, range)
            }
            _ => {
                let distributed = Distributed::of_plane(problem).map_err(|why| Failure::Refused(by_key(&why)))?;
                let starts: Vec<Start> = range.map(distributed.draw(&plan)).collect();
                let column = |k: usize| starts.iter().map(|start| start.variables[k]).collect();
                [column(0), column(1), starts.iter().map(|start| start.radiation).collect()]
            }
        };
        Ok(Box::new(Orbits::from_variables(Flow { model, accuracy }, &start.each_ref().map(Vec::as_slice))))
    }
}

//! The orbits that a sampling method draws, in the scenario's model or in a simpler one.

use std::ops::Range;

use density::flow::{Accuracy, Flow};
use density::in_space::SpaceProblem;
use density::in_space::cloud::Cloud;
use density::in_space::draws::{Distributed, Start};
use density::in_space::sampled::Sampled;
use density::model::Model;
use density::model::model_name::ModelName;
use density::model::planar::RADIATION;
use density::model::uncertain_radiation::{Scale, UncertainRadiation};
use density::orbits::Orbits;
use density::sampling::{Draws, SamplingPlan, draw_variables};
use density::uncertain::{UncertainProblem, UncertainTask};
use kit::assignment::{Assignment, Uncertain};
use kit::failure::Failure;
use kit::problem_key::by_key;

use crate::methods::choices::{ForceChoice, Forces};

/// The problem with these of its forces alone.
fn with_only(problem: &SpaceProblem, forces: &Forces) -> Result<SpaceProblem, Failure> {
    let names: Vec<&str> = forces.iter().map(|ForceChoice(name)| *name).collect();
    let acting = problem.acting();
    if let Some(other) = names.iter().find(|name| !acting.contains(name)) {
        let acting = acting.join(", ");
        return Err(Failure::Refused(format!(
            "forces: \"{other}\" does not act in the scenario, in which there are {acting}"
        )));
    }
    if problem.spread.is_some() && !names.contains(&RADIATION.force) {
        return Err(Failure::Refused(format!(
            "forces: without \"{}\" the radiation parameter, a variable of the cloud, would have no effect; name it, or ask phasecloud \
             fidelity",
            RADIATION.force
        )));
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
            let in_space = ModelName::listed(ModelName::is_in_space);
            let why = "forces: a case may have forces of its own where the scenario's model is one in space";
            return Err(Failure::Refused(format!("{why} ({in_space}); leave it out")));
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

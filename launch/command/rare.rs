//! `phasecloud ask --rare`: events so rare that the exact curve is not the only thing to rely on, by methods that know
//! orbits alone.

use std::ops::RangeInclusive;
use std::process::ExitCode;

use density::exact::leaves::ExactLeaves;
use density::exact::{Estimated, Exact, ExactSettings};
use density::first_passage::exact::exact_curve;
use density::first_passage::over_leaves;
use density::flow::{Accuracy, Flow};
use density::gaussian::Gaussian;
use density::in_space::SpaceProblem;
use density::in_space::task::SpaceTask;
use density::model::registry::Planar;
use density::model::uncertain_radiation::{Scale, UncertainRadiation};
use density::model::unfolded::{InSpace, Unfolded};
use density::problem::Problem;
use density::rare::{Answer, Event, Question, Refused, importance, subset};
use density::uncertain::{UncertainProblem, UncertainTask};
use nodes::files::plain_number::plain;
use nodes::files::scenario_file::{AnyScenario, ScenarioInSpace};
use serde_json::{Value, json};

use crate::report::new_table;

/// Levels that subset simulation takes for about 1e-6: a level gets the orbits over this number.
const LEVELS: usize = 6;

/// Numbers of orbits that --rare takes: fewer say nothing of a rare event, more do not fit into memory.
const ORBITS: RangeInclusive<usize> = 1000..=10_000_000;
/// From so many orbits on an answer takes a while.
const LONG_WORK: usize = 200_000;

/// Reads the number of orbits.
///
/// # Errors
/// What is wrong with it.
pub(super) fn orbits(text: &str) -> Result<usize, String> {
    let (least, most) = (ORBITS.start(), ORBITS.end());
    match text.parse() {
        Ok(orbits) if ORBITS.contains(&orbits) => Ok(orbits),
        Err(_) if !text.starts_with(|c: char| c.is_ascii_digit()) => Err(
            "this is no number of orbits; for the usual number write --rare after the scenario file, or --rare=5000 before it".into(),
        ),
        _ => Err(format!("it must be a whole number from {least} to {most}")),
    }
}

/// What is found of one event.
struct Found {
    event: Event,
    by_importance: Result<Answer, Refused>,
    by_subsets: Result<Answer, Refused>,
    /// The exact probability, where there is one.
    exact: Option<Estimated>,
}

/// Answers with so many orbits for each event and method.
pub fn run(scenario: &AnyScenario, orbits: usize, seed: u64, in_json: bool) -> ExitCode {
    let (Some(&years), Some(critical)) = (scenario.times().last(), scenario.critical_e()) else {
        remark!("error: the scenario has no end, or no critical eccentricity");
        return ExitCode::FAILURE;
    };
    if orbits >= LONG_WORK {
        super::long_work::announce();
    }
    let found: Result<Vec<Found>, String> =
        [Event::Ever, Event::AtEnd].into_iter().map(|event| find(scenario, event, orbits, seed)).collect();
    let found = match found {
        Ok(found) => found,
        Err(why) => {
            remark!("error: {why}");
            return ExitCode::FAILURE;
        }
    };
    let is_answered = |found: &Found| found.by_importance.is_ok() || found.by_subsets.is_ok() || found.exact.is_some();
    let is_answered = found.iter().any(is_answered);
    let asked = Asked { years, critical };
    if in_json {
        let found: Vec<Value> = found.iter().map(|found| found.json(asked)).collect();
        say!("{}", json!({"scenario": scenario.name(), "rare": found}));
    } else {
        print(scenario, asked, &found);
    }
    if is_answered { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Until when \[yr\], and at which eccentricity.
#[derive(Clone, Copy)]
struct Asked {
    years: f64,
    critical: f64,
}

fn find(scenario: &AnyScenario, event: Event, orbits: usize, seed: u64) -> Result<Found, String> {
    let scenario = match scenario {
        AnyScenario::InPlane { scenario, .. } => scenario,
        AnyScenario::InSpace(ScenarioInSpace { cloud, .. }) => {
            let problem = cloud.as_ref().ok_or("there is no cloud")?;
            let found = problem.perform(InMoreVariables { problem: &**problem, event, orbits, seed });
            return found.map_err(|error| error.to_string());
        }
    };
    let problem = &scenario.problem;
    let years = end(problem);
    Ok(match scenario.uncertain() {
        Some(problem) => problem.perform(InMoreVariables { problem: &problem, event, orbits, seed }),
        None => {
            let (flow, gaussian) = (Flow::new(problem.model), problem.initial.into());
            let question = Question { flow, gaussian, years, critical: problem.critical_e, event };
            let exact = exact(problem, event);
            by_orbits(&question, exact, (orbits, seed))
        }
    })
}

/// The question about a cloud in more than two variables.
struct InMoreVariables<'a, P> {
    problem: &'a P,
    event: Event,
    orbits: usize,
    seed: u64,
}

impl UncertainTask for InMoreVariables<'_, UncertainProblem> {
    type Output = Found;

    fn with<S: Scale>(self, model: UncertainRadiation<S>) -> Found {
        let Self { problem, event, orbits, seed } = self;
        let (years, critical) = (end(&problem.plane), problem.plane.critical_e);
        let question = Question { flow: Flow::new(model), gaussian: problem.gaussian(), years, critical, event };
        by_orbits(&question, exact_over_radiation(problem, event), (orbits, seed))
    }
}

impl SpaceTask for InMoreVariables<'_, SpaceProblem> {
    type Output = Found;

    fn with<M: InSpace<N>, const N: usize>(self, model: Unfolded<M, N>, gaussian: Gaussian<N>) -> Found {
        let Self { problem, event, orbits, seed } = self;
        let (years, critical) = (problem.times.last().copied().unwrap_or(0.0), problem.critical_e);
        let question = Question { flow: Flow::new(model), gaussian, years, critical, event };
        by_orbits(&question, None, (orbits, seed))
    }
}

fn by_orbits<M: density::Model, const N: usize>(
    question: &Question<M, N>,
    exact: Option<Estimated>,
    (orbits, seed): (usize, u64),
) -> Found {
    let by_importance = importance(question, orbits, seed);
    Found { event: question.event, by_importance, by_subsets: subset(question, orbits / LEVELS, seed), exact }
}

/// The exact probability, if the model has one.
fn exact(problem: &Problem<Planar>, event: Event) -> Option<Estimated> {
    let (flow, years) = (Flow::new(problem.model), end(problem));
    match event {
        Event::Ever => exact_curve(problem, &flow, &[0.0, years]).ok().map(|curve| curve[1]),
        Event::AtEnd => {
            let exact = Exact::new(problem, &flow, ExactSettings::default());
            exact.probability_above(problem.critical_e, years).ok()
        }
    }
}

/// The same where the radiation parameter is uncertain, if its error is small beside it.
fn exact_over_radiation(problem: &UncertainProblem, event: Event) -> Option<Estimated> {
    const LARGEST_ERROR: f64 = 0.05;
    let exact = ExactLeaves::new(problem.clone(), Accuracy::Medium, ExactSettings::default());
    let years = end(&problem.plane);
    let found = match event {
        Event::Ever => over_leaves::curve(&exact, &[0.0, years]).ok().map(|curve| curve[1].probability),
        Event::AtEnd => exact.moments(years).ok().map(|(_, above, _)| above),
    };
    found.filter(|found| found.error <= LARGEST_ERROR * found.value)
}

fn end(problem: &Problem<Planar>) -> f64 {
    problem.times.last().copied().unwrap_or(0.0)
}

fn words(event: Event, Asked { years, critical }: Asked) -> String {
    let (critical, years) = (plain(critical), plain(years));
    match event {
        Event::Ever => format!("e reaches {critical} by {years} yr"),
        Event::AtEnd => format!("e is above {critical} at {years} yr"),
    }
}

fn print(scenario: &AnyScenario, asked: Asked, found: &[Found]) {
    say!("{}\n", scenario.name());
    let head = ["event", "method", "probability", "standard error", "95 % interval", "orbits"];
    let mut table = new_table(head.map(str::to_owned).into(), 2);
    let mut refusals = Vec::new();
    for Found { event, by_importance, by_subsets, exact } in found {
        let event = words(*event, asked);
        for (method, answer) in [("importance sampling", by_importance), ("subset simulation", by_subsets)] {
            match answer {
                Ok(Answer { probability, standard_error, interval: (low, high), orbits }) => table.add_row([
                    event.clone(),
                    method.into(),
                    format!("{probability:.3e}"),
                    format!("{standard_error:.1e}"),
                    format!("{low:.3e} to {high:.3e}"),
                    orbits.to_string(),
                ]),
                Err(refused) => {
                    refusals.push(format!("{event}, {method}: {refused}"));
                    let row = [event.as_str(), method, "no answer", "", "", ""];
                    table.add_row(row.map(str::to_owned))
                }
            };
        }
        if let Some(Estimated { value, error }) = exact {
            let row = [event.as_str(), "exact", &format!("{value:.3e}"), &format!("{error:.0e} (estimate)"), "", ""];
            table.add_row(row.map(str::to_owned));
        }
    }
    say!("{table}\n");
    refusals.iter().for_each(|refusal| say!("{refusal}"));
    let place = if scenario.in_plane().is_some() { "in the plane" } else { "in space" };
    say!("The model is the scenario's: {place}, averaged over each revolution, without Earth's shadow.");
}

impl Found {
    fn json(&self, Asked { years, critical }: Asked) -> Value {
        let Self { event, by_importance, by_subsets, exact } = self;
        let answer = |answer: &Result<Answer, Refused>| match answer {
            Ok(Answer { probability, standard_error, interval, orbits }) => json!({
                "probability": probability, "standard_error": standard_error, "low": interval.0, "high": interval.1, "orbits": orbits
            }),
            Err(refused) => json!({"refused": refused.to_string()}),
        };
        json!({
            "event": match event { Event::Ever => "ever", Event::AtEnd => "at-end" },
            "critical_e": critical,
            "t_yr": years,
            "importance_sampling": answer(by_importance),
            "subset_simulation": answer(by_subsets),
            "exact": exact.map(|p| json!({"probability": p.value, "error_estimate": p.error})),
        })
    }
}

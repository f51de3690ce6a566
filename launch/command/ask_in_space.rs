//! `phasecloud ask` of a scenario in space: there is no exact curve, and every figure has an interval.

use density::in_space::SpaceProblem;
use density::in_space::disposal::{
    Bounded, Curve, Effort, FACTORS, REPLICATES, Sensitivity, Trouble, curve, factor_for, sensitivities,
};
use kit::problem_key::by_key;
use nodes::files::plain_number::plain;
use nodes::files::scenario_file::ScenarioInSpace;
use serde_json::{Value, json};

use super::asked::{PROBABILITIES, years};
use super::derived;
use crate::report::new_table;

/// Orbits of each replicate for the curve, and for a figure of which there are many.
const ORBITS: usize = 1024;
const ORBITS_OF_MANY: usize = 256;
/// Times between which the curve is read, besides those that are printed.
const STEPS: u32 = 400;

/// What is answered.
struct Answer<'a> {
    scenario: &'a ScenarioInSpace,
    /// Probability of re-entry by each printed time.
    curve: Vec<(f64, Bounded)>,
    /// The time by which each of [`PROBABILITIES`] is reached.
    times: Vec<Option<Bounded>>,
    /// The factor on the radiation parameter with which each of them is reached by the end.
    factors: Vec<Option<Bounded>>,
    sensitivities: Vec<Sensitivity>,
}

/// Answers, as one JSON object if so asked.
///
/// # Errors
/// Why there is no answer.
pub fn run(scenario: &ScenarioInSpace, seed: u64, in_json: bool) -> Result<(), String> {
    let Some(problem) = &scenario.cloud else { return Ok(()) };
    problem.check_task().map_err(|error| by_key(&error))?;
    super::long_work::announce();
    let answer = answer(scenario, problem, seed).map_err(|trouble| trouble.to_string())?;
    if in_json {
        say!("{}", answer.json())
    } else {
        answer.print()
    }
    Ok(())
}

fn answer<'a>(scenario: &'a ScenarioInSpace, problem: &SpaceProblem, seed: u64) -> Result<Answer<'a>, Trouble> {
    let end = problem.times.last().copied().unwrap_or(0.0);
    let printed = years(end);
    let between = (0..=STEPS).map(|k| end * f64::from(k) / f64::from(STEPS));
    let mut times: Vec<f64> = printed.iter().copied().chain(between).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let found: Curve = curve(problem, Effort { orbits: ORBITS, seed }, &times)?;
    let effort = Effort { orbits: ORBITS_OF_MANY, seed };
    let points = found.times.iter().copied().zip(found.probability.iter().copied());
    Ok(Answer {
        scenario,
        curve: points.filter(|(time, _)| printed.contains(time)).collect(),
        times: PROBABILITIES.iter().map(|&p| found.time_of(p)).collect(),
        factors: PROBABILITIES.iter().map(|&p| factor_for(problem, effort, p)).collect::<Result<_, _>>()?,
        sensitivities: sensitivities(problem, effort)?,
    })
}

/// Whether a factor is the least that was looked at, so that even less may do.
fn is_lowest(factor: &Bounded) -> bool {
    factor.value <= FACTORS.0
}

fn in_words(figure: &Bounded, digits: usize) -> String {
    let Bounded { value, low, high } = figure;
    match high.is_finite() {
        true => format!("{value:.digits$} ({low:.digits$} to {high:.digits$})"),
        false => format!("{value:.digits$} ({low:.digits$} or more)"),
    }
}

impl Answer<'_> {
    fn print(&self) {
        let Self { scenario, curve, times, factors, sensitivities } = self;
        say!("{}: {}", scenario.name, derived::lines_in_space(scenario).join("\n  "));
        let by = |time: f64, years: String| match scenario.epoch {
            Some(epoch) => format!("{years}, {}", epoch.date_after(time)),
            None => years,
        };
        let head = ["by, yr", "probability of re-entry"];
        let mut table = new_table(head.map(str::to_owned).into(), 0);
        curve.iter().for_each(|(time, p)| {
            table.add_row([by(*time, plain(*time)), in_words(p, 4)]);
        });
        say!("\n{table}");
        let head = ["probability", "reached by, yr", "needs C (or A/m) times"];
        let mut table = new_table(head.map(str::to_owned).into(), 0);
        for ((p, time), factor) in PROBABILITIES.iter().zip(times).zip(factors) {
            let time = time.map_or("not by the last snapshot".into(), |time| by(time.value, in_words(&time, 3)));
            let factor = match factor {
                None => format!("not within {} to {}", FACTORS.0, FACTORS.1),
                Some(factor) if is_lowest(factor) => format!("at most {}", FACTORS.0),
                Some(factor) => in_words(factor, 3),
            };
            table.add_row([format!("{} %", 100.0 * p), time, factor]);
        }
        say!("\n{table}");
        let end = curve.last().map_or(0.0, |(time, _)| *time);
        let head = ["change".to_owned(), format!("effect on the probability by {} yr", plain(end))];
        let mut table = new_table(head.into(), 1);
        for Sensitivity { change, effect: Bounded { value, low, high } } in sensitivities {
            table.add_row([change.clone(), format!("{value:+.4} ({low:+.4} to {high:+.4})")]);
        }
        say!("\n{table}\n");
        say!(
            "By {} orbits (factors and effects: {}) in the scenario's model, in {REPLICATES} replicates of a scrambled Sobol sequence. In \
             brackets: 95 % intervals.",
            ORBITS * REPLICATES,
            ORBITS_OF_MANY * REPLICATES
        );
    }

    fn json(&self) -> Value {
        let Self { scenario, curve, times, factors, sensitivities } = self;
        let finite = |value: f64| value.is_finite().then_some(value);
        let date = |time: f64| scenario.epoch.map(|epoch| epoch.date_after(time));
        let point = |(time, p): &(f64, Bounded)| json!({"t_yr": time, "date": date(*time), "probability": p.value, "low": p.low, "high": p.high});
        let bounded =
            |found: &Option<Bounded>| found.map(|Bounded { low, high, .. }| json!({"low": low, "high": finite(high)}));
        let reached = |((p, time), factor): ((&f64, &Option<Bounded>), &Option<Bounded>)| {
            json!({
                "probability": p,
                "t_yr": time.map(|time| time.value),
                "t_yr_interval": bounded(time),
                "date": time.and_then(|time| date(time.value)),
                "radiation_factor": factor.map(|factor| factor.value),
                "radiation_factor_interval": bounded(factor),
                "radiation_factor_is_upper_bound": factor.as_ref().is_some_and(is_lowest),
            })
        };
        let effect = |Sensitivity { change, effect }: &Sensitivity| json!({"change": change, "effect": effect.value, "low": effect.low, "high": effect.high});
        let parameters: serde_json::Map<String, Value> =
            scenario.model.force_parameters().iter().map(|(p, value)| (p.name.to_owned(), json!(value))).collect();
        json!({
            "scenario": scenario.name,
            "method": "qmc",
            "derived": {"model": scenario.model.name(), "parameters": parameters, "critical_e": scenario.critical_e},
            "curve": curve.iter().map(point).collect::<Vec<_>>(),
            "reached": PROBABILITIES.iter().zip(times).zip(factors).map(reached).collect::<Vec<_>>(),
            "sensitivities": sensitivities.iter().map(effect).collect::<Vec<_>>(),
        })
    }
}

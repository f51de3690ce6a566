//! `phasecloud ask`: the answer that a disposal designer wants of a scenario, in seconds and without a launch file.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use density::disposal::over_radiation::{self, EndProbability};
use density::disposal::{self, Sensitivity};
use density::exact::{Error, Estimated};
use density::first_passage::given::Given;
use density::first_passage::over_leaves::Passed;
use density::uncertain::{Spread, UncertainProblem};
use nodes::files::plain_number::plain;
use nodes::files::scenario_file::{self, AnyScenario, Epoch, ScenarioFile};
use serde_json::json;

use super::asked::{PROBABILITIES, years};
use super::derived::{self, Derived};
use crate::exit::BAD_INPUT;
use crate::report::new_table;

/// Arguments of `phasecloud ask`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  phasecloud ask my-scenario.toml\n\n\
    In the plane the probabilities are those of the exact first-passage curve (docs/methods.md), each with an estimate of its error; a figure \
    whose error estimate is above 1e-3 is withheld. In space they are counted from quasi-random orbits, each with a 95 % interval. With --rare \
    two methods that know orbits alone estimate probabilities down to 1e-9, each with a 95 % interval; the exact ones stand beside them where \
    there are any. The model is the scenario's: averaged, without Earth's shadow.\n\n\
    Exit codes: 0 answered; 1 it cannot be computed; 2 bad input.")]
pub struct AskArguments {
    /// The scenario file
    pub scenario: PathBuf,
    /// Print one JSON object instead of tables
    #[arg(long)]
    pub json: bool,
    /// Estimate rare events instead, from this many orbits for each event and method (5000 unless given): that e ever
    /// reaches its critical value, and that it is above it at the end
    #[arg(long, value_name = "ORBITS", num_args = 0..=1, default_missing_value = "5000", value_parser = super::rare::orbits)]
    pub rare: Option<usize>,
    /// Seed of the orbits of --rare, and of those in space; 1 unless given
    #[arg(long)]
    pub seed: Option<u64>,
}

/// Error estimate of a probability above which it is withheld.
const LARGEST_ERROR: f64 = 1e-3;

/// What is answered.
struct Answer {
    name: String,
    derived: Derived,
    /// Probability of re-entry by each time \[yr\].
    curve: Vec<(f64, Estimated)>,
    /// The time by which each of [`PROBABILITIES`] is reached.
    times: Vec<Option<f64>>,
    /// The factor on the radiation parameter with which each of them is reached by the end.
    factors: Vec<Option<f64>>,
    sensitivities: Vec<Sensitivity>,
    /// What is known at the end, if the radiation parameter is uncertain.
    at_end: Option<Passed>,
    /// How uncertain that parameter is.
    spread: Option<Spread>,
    /// The date at the start, if the scenario says it.
    epoch: Option<Epoch>,
}

/// Answers.
pub fn run(arguments: &AskArguments) -> ExitCode {
    let AskArguments { scenario: path, json, rare, seed } = arguments;
    let scenario = match scenario_file::load_cloud(path) {
        Ok(scenario) => scenario,
        Err(error) => {
            remark!("error: {error}");
            return ExitCode::from(BAD_INPUT);
        }
    };
    if seed.is_some() && rare.is_none() && scenario.in_plane().is_some() {
        remark!("error: --seed has no effect without --rare on a scenario in the plane, whose answer is exact");
        return ExitCode::from(BAD_INPUT);
    }
    let seed = seed.unwrap_or(1);
    if let Some(orbits) = rare {
        return super::rare::run(&scenario, *orbits, seed, *json);
    }
    let done = match scenario {
        AnyScenario::InPlane { scenario, .. } => in_plane(scenario, *json).map_err(|error| error.to_string()),
        AnyScenario::InSpace(scenario) => super::ask_in_space::run(&scenario, seed, *json),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            remark!("error: {}: {error}", path.display());
            ExitCode::FAILURE
        }
    }
}

fn in_plane(scenario: ScenarioFile, in_json: bool) -> Result<(), Error> {
    super::long_work::announce();
    let answer = answer(scenario)?;
    if in_json {
        say!("{}", self::in_json(&answer))
    } else {
        print(&answer)
    }
    Ok(())
}

fn answer(scenario: ScenarioFile) -> Result<Answer, Error> {
    match scenario.uncertain() {
        Some(problem) => with_uncertainty(scenario.name, &problem, scenario.epoch),
        None => without_uncertainty(scenario),
    }
}

/// All times at which the curve is computed: those that are printed, and close ones from which the time of a
/// probability follows.
fn all_times(printed: &[f64], end: f64) -> Vec<f64> {
    let mut times: Vec<f64> = printed.iter().copied().chain(disposal::dense_times(end)).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}

/// The printed points of a curve, and the time by which each of [`PROBABILITIES`] is reached.
fn read(times: &[f64], found: &[Estimated], printed: &[f64]) -> (Vec<(f64, Estimated)>, Vec<Option<f64>>) {
    let points = times.iter().copied().zip(found.iter().copied());
    let curve: Vec<(f64, f64)> = points.clone().map(|(time, p)| (time, p.value)).collect();
    let reached = PROBABILITIES.iter().map(|&p| disposal::time_of(&curve, p)).collect();
    (points.filter(|(time, _)| printed.contains(time)).collect(), reached)
}

fn without_uncertainty(ScenarioFile { name, problem, epoch, .. }: ScenarioFile) -> Result<Answer, Error> {
    let end = problem.times.last().copied().unwrap_or(0.0);
    let printed = years(end);
    let times = all_times(&printed, end);
    let (curve, reached) = read(&times, &disposal::probabilities(&problem, &times)?, &printed);
    let now = problem.model.value("radiation");
    let factor = |p: &f64| {
        let radiation = disposal::radiation_for(&problem, *p)?;
        Ok::<_, Error>(radiation.zip(now).map(|(radiation, now)| radiation / now))
    };
    let factors = PROBABILITIES.iter().map(factor).collect::<Result<_, _>>()?;
    let sensitivities = disposal::sensitivities(&problem)?;
    Ok(Answer {
        name,
        derived: derived::of(&problem),
        curve,
        times: reached,
        factors,
        sensitivities,
        at_end: None,
        spread: None,
        epoch,
    })
}

fn with_uncertainty(name: String, problem: &UncertainProblem, epoch: Option<Epoch>) -> Result<Answer, Error> {
    let plane = &problem.plane;
    let end = plane.times.last().copied().unwrap_or(0.0);
    let printed = years(end);
    let times = all_times(&printed, end);
    let passed = over_radiation::passed(problem, &times)?;
    let found: Vec<Estimated> = passed.iter().map(|passed| passed.probability).collect();
    let (curve, reached) = read(&times, &found, &printed);
    let table = EndProbability::new(problem)?;
    let factor = |p: &f64| table.radiation_for(problem, *p).map(|radiation| radiation / problem.mean());
    let factors = PROBABILITIES.iter().map(factor).collect();
    let sensitivities = over_radiation::sensitivities(problem, &table)?;
    let (at_end, spread) = (passed.last().copied(), Some(problem.spread));
    Ok(Answer {
        name,
        derived: derived::of(plane),
        curve,
        times: reached,
        factors,
        sensitivities,
        at_end,
        spread,
        epoch,
    })
}

fn is_stated(p: &Estimated) -> bool {
    p.error <= LARGEST_ERROR
}

/// Whether a factor is the least that was looked at, so that even less may do.
fn is_lowest(factor: f64) -> bool {
    factor < 0.1 * (1.0 + 1e-9)
}

fn in_words(p: &Estimated) -> String {
    match p {
        _ if !is_stated(p) => "withheld".into(),
        // Four decimals would show none of its digits.
        Estimated { value, error } if *value < 1e-3 && value > error => format!("{value:.3e} ± {error:.0e}"),
        Estimated { value, error } => format!("{value:.4} ± {error:.0e}"),
    }
}

fn print(answer: &Answer) {
    let Answer { name, derived, curve, times, factors, sensitivities, at_end, spread, epoch } = answer;
    let mut lines = derived.lines();
    lines.extend(spread.map(derived::in_words));
    say!("{name}: {}", lines.join("\n  "));
    let by = |time: f64, years: String| match epoch {
        Some(epoch) => format!("{years} ({})", epoch.date_after(time)),
        None => years,
    };
    let mut table = new_table(["by, yr", "probability of re-entry"].map(str::to_owned).into(), 0);
    curve.iter().for_each(|(time, p)| {
        table.add_row([by(*time, plain(*time)), in_words(p)]);
    });
    say!("\n{table}");
    let mut table = new_table(["probability", "reached by, yr", "needs C (or A/m) times"].map(str::to_owned).into(), 0);
    for ((p, time), factor) in PROBABILITIES.iter().zip(times).zip(factors) {
        let time = time.map_or("not by the last snapshot".into(), |time| by(time, format!("{time:.3}")));
        let factor = match factor {
            None => "not within 0.1 to 10".into(),
            Some(factor) if is_lowest(*factor) => "at most 0.1".into(),
            Some(factor) => format!("{factor:.4}"),
        };
        table.add_row([format!("{} %", 100.0 * p), time, factor]);
    }
    say!("\n{table}");
    let end = curve.last().map_or(0.0, |(time, _)| *time);
    let mut table =
        new_table(["change".to_owned(), format!("effect on the probability by {} yr", plain(end))].into(), 1);
    sensitivities.iter().for_each(|Sensitivity { change, effect }| {
        // Zero has no sign.
        let effect = if effect.abs() < 5e-6 { "0.00000".into() } else { format!("{effect:+.5}") };
        table.add_row([change.clone(), effect]);
    });
    if let Some(passed) = at_end {
        say!("\n{}", radiation_in_words(passed));
    }
    say!("\n{table}\n");
    say!(
        "By the exact first-passage curve of the scenario's model: in the plane, averaged over each revolution, without Earth's shadow."
    );
}

/// What re-entry or its absence says of the radiation parameter.
fn radiation_in_words(passed: &Passed) -> String {
    let told = |of: Estimated| format!("{:.5} ± {:.0e}", of.value, of.error);
    let given = |Given { mean, deviation }: Given| match mean.value.is_nan() {
        true => "unknown, since that is as good as impossible".into(),
        false => format!("{} on average, with a deviation of {}", told(mean), told(deviation)),
    };
    format!(
        "the radiation parameter C given re-entry by then: {}\ngiven none: {}",
        given(passed.radiation_if_passed),
        given(passed.radiation_if_not)
    )
}

fn in_json(answer: &Answer) -> serde_json::Value {
    let Answer { name, derived, curve, times, factors, sensitivities, at_end, epoch, .. } = answer;
    let date = |time: f64| epoch.map(|epoch| epoch.date_after(time));
    let point = |(time, p): &(f64, Estimated)| {
        let probability = is_stated(p).then_some(p.value);
        json!({"t_yr": time, "date": date(*time), "probability": probability, "error_estimate": p.error.is_finite().then_some(p.error)})
    };
    let given = |Given { mean, deviation }: Given| {
        let is_known = !mean.value.is_nan();
        is_known.then(|| {
            json!({"mean": mean.value, "deviation": deviation.value, "mean_error_estimate": mean.error, "deviation_error_estimate": deviation.error})
        })
    };
    let wanted = PROBABILITIES.iter().zip(times).zip(factors);
    json!({
        "scenario": name,
        "method": "exact",
        "derived": derived.json(),
        "curve": curve.iter().map(point).collect::<Vec<_>>(),
        "reached": wanted.map(|((p, time), factor)| json!({"probability": p, "t_yr": time, "date": time.and_then(date), "radiation_factor": factor, "radiation_factor_is_upper_bound": factor.is_some_and(is_lowest)})).collect::<Vec<_>>(),
        "radiation_at_end": at_end.as_ref().map(|passed| json!({"if_re_entered": given(passed.radiation_if_passed), "if_not": given(passed.radiation_if_not)})),
        "sensitivities": sensitivities.iter().map(|s| json!({"change": s.change, "effect": s.effect})).collect::<Vec<_>>(),
    })
}

//! `phasecloud check`: does a propagator keep the contract, and are its numbers right?
//!
//! The propagator is started in a domain of its own, and this program plays the scenario node and the estimator.
//!
//! | file | idea |
//! |---|---|
//! | [`scenarios`] | the small problems it is given |
//! | [`trial`] | one process in one domain: started, asked, listened to, stopped |
//! | [`answer`] | what it sent and did |
//! | [`table`] | a snapshot that has been decoded |
//! | [`delivery`] | rules about what was sent: counts, order, times, numbers |
//! | [`passages`] | whether a first-passage curve is right |
//! | [`physics`] | rules about what the numbers mean: Hamiltonian, density, mass, moments |
//! | [`in_space`] | the right answers in space |
//! | [`moments`] | moments beside the right ones |
//! | [`conduct`] | rules about how the process behaves: ready, two scenarios, refusal, the end |
//! | [`amount`] | how the report writes the size of an error |
//! | [`verdict`] | the rules and what was found, as a table or as JSON |

mod amount;
mod answer;
mod conduct;
mod delivery;
mod in_space;
mod moments;
mod passages;
mod physics;
mod scenarios;
mod table;
mod trial;
mod verdict;

use std::process::ExitCode;
use std::time::Duration;

use messages::wait::Signals;
use nodes::methods::BuiltIn;

use crate::command::node;
use crate::crew::commands::own_path;
use crate::domain;
use crate::exit::{BAD_INPUT, INTERRUPTED};
use clap::Args;
use scenarios::TrialModel;
use trial::{Abort, Limits, Trial};
use verdict::{Findings, Rule};

/// Arguments of `phasecloud check`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  phasecloud check -- python3 my_propagator.py --samples 500\n  \
    phasecloud check mc --set samples=2000\n  phasecloud check --model vectorial -- ./my-propagator\n\n\
    Exit codes: 0 all rules are kept; 1 a rule is broken; 2 the command cannot be started, or what a built-in \
    propagator is given is not allowed; 130 stopped on request.")]
pub struct CheckArguments {
    /// Print JSON instead of a table
    #[arg(long)]
    pub json: bool,
    /// Seconds without any sign of life after which the propagator is given up
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0)]
    pub patience: f64,
    /// Seconds that it may take to end after SIGTERM; `phasecloud run` kills after 1.5
    #[arg(long, value_name = "SECONDS", default_value_t = 2.0)]
    pub grace: f64,
    /// The model of the scenarios that it is given
    #[arg(long, value_enum, default_value_t)]
    pub model: TrialModel,
    /// The samples are drawn anew for every snapshot: do not expect them to keep their Hamiltonian
    #[arg(long)]
    pub redrawn: bool,
    /// The propagator: a program and its arguments, or the name of a built-in one and arguments of `phasecloud node`
    #[arg(required = true, trailing_var_arg = true, allow_hyphen_values = true)]
    pub command: Vec<String>,
}

/// Checks a propagator and reports.
pub fn run(arguments: &CheckArguments) -> ExitCode {
    let limits = match limits(arguments).and_then(|limits| check_built_in(&arguments.command).map(|()| limits)) {
        Ok(limits) => limits,
        Err(problem) => {
            remark!("error: phasecloud check: {problem}");
            return ExitCode::from(BAD_INPUT);
        }
    };
    let command = full_command(&arguments.command);
    match conduct_trials(&command, &limits, arguments) {
        Ok(findings) => {
            findings.print(&command, arguments.json);
            if findings.passed() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
        }
        Err(Abort::Interrupted) => {
            remark!("interrupted");
            ExitCode::from(INTERRUPTED)
        }
        Err(Abort::NotStarted(problem)) => {
            remark!("error: phasecloud check: {problem}");
            ExitCode::from(BAD_INPUT)
        }
        Err(Abort::Fatal(problem)) => {
            remark!("error: phasecloud check: {problem}");
            ExitCode::FAILURE
        }
    }
}

fn limits(arguments: &CheckArguments) -> Result<Limits, String> {
    let seconds = |name: &str, value: f64| match Duration::try_from_secs_f64(value) {
        Ok(duration) if !duration.is_zero() => Ok(duration),
        _ => Err(format!("--{name} {value} is not allowed, it must be a number of seconds greater than 0")),
    };
    Ok(Limits { patience: seconds("patience", arguments.patience)?, grace: seconds("grace", arguments.grace)? })
}

/// Checks the arguments of a built-in propagator: an error in them is the user's, not the propagator's.
fn check_built_in(words: &[String]) -> Result<(), String> {
    if is_built_in(words) { node::check_words(words) } else { Ok(()) }
}

fn is_built_in(words: &[String]) -> bool {
    words.first().is_some_and(|first| BuiltIn::NAMES.contains(&first.as_str()))
}

/// A built-in propagator's name stands for the command that runs it.
fn full_command(words: &[String]) -> Vec<String> {
    match own_path() {
        Ok(program) if is_built_in(words) => {
            [program.display().to_string(), "node".into()].into_iter().chain(words.iter().cloned()).collect()
        }
        _ => words.to_vec(),
    }
}

/// Three processes one after the other: one that answers two scenarios and is stopped while it waits, one that is
/// stopped while it computes, and one that is asked what cannot be answered.
fn conduct_trials(command: &[String], limits: &Limits, arguments: &CheckArguments) -> Result<Findings, Abort> {
    let CheckArguments { model, redrawn, .. } = *arguments;
    let signals = Signals::catch(&[signal_hook::consts::SIGCHLD])
        .map_err(|e| Abort::Fatal(format!("cannot catch signals: {e}")))?;
    domain::sweep();
    let mut findings = Findings::default();
    let [first, second] = scenarios::known(model);

    let mut trial = Trial::start(command, &signals, limits)?;
    let ready = trial.wait_until_ready()?;
    conduct::handshake(&mut findings, &ready);
    if !ready.outcome.is_done() {
        return Ok(findings);
    }
    let mut answers = vec![trial.ask(first)?];
    conduct::answered(&mut findings, Rule::FirstScenario, &answers[0]);
    if answers[0].outcome.is_done() {
        answers.push(trial.ask(second)?);
        conduct::answered(&mut findings, Rule::SecondScenario, &answers[1]);
    }
    if answers.iter().all(|answer| answer.outcome.is_done()) {
        conduct::stopped(&mut findings, Rule::StopWaiting, &trial.stop()?);
    }
    drop(trial);
    for answer in &answers {
        delivery::judge(&mut findings, answer);
        physics::judge(&mut findings, answer, redrawn);
    }

    let mut trial = Trial::start(command, &signals, limits)?;
    let mut outcome = trial.wait_until_ready()?.outcome;
    if outcome.is_done() {
        outcome = trial.ask_for_the_first_snapshot(scenarios::long(model))?.outcome;
    }
    match outcome.is_done() {
        true => conduct::stopped(&mut findings, Rule::StopComputing, &trial.stop()?),
        false => conduct::not_reached(&mut findings, Rule::StopComputing, &outcome),
    }
    drop(trial);

    let mut trial = Trial::start(command, &signals, limits)?;
    let outcome = trial.wait_until_ready()?.outcome;
    match outcome.is_done() {
        true => conduct::refused(&mut findings, &trial.ask(scenarios::impossible(model))?),
        false => conduct::not_reached(&mut findings, Rule::Refusal, &outcome),
    }
    Ok(findings)
}

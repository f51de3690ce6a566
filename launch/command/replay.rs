//! `phasecloud replay`: runs again what was recorded, with any part of it replaced.
//!
//! A replay is a run whose cases are played from a recording instead of being computed; the scenario node, the
//! estimator, the comparator and the recorder work as in any run. Options choose otherwise for each part.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use messages::recording::Recording;
use messages::service::Service;

use crate::command::run::Order;
use crate::exit::BAD_INPUT;
use crate::plan::cases::Runs;
use crate::plan::launch_file::Launch;
use crate::record::recording::About;
use crate::shown::{Logged, Shown};

/// Services that can be played from a recording or replaced by a program.
const SERVICES: [&str; 2] = [Service::Estimator.name(), Service::Comparator.name()];

/// Arguments of `phasecloud replay`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  phasecloud run --record run.tape\n  phasecloud replay run.tape\n  \
    phasecloud replay run.tape --replace gmm-ut=\"target/release/stt-gaussian\" --out results/mine\n\n\
    Without options all cases are played and estimator, comparator and recorder compute anew: every file of the results is \
    the same, byte for byte, but effort.csv, in which the estimator's CPU time is measured anew, and manifest.json.")]
pub struct ReplayArguments {
    /// The recording
    pub file: PathBuf,
    /// Compute this case as the recorded launch file says instead of playing it; may be repeated
    #[arg(long, value_name = "LABEL")]
    pub live: Vec<String>,
    /// Leave this case out; may be repeated
    #[arg(long, value_name = "LABEL")]
    pub without: Vec<String>,
    /// Run a program, its words separated by blanks, as this case or as estimator or comparator; may be repeated
    #[arg(long, value_name = "NAME=COMMAND")]
    pub replace: Vec<String>,
    /// Play the estimator or the comparator from the recording, too; may be repeated. Only if all cases are played as
    /// recorded
    #[arg(long, value_name = "NAME", value_parser = SERVICES, conflicts_with_all = ["live", "without", "replace"])]
    pub recorded: Vec<String>,
    /// The results folder, new or empty [default: results/NAME-TIME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub shown: Shown,
}

/// Replays a recording.
pub fn run(arguments: &ReplayArguments) -> ExitCode {
    match prepare(arguments) {
        Ok(launch) => {
            let order = Order {
                out: arguments.out.as_deref(),
                record: None,
                report: true,
                export: None,
                shown: arguments.shown,
                logged: Logged::default(),
                insecure: false,
                start_order: None,
            };
            super::run::execute(Ok(launch), &order)
        }
        Err(problem) => {
            remark!("error: {problem}");
            ExitCode::from(BAD_INPUT)
        }
    }
}

fn prepare(arguments: &ReplayArguments) -> Result<Launch, String> {
    let file = arguments.file.canonicalize().map_err(|e| format!("{}: {e}", arguments.file.display()))?;
    let recording = Recording::open(&file).map_err(|e| e.to_string())?;
    let about: About = serde_json::from_str(recording.about()).map_err(|e| format!("{}: {e}", file.display()))?;
    drop(recording);
    let mut launch = Launch::from_record(&about.launch_file, &about.scenarios).map_err(|e| e.to_string())?;
    launch.stay_home();
    for label in arguments.live.iter().chain(&arguments.without) {
        if !launch.cases.iter().any(|case| case.label == *label) {
            return Err(unknown(label, &launch, &[]));
        }
    }
    launch.cases.retain(|case| !arguments.without.contains(&case.label));
    let references = launch.references.join(" and ");
    launch.references.retain(|label| !arguments.without.contains(label));
    if launch.references.is_empty() {
        return Err(format!("{references} cannot be left out, all cases are compared with it"));
    }
    for case in launch.cases.iter_mut().filter(|case| !arguments.live.contains(&case.label)) {
        case.runs = Runs::Recorded(file.clone());
    }
    for name in &arguments.recorded {
        launch.substitutes.insert(name.clone(), Runs::Recorded(file.clone()));
    }
    for replacement in &arguments.replace {
        replace(&mut launch, replacement)?;
    }
    if !arguments.shown.quiet && !arguments.shown.json {
        let About { run_id, configuration, .. } = &about;
        remark!("replaying {}, run {run_id}, configuration {configuration:.12}", arguments.file.display());
    }
    Ok(launch)
}

/// Applies one `NAME=COMMAND` of the option `--replace`.
fn replace(launch: &mut Launch, replacement: &str) -> Result<(), String> {
    let (name, command) = replacement.split_once('=').unwrap_or((replacement, ""));
    let words: Vec<String> = command.split_whitespace().map(str::to_owned).collect();
    if words.is_empty() {
        return Err(format!("--replace {replacement}: must be NAME=COMMAND"));
    }
    let runs = Runs::Command(words);
    match launch.cases.iter_mut().find(|case| case.label == name) {
        // Nobody knows whether the program can split its work into shards.
        Some(case) => (case.runs, case.shards, case.reduce) = (runs, 1, false),
        None if SERVICES.contains(&name) => {
            launch.substitutes.insert(name.to_owned(), runs);
        }
        None => return Err(unknown(name, launch, &SERVICES)),
    }
    Ok(())
}

fn unknown(name: &str, launch: &Launch, others: &[&str]) -> String {
    let labels = launch.cases.iter().map(|case| case.label.as_str()).chain(others.iter().copied());
    format!("the recording has no \"{name}\"; there are {}", labels.collect::<Vec<_>>().join(", "))
}

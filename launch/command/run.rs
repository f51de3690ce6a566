//! `phasecloud run`: from the launch file to the results folder.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use kit::clock;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use results::join::join;
use results::parquet;

use super::export::TableFormat;
use crate::crew::commands::Commands;
use crate::crew::log_sink::{LogSink, start_log};
use crate::crew::shares;
use crate::domain::{self, OwnDomain, attach};
use crate::exit::{BAD_INPUT, INTERRUPTED};
use crate::live::json;
use crate::plan::launch_file::{Launch, Restart};
use crate::plan::preflight;
use crate::record::folder::{self, ResultsFolder};
use crate::record::manifest;
use crate::record::recording::Draft;
use crate::run::{Abort, Failures, Run};
use crate::shown::{Logged, Shown};
use crate::{output, report};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `phasecloud run`.
#[derive(Debug, Default, Args)]
#[command(after_help = "Examples:\n  phasecloud run\n  phasecloud run paper --out results/paper\n  \
    phasecloud run --scenario my-scenario.toml")]
pub struct RunArguments {
    /// The launch file, or the name of one that is built in: scenario-1, scenario-2, scenario-3, paper, as-printed,
    /// three-dimensional, fidelity, sweep [default: scenario-1, with the paper's four cases]
    pub launch_file: Option<PathBuf>,
    /// Run on this scenario file instead of those that the launch file names
    #[arg(long, value_name = "FILE")]
    pub scenario: Option<PathBuf>,
    /// The results folder, new or empty [default: results/NAME-TIME, where NAME is the scenario's, or the launch file's
    /// if there are several scenarios]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Keep every message of the run in this new file, for `phasecloud replay`
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Write tables only, neither report.html nor figures; `phasecloud report DIR` makes them later
    #[arg(long)]
    pub no_report: bool,
    /// Write the tables in this format, too
    #[arg(long, value_name = "FORMAT")]
    pub export: Option<TableFormat>,
    #[command(flatten)]
    pub shown: Shown,
    /// Start all processes at random times that follow from this seed, to show that the order does not matter
    #[arg(long, value_name = "SEED", hide = true)]
    pub start_order: Option<u64>,
    #[command(flatten)]
    pub logged: Logged,
    /// Let hosts talk without encryption beyond this machine
    #[arg(long)]
    pub insecure: bool,
}

/// Longest delay of a start in a random order.
const LONGEST_DELAY: Duration = Duration::from_millis(300);

/// How a run is to be done.
#[derive(Debug)]
pub struct Order<'a> {
    /// The results folder, if one is named.
    pub out: Option<&'a Path>,
    /// Where to keep every message, if anywhere.
    pub record: Option<&'a Path>,
    /// Whether the results get a report and figures.
    pub report: bool,
    /// In what other format the tables are written, too.
    pub export: Option<TableFormat>,
    /// How much the run prints.
    pub shown: Shown,
    /// How much of the log is shown.
    pub logged: Logged,
    /// Whether hosts may talk without encryption beyond this machine.
    pub insecure: bool,
    /// Seed of the random times at which the processes are started; without it all are started at once.
    pub start_order: Option<u64>,
}

/// Runs a launch file from start to results folder.
pub fn run(arguments: &RunArguments) -> ExitCode {
    let launch = Launch::load_to_start(arguments.launch_file.as_deref(), arguments.scenario.as_deref());
    let RunArguments { out, record, no_report, export, shown, start_order, logged, insecure, .. } = arguments;
    let order = Order {
        out: out.as_deref(),
        record: record.as_deref(),
        report: !no_report,
        export: *export,
        shown: *shown,
        logged: *logged,
        insecure: *insecure,
        start_order: *start_order,
    };
    execute(launch.map_err(|e| e.to_string()), &order)
}

/// Runs a launch file that has been read, or prints why it could not be read. With `--json` the run has failed if the
/// JSON, its result, could not be written; the results folder is there all the same.
pub fn execute(launch: Result<Launch, String>, order: &Order<'_>) -> ExitCode {
    let code = carry_out(launch, order);
    if order.shown.json { output::end(code) } else { code }
}

fn carry_out(launch: Result<Launch, String>, order: &Order<'_>) -> ExitCode {
    let run_id = domain::fresh_run_id();
    let prepared = launch.and_then(|mut launch| {
        if order.record.is_some() {
            // A process that is started again sends its messages again, and the recording would hold them twice.
            launch.restart = Restart::Never;
        }
        launch.open_to_hosts(order.insecure)?;
        preflight::check_address_space()?;
        preflight::check_shared_memory(&launch, launch.most_snapshots())?;
        preflight::check_file_size(&launch, launch.most_snapshots())?;
        preflight::check_descriptors(launch.propagators())?;
        domain::sweep();
        let own = OwnDomain::claim(run_id)?;
        let folder = ResultsFolder::prepare(order.out, folder::name_of(&launch), run_id)?;
        let tape = order.record.map(|path| Draft::begin(path, &launch, run_id)).transpose();
        let tape = tape.inspect_err(|_| folder.discard())?;
        let log = start_log(&folder.draft, run_id, order.shown, order.logged).inspect_err(|_| folder.discard())?;
        Ok((launch, folder, tape, log, own))
    });
    let (launch, folder, tape, log, own) = match prepared {
        Ok(prepared) => prepared,
        Err(problem) => return end_without_results(order, BAD_INPUT, &format!("error: {problem}")),
    };
    let outcome = conduct(&launch, &folder, tape.as_ref(), own, run_id, order, &log);
    let is_whole = match &outcome {
        Ok(kept) => kept.incomplete.is_none(),
        Err(Abort::Unpublished(_)) => true,
        Err(_) => false,
    };
    let outcome = match tape {
        Some(tape) if !is_whole => {
            tape.discard();
            outcome
        }
        Some(tape) => tape.publish().map_err(Abort::Unpublished).and(outcome),
        None => outcome,
    };
    match outcome {
        Ok(kept) => conclude(&kept, &folder, order),
        Err(Abort::Stopped | Abort::Interrupted) => {
            folder.discard();
            end_without_results(order, INTERRUPTED, "interrupted: nothing was written")
        }
        Err(Abort::Fatal(problem)) => {
            folder.discard();
            end_without_results(order, 1, &format!("error: {problem}; nothing was written"))
        }
        Err(Abort::Unpublished(problem)) => end_without_results(order, 1, &format!("error: {problem}")),
    }
}

/// Prints what is in the results folder; returns the exit code.
fn conclude(Kept { launch, failures, incomplete }: &Kept, folder: &ResultsFolder, order: &Order<'_>) -> ExitCode {
    let contradictions = report::errors(&folder.path);
    let is_wrong = !failures.is_empty() || !contradictions.is_empty();
    let exit_code = if incomplete.is_some() { INTERRUPTED } else { u8::from(is_wrong) };
    if order.shown.json {
        json::result(exit_code, &folder.path, failures, incomplete.as_deref());
    } else if !order.shown.quiet {
        report::print(launch, &folder.path);
        say!("\nResults: {}", folder.path.display());
    }
    for (name, why) in failures {
        remark!("error: {name}: {why}");
    }
    for what in &contradictions {
        remark!("error: {what}");
    }
    if let Some(why) = incomplete {
        let recording = if order.record.is_some() { "; the recording was discarded" } else { "" };
        remark!("interrupted: the results in {} are not whole: {why}{recording}", folder.path.display());
    }
    ExitCode::from(exit_code)
}

fn end_without_results(order: &Order<'_>, exit_code: u8, problem: &str) -> ExitCode {
    if order.shown.json {
        json::no_result(exit_code, problem);
    }
    remark!("{problem}");
    ExitCode::from(exit_code)
}

/// What is in the results folder.
struct Kept {
    /// The launch file, with the scenarios that were recorded.
    launch: Launch,
    /// Why cases failed, by name.
    failures: BTreeMap<String, String>,
    /// Why the results are not whole, if they are not.
    incomplete: Option<String>,
}

/// Conducts the run in its own domain, removes the domain, and publishes the results.
fn conduct(
    launch: &Launch,
    folder: &ResultsFolder,
    tape: Option<&Draft>,
    own: OwnDomain,
    run_id: u64,
    order: &Order<'_>,
    log: &LogSink,
) -> Result<Kept, Abort> {
    let started = clock::seconds();
    attach::announce(&own.place, launch, &folder.path, false).map_err(Abort::Fatal)?;
    let scenarios = folder.keep_scenarios(launch).map_err(Abort::Fatal)?;
    let scenarios = scenarios.iter().flat_map(|file| ["--scenario".into(), file.display().to_string()]).collect();
    let tape = tape.map(|tape| tape.draft.clone());
    let snapshots = launch.most_snapshots();
    let bridge_role = shares::write_bridge_role(launch, &own.place.root, run_id, snapshots).map_err(Abort::Fatal)?;
    let commands =
        Commands { launch, place: &own.place, run_id, draft: folder.draft.clone(), tape, scenarios, bridge_role };
    let (kept, nodes, signals) = {
        let in_all = Some(launch.scenarios.len() as u32);
        let mut run = Run::begin(commands, snapshots, in_all, order.shown, log, start_times(order.start_order))?;
        own.keep();
        let completed = run.conduct(|_, _| Ok(()));
        let nodes = run.end();
        match completed {
            Err(Abort::Stopped) if run.recorded() > 0 => {}
            other => other?,
        }
        (kept(launch, &run), nodes, run.into_signals())
    };
    drop(own);
    log.close().map_err(Abort::Fatal)?;
    let recorded = &kept.launch.scenarios;
    join(&folder.draft, recorded.len() as u32).map_err(|e| Abort::Fatal(e.to_string()))?;
    folder.keep_only(recorded).map_err(Abort::Fatal)?;
    let (failures, incomplete) = (&kept.failures, kept.incomplete.as_deref());
    let record = manifest::Record { run_id, started, nodes: &nodes, failures, incomplete };
    let unsealed = |problem: String| Abort::Unpublished(format!("{problem}; {}", folder.remains()));
    manifest::write(&folder.draft, &kept.launch, record).map_err(unsealed)?;
    if let Some(TableFormat::Parquet) = order.export {
        parquet::write(&folder.draft, &folder.draft).map_err(|e| unsealed(e.to_string()))?;
    }
    if order.report {
        draw_report(&folder.draft);
    }
    if kept.incomplete.is_some() && signals.stop_requested() {
        return Err(Abort::Interrupted);
    }
    manifest::seal(&folder.draft).map_err(unsealed)?;
    folder.publish().map_err(Abort::Unpublished)?;
    Ok(kept)
}

/// What a run has left in the results folder.
fn kept(launch: &Launch, run: &Run<'_>) -> Kept {
    let recorded = run.recorded();
    let scenarios = launch.scenarios.iter().take(recorded as usize).cloned().collect();
    let failures = run.failures().iter().filter(|((scenario, _), _)| *scenario < recorded);
    let failures = failures.map(|(place, why)| (place.clone(), why.clone())).collect();
    Kept {
        launch: Launch { scenarios, ..launch.clone() },
        failures: by_name(launch, &failures, run.strangers()),
        incomplete: run.incompleteness(),
    }
}

/// Makes the report. The results are worth keeping without one, but not with a part of one.
fn draw_report(draft: &Path) {
    let made = super::report::make(draft);
    if made.is_err() {
        super::report::remove(draft);
    }
    match made {
        Ok(missing) => super::report::warn(&missing),
        Err(problem) => remark!("warning: no report: {problem}"),
    }
}

/// When the processes are started: at once, or at random times that follow from a seed.
fn start_times(order: Option<u64>) -> impl FnMut() -> Instant {
    let now = Instant::now();
    let mut random = order.map(ChaCha8Rng::seed_from_u64);
    move || match &mut random {
        Some(random) => now + LONGEST_DELAY.mul_f64(random.random()),
        None => now,
    }
}

/// The failures under the names that the user is shown: the case, after the scenario if there are several.
fn by_name(launch: &Launch, failures: &Failures, strangers: &BTreeMap<String, String>) -> BTreeMap<String, String> {
    let name = |(scenario, label): &(u32, String)| match launch.scenarios.get(*scenario as usize) {
        Some(scenario) if launch.scenarios.len() > 1 => format!("{}, {label}", scenario.content.name()),
        _ => label.clone(),
    };
    let failures = failures.iter().map(|(place, why)| (name(place), why.clone()));
    failures.chain(strangers.clone()).collect()
}

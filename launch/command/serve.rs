//! `phasecloud serve`: keeps the processes up and takes scenario after scenario, from a sweep file or from requests.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use kit::clock;
use nodes::files::file_kind::FileKind;
use nodes::files::input::{InputError, InputFile};
use nodes::files::map_file::MapFile;
use nodes::files::scenario_file;
use nodes::files::sweep::Sweep;
use results::files::{SCENARIO, SCENARIOS, part};
use results::join;

use crate::crew::commands::Commands;
use crate::crew::log_sink::start_log;
use crate::crew::shares;
use crate::domain::{self, OwnDomain, attach};
use crate::exit::{BAD_INPUT, INTERRUPTED};
use crate::live::json;
use crate::plan::launch_file::Launch;
use crate::plan::preflight;
use crate::plan::scenario_inputs::ScenarioInput;
use crate::record::folder::ResultsFolder;
use crate::record::manifest;
use crate::run::{Abort, Failures, Run};
use crate::shown::{Logged, Shown};
use crate::sweep::{self, Done, TABLE};
use crate::{output, report};
use clap::Args;

/// Arguments of `phasecloud serve`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phasecloud serve launch/sweep.toml --sweep launch/sweeps/initial-e.toml --out results/sweep\n  \
    phasecloud serve launch/scenario-1.toml &\n  phasecloud submit launch/scenarios/scenario-2.toml\n\n\
    Every scenario becomes a results folder of its own as soon as it is done; a sweep ends with tables of all of them, sweep.csv \
    and report.html. The launch file says which cases are run; its own scenarios are not.\n\n\
    Exit codes: 0 all was done, or a service was asked to end; 1 a case failed or a combination is impossible, it is named and \
    the rest was done; 2 bad input, nothing started; 130 a sweep was stopped on request."
)]
pub struct ServeArguments {
    /// The launch file [default: the paper's four cases and the exact answer]
    pub launch_file: Option<PathBuf>,
    /// Work on the scenarios of this sweep file, then end; without it, work on requests until Ctrl-C
    #[arg(long, value_name = "FILE")]
    pub sweep: Option<PathBuf>,
    /// The folder for the results folders, new or empty [default: results/NAME-TIME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Most snapshots that a scenario may have; one with more is refused [default: 16; with --sweep, as many as the
    /// sweep needs]
    #[arg(long, value_name = "N", value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(2..=64))]
    pub most_snapshots: Option<usize>,
    /// Let hosts talk without encryption beyond this machine
    #[arg(long)]
    pub insecure: bool,
    #[command(flatten)]
    pub shown: Shown,
    #[command(flatten)]
    pub logged: Logged,
}

/// Most snapshots that a requested scenario may have, unless `--most-snapshots` says otherwise.
const MOST_SNAPSHOTS_ASKED_FOR: usize = 16;

/// What a service has done so far.
#[derive(Default)]
struct Tally {
    folders: Vec<PathBuf>,
    /// Cases that failed, as `SCENARIO, CASE: WHY`.
    failed: Vec<String>,
    /// The combinations of a sweep that have been recorded.
    done: Vec<Done>,
    /// By name, with the reason: scenarios that were refused, and senders that are no case of the run.
    refused: BTreeMap<String, String>,
    /// Results that contradict one another, or cannot be right.
    contradictions: usize,
}

/// Serves until the sweep is done, or until asked to stop. With `--json` it has failed if the JSON, its result, could
/// not be written.
pub fn run(arguments: &ServeArguments) -> ExitCode {
    let code = carry_out(arguments);
    if arguments.shown.json { output::end(code) } else { code }
}

fn carry_out(arguments: &ServeArguments) -> ExitCode {
    let run_id = domain::fresh_run_id();
    let (prepared, own) = match prepare(arguments, run_id) {
        Ok(both) => both,
        Err(problem) => {
            remark!("error: {problem}");
            return ExitCode::from(BAD_INPUT);
        }
    };
    let mut tally = Tally::default();
    let (started, begun) = (clock::seconds(), Instant::now());
    let served = serve(arguments, &prepared, own, run_id, &mut tally);
    let is_sweep = prepared.sweep.is_some();
    let outcome = match served {
        // A sweep that was stopped gets tables of what has been done.
        Ok(()) | Err(Abort::Stopped | Abort::Interrupted) => {
            write_sweep(&prepared, &tally).map_err(Abort::Unpublished).and(served)
        }
        fatal => fatal,
    };
    let folder = &prepared.folder;
    folder.discard();
    let incomplete = incompleteness(&prepared, &tally);
    let sealed = seal(&prepared, &tally, run_id, &started, incomplete.as_deref()).map_err(Abort::Unpublished);
    let outcome = match outcome {
        Err(Abort::Fatal(_) | Abort::Unpublished(_)) => outcome, // the first problem is the one that is printed
        other => sealed.and(other),
    };
    let served = tally.folders.len();
    if let Err(Abort::Fatal(problem) | Abort::Unpublished(problem)) = outcome {
        remark!("error: {problem}; {served} scenarios are in {}", folder.path.display());
        return ExitCode::FAILURE;
    }
    summarise(arguments.shown, &folder.path, served, begun);
    tally.failed.iter().for_each(|case| remark!("error: {case}"));
    let refused = if is_sweep { tally.refused.len() } else { 0 };
    match outcome {
        Err(Abort::Stopped | Abort::Interrupted) if is_sweep => {
            incomplete.iter().for_each(|why| remark!("the results are not whole: {why}"));
            ExitCode::from(INTERRUPTED)
        }
        _ if tally.failed.is_empty() && refused + tally.contradictions == 0 => ExitCode::SUCCESS,
        _ => {
            let (refused, says) = match is_sweep {
                true => (format!("{refused} combinations were refused, "), format!("{TABLE} says")),
                false => (String::new(), "each manifest.json and notes.csv says".to_owned()),
            };
            let (failed, contradictions) = (tally.failed.len(), tally.contradictions);
            remark!(
                "error: {refused}{failed} cases failed and {contradictions} results contradict one another or cannot be right; {says} \
                 which and why"
            );
            ExitCode::FAILURE
        }
    }
}

fn summarise(shown: Shown, path: &Path, served: usize, begun: Instant) {
    let seconds = begun.elapsed().as_secs_f64();
    if shown.json {
        return json::served(path, served, seconds);
    }
    if shown.quiet {
        return;
    }
    say!("{served} scenarios in {seconds:.1} s, {:.2} a second", served as f64 / seconds);
    say!("Results: {}", path.display());
}

/// Why a sweep is not whole, if it is not.
fn incompleteness(prepared: &Prepared, tally: &Tally) -> Option<String> {
    let sweep = prepared.sweep.as_ref()?;
    let missing = sweep.len().saturating_sub(tally.done.len() + tally.refused.len());
    (missing > 0).then(|| format!("the sweep was stopped; {missing} of its {} combinations were not done", sweep.len()))
}

/// Writes the manifest of the whole folder.
fn seal(
    prepared: &Prepared,
    tally: &Tally,
    run_id: u64,
    started: &str,
    incomplete: Option<&str>,
) -> Result<(), String> {
    let Prepared { launch, sweep_text, folder, .. } = prepared;
    let name = |path: &PathBuf| Some(path.file_name()?.to_string_lossy().into_owned());
    let folders: Vec<String> = tally.folders.iter().filter_map(name).collect();
    let (sweep, refused) = (sweep_text.as_deref(), &tally.refused);
    let collection = manifest::Collection { run_id, started, sweep, folders: &folders, refused, incomplete };
    manifest::write_collection(&folder.path, launch, &collection)
}

/// What is needed before the first scenario is served.
struct Prepared {
    launch: Launch,
    sweep: Option<Sweep>,
    sweep_text: Option<String>,
    folder: ResultsFolder,
    most_snapshots: usize,
}

/// The combinations of a sweep file, or of a map file, of which everything is checked, also what a sweep has no use
/// for.
fn load_sweep(path: &Path) -> Result<Sweep, InputError> {
    let file = InputFile::read(path)?;
    if file.kind() == Some(FileKind::Map) {
        MapFile::check(&file)?;
    }
    Sweep::check(&file)
}

fn prepare(arguments: &ServeArguments, run_id: u64) -> Result<(Prepared, OwnDomain), String> {
    let mut launch = Launch::load_to_start(arguments.launch_file.as_deref(), None).map_err(|e| e.to_string())?;
    launch.open_to_hosts(arguments.insecure)?;
    let path = |path| preflight::check_path("--sweep", path);
    arguments.sweep.as_deref().map(path).transpose()?;
    let sweep = arguments.sweep.as_deref().map(load_sweep).transpose().map_err(|e| e.to_string())?;
    let text = |path: &PathBuf| std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()));
    let sweep_text = arguments.sweep.as_ref().map(text).transpose()?;
    let most_snapshots = arguments.most_snapshots.or_else(|| sweep.as_ref().map(Sweep::most_snapshots));
    let most_snapshots = most_snapshots.unwrap_or(MOST_SNAPSHOTS_ASKED_FOR);
    preflight::check_address_space()?;
    preflight::check_shared_memory(&launch, most_snapshots)?;
    preflight::check_file_size(&launch, most_snapshots)?;
    preflight::check_descriptors(launch.propagators())?;
    domain::sweep();
    let own = OwnDomain::claim(run_id)?;
    let folder = ResultsFolder::prepare(arguments.out.as_deref(), &launch.name, run_id)?;
    std::fs::create_dir_all(&folder.path).map_err(|e| format!("{}: {e}", folder.path.display()))?;
    Ok((Prepared { launch, sweep, sweep_text, folder, most_snapshots }, own))
}

/// Conducts the scenarios in their own domain, and publishes the folder of each.
fn serve(
    arguments: &ServeArguments,
    prepared: &Prepared,
    own: OwnDomain,
    run_id: u64,
    tally: &mut Tally,
) -> Result<(), Abort> {
    let Prepared { launch, folder, most_snapshots, .. } = prepared;
    let log = start_log(&folder.path, run_id, arguments.shown, arguments.logged).map_err(Abort::Fatal)?;
    attach::announce(&own.place, launch, &folder.path, arguments.sweep.is_none()).map_err(Abort::Fatal)?;
    let mut scenarios = match &arguments.sweep {
        Some(file) => vec!["--sweep".into(), file.display().to_string()],
        None => vec!["--requests".into()],
    };
    scenarios.extend(["--most-snapshots".into(), most_snapshots.to_string()]);
    let bridge_role =
        shares::write_bridge_role(launch, &own.place.root, run_id, *most_snapshots).map_err(Abort::Fatal)?;
    let draft = folder.draft.clone();
    let commands = Commands { launch, place: &own.place, run_id, draft, tape: None, scenarios, bridge_role };
    let now = Instant::now();
    let mut run = Run::begin(commands, *most_snapshots, None, arguments.shown, &log, || now)?;
    own.keep();
    if prepared.sweep.is_none() {
        match arguments.shown {
            Shown { json: true, .. } => json::serving(run_id),
            Shown { quiet: true, .. } => {}
            _ => say!("serving as {run_id:012x}; ask with: phasecloud submit SCENARIO_FILE... (Ctrl-C ends)"),
        }
    }
    let completed = run.conduct(|scenario, failures| {
        let failures = of_scenario(failures, scenario);
        publish(prepared, run_id, scenario, failures, tally)
    });
    tally.refused.clone_from(run.strangers());
    run.end();
    let logged = log.close();
    completed?;
    logged.map_err(Abort::Unpublished)
}

/// Writes the tables and the page of a sweep, as far as it has come.
fn write_sweep(prepared: &Prepared, tally: &Tally) -> Result<(), String> {
    let Prepared { launch, sweep: Some(sweep), folder, .. } = prepared else { return Ok(()) };
    join::join_all_tables(&tally.folders, &folder.path).map_err(|e| e.to_string())?;
    let cases: Vec<String> = launch.cases.iter().map(|case| case.label.clone()).collect();
    sweep::write(sweep, &tally.done, &tally.refused, &cases, &folder.path)
}

/// Why cases failed in one scenario, by label.
fn of_scenario(failures: &Failures, scenario: u32) -> BTreeMap<String, String> {
    let here = failures.iter().filter(|((position, _), _)| *position == scenario);
    here.map(|((_, label), why)| (label.clone(), why.clone())).collect()
}

/// The name of the results folder of the scenario `name`, which has the number `position` in the service.
pub fn folder_name(position: u32, name: &str) -> String {
    format!("{position:06}-{name}")
}

/// Turns what the recorder has written about a scenario into a results folder of its own.
fn publish(
    prepared: &Prepared,
    run_id: u64,
    scenario: u32,
    failures: BTreeMap<String, String>,
    tally: &mut Tally,
) -> Result<(), String> {
    let Prepared { launch, folder, .. } = prepared;
    let draft = part(&folder.draft, scenario);
    let file = draft.join(SCENARIO);
    let content = scenario_file::load_cloud(&file).map_err(|e| e.to_string())?;
    let text = std::fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?;
    let name = content.name().to_owned();
    let kept = draft.join(SCENARIOS);
    let moved = std::fs::create_dir(&kept).and_then(|()| std::fs::rename(&file, kept.join(format!("{name}.toml"))));
    moved.map_err(|e| format!("{}: {e}", kept.display()))?;
    let combination = prepared.sweep.as_ref().and_then(|sweep| Some((sweep, sweep.index_of(&name)?)));
    if let Some((sweep, index)) = combination {
        sweep::write_varied(sweep, index, &name, &draft)?;
    }
    let alone = Launch { scenarios: vec![ScenarioInput { text, content }], ..launch.clone() };
    let now = clock::seconds();
    let record =
        manifest::Record { run_id, started: now, nodes: &BTreeMap::new(), failures: &failures, incomplete: None };
    manifest::write(&draft, &alone, record)?;
    manifest::seal(&draft)?;
    let path = folder.path.join(folder_name(scenario, &name));
    std::fs::rename(&draft, &path).map_err(|e| format!("{}: {e}", path.display()))?;
    tally.failed.extend(failures.iter().map(|(label, why)| format!("{name}, {label}: {why}")));
    if let Some((_, index)) = combination {
        let (folder, errors) = (folder_name(scenario, &name), report::errors_by_case(&path));
        tally.done.push(Done { index, folder, name, failures, errors });
    }
    for what in report::errors(&path) {
        remark!("error: {what}");
        tally.contradictions += 1;
    }
    tally.folders.push(path);
    Ok(())
}

//! `phasecloud serve`: keeps the processes up and takes scenario after scenario, of a sweep file or of whoever asks.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use nodes::clock;
use nodes::recorder::{SCENARIO, join, part};
use nodes::scenario_file;
use nodes::sweep::Sweep;

use crate::BAD_INPUT;
use crate::cli::ServeArguments;
use crate::commands::Commands;
use crate::domains::{self, OwnDomain};
use crate::launch_file::{Launch, ScenarioInput};
use crate::results_folder::ResultsFolder;
use crate::run::{Abort, Failures, Run};
use crate::run_command::start_log;
use crate::{attach, manifest, plans, preflight};

/// What a service has done so far.
#[derive(Default)]
struct Tally {
    folders: Vec<PathBuf>,
    failed: usize,
}

/// Serves until the sweep is done, or until asked to stop.
pub fn run(arguments: &ServeArguments) -> ExitCode {
    let run_id = domains::fresh_run_id();
    let prepared = prepare(arguments, run_id);
    let (launch, folder) = match prepared {
        Ok(prepared) => prepared,
        Err(problem) => {
            remark!("error: {problem}");
            return ExitCode::from(BAD_INPUT);
        }
    };
    let mut tally = Tally::default();
    let begun = Instant::now();
    let outcome = serve(arguments, &launch, &folder, run_id, &mut tally);
    folder.discard();
    let served = tally.folders.len();
    match outcome {
        Ok(()) | Err(Abort::Stopped | Abort::Interrupted) if tally.failed == 0 => {
            summarise(&folder.path, served, begun);
            ExitCode::SUCCESS
        }
        Ok(()) | Err(Abort::Stopped | Abort::Interrupted) => {
            summarise(&folder.path, served, begun);
            remark!("error: {} cases failed; each manifest says which and why", tally.failed);
            ExitCode::FAILURE
        }
        Err(Abort::Fatal(problem) | Abort::Unpublished(problem)) => {
            remark!("error: {problem}; {served} scenarios are in {}", folder.path.display());
            ExitCode::FAILURE
        }
    }
}

fn summarise(path: &Path, served: usize, begun: Instant) {
    let seconds = begun.elapsed().as_secs_f64();
    say!("{served} scenarios in {seconds:.1} s, {:.2} a second", served as f64 / seconds);
    say!("Results: {}", path.display());
}

fn prepare(arguments: &ServeArguments, run_id: u64) -> Result<(Launch, ResultsFolder), String> {
    let mut launch = Launch::load(arguments.launch_file.as_deref(), None).map_err(|e| e.to_string())?;
    launch.open_to_hosts(arguments.insecure)?;
    if let Some(sweep) = &arguments.sweep {
        Sweep::load(sweep).map_err(|e| e.to_string())?;
    }
    preflight::check_shared_memory(&launch)?;
    let folder = ResultsFolder::prepare(arguments.out.as_deref(), &launch.name, run_id)?;
    std::fs::create_dir_all(&folder.path).map_err(|e| format!("{}: {e}", folder.path.display()))?;
    Ok((launch, folder))
}

fn serve(
    arguments: &ServeArguments,
    launch: &Launch,
    folder: &ResultsFolder,
    run_id: u64,
    tally: &mut Tally,
) -> Result<(), Abort> {
    domains::sweep();
    let own = OwnDomain::claim(run_id).map_err(Abort::Fatal)?;
    let log = start_log(&folder.path, run_id, arguments.shown, arguments.logged).map_err(Abort::Fatal)?;
    attach::announce(&own.place, launch, &folder.path).map_err(Abort::Fatal)?;
    let scenarios = match &arguments.sweep {
        Some(file) => vec!["--sweep".into(), file.display().to_string()],
        None => vec!["--requests".into()],
    };
    let post = plans::post_bridge(launch, &own.place.root, run_id, arguments.most_snapshots).map_err(Abort::Fatal)?;
    let draft = folder.draft.clone();
    let commands = Commands { launch, place: &own.place, run_id, draft, tape: None, scenarios, post };
    {
        let now = Instant::now();
        let mut run = Run::begin(commands, arguments.most_snapshots, None, arguments.shown, &log, || now)?;
        if arguments.sweep.is_none() {
            say!("serving as {run_id:012x}; ask with: phasecloud submit SCENARIO_FILE... (Ctrl-C ends)");
        }
        let completed = run.conduct(|scenario, failures| {
            let failures = of_scenario(failures, scenario);
            tally.failed += failures.len();
            tally.folders.push(publish(launch, folder, run_id, scenario, &failures)?);
            Ok(())
        });
        run.end();
        log.close();
        completed?;
    }
    if arguments.sweep.is_some() {
        join::join_all_tables(&tally.folders, &folder.path).map_err(|e| Abort::Fatal(e.to_string()))?;
    }
    Ok(())
}

/// Why cases failed in one scenario, by label.
fn of_scenario(failures: &Failures, scenario: u32) -> BTreeMap<String, String> {
    let here = failures.iter().filter(|((position, _), _)| *position == scenario);
    here.map(|((_, label), why)| (label.clone(), why.clone())).collect()
}

/// Makes a results folder of its own of what the recorder has written of a scenario.
fn publish(
    launch: &Launch,
    folder: &ResultsFolder,
    run_id: u64,
    scenario: u32,
    failures: &BTreeMap<String, String>,
) -> Result<PathBuf, String> {
    let draft = part(&folder.draft, scenario);
    let file = draft.join(SCENARIO);
    let content = scenario_file::load(&file).map_err(|e| e.to_string())?;
    let text = std::fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?;
    let path = folder.path.join(format!("{scenario:06}-{}", content.name));
    let kept = draft.join("scenarios");
    let moved =
        std::fs::create_dir(&kept).and_then(|()| std::fs::rename(&file, kept.join(format!("{}.toml", content.name))));
    moved.map_err(|e| format!("{}: {e}", kept.display()))?;
    let alone = Launch { scenarios: vec![ScenarioInput { text, content }], ..launch.clone() };
    let now = clock::seconds();
    let record = manifest::Record { run_id, started: now, nodes: &BTreeMap::new(), failures, incomplete: None };
    manifest::write(&draft, &alone, &record)?;
    manifest::seal(&draft)?;
    std::fs::rename(&draft, &path).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(path)
}

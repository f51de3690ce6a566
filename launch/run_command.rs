//! `phasecloud run`: from the launch file to the results folder.

use std::collections::BTreeMap;
use std::process::ExitCode;
use std::time::{Duration, Instant, SystemTime};

use nodes::recorder::join::join;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::BAD_INPUT;
use crate::cli::RunArguments;
use crate::commands::Commands;
use crate::domains::{self, OwnDomain};
use crate::launch_file::Launch;
use crate::results_folder::ResultsFolder;
use crate::run::{Abort, Failures, Run};
use crate::{manifest, preflight, report};

/// The user asked to stop.
pub const INTERRUPTED: u8 = 130;
/// Longest delay of a start in a random order.
const LONGEST_DELAY: Duration = Duration::from_millis(300);

/// Runs a launch file from start to results folder.
pub fn run(arguments: &RunArguments) -> ExitCode {
    let run_id = domains::fresh_run_id();
    let prepared = Launch::load(arguments.launch_file.as_deref(), arguments.scenario.as_deref())
        .map_err(|e| e.to_string())
        .and_then(|launch| {
            preflight::check_shared_memory(&launch)?;
            let folder = ResultsFolder::prepare(arguments.out.as_deref(), &launch.name, run_id)?;
            Ok((launch, folder))
        });
    let (launch, folder) = match prepared {
        Ok(prepared) => prepared,
        Err(problem) => {
            eprintln!("error: {problem}");
            return ExitCode::from(BAD_INPUT);
        }
    };
    match conduct(&launch, &folder, run_id, arguments) {
        Ok(failures) => {
            if !arguments.quiet {
                report::print(&launch, &folder.path);
                println!("\nResults: {}", folder.path.display());
            }
            for (name, why) in &failures {
                eprintln!("error: {name}: {why}");
            }
            if failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
        }
        Err(Abort::Interrupted) => {
            folder.discard();
            eprintln!("interrupted: nothing was written");
            ExitCode::from(INTERRUPTED)
        }
        Err(Abort::Fatal(problem)) => {
            folder.discard();
            eprintln!("error: {problem}; nothing was written");
            ExitCode::FAILURE
        }
        Err(Abort::Unpublished(problem)) => {
            eprintln!("error: {problem}");
            ExitCode::FAILURE
        }
    }
}

/// Conducts the run in a fresh domain, removes the domain, and publishes the results. Returns the failures by name.
fn conduct(
    launch: &Launch,
    folder: &ResultsFolder,
    run_id: u64,
    arguments: &RunArguments,
) -> Result<BTreeMap<String, String>, Abort> {
    let started = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    domains::sweep();
    let own = OwnDomain::claim(run_id).map_err(Abort::Fatal)?;
    let scenarios = folder.keep_scenarios(launch).map_err(Abort::Fatal)?;
    let scenarios = scenarios.iter().flat_map(|file| ["--scenario".into(), file.display().to_string()]).collect();
    let commands = Commands { launch, place: &own.place, run_id, draft: folder.draft.clone(), scenarios };
    let snapshots = launch.scenarios.iter().map(|s| s.content.problem.times.len()).max().unwrap_or(1);
    let (failures, nodes) = {
        let in_all = Some(launch.scenarios.len() as u32);
        let mut run = Run::begin(commands, snapshots, in_all, arguments.quiet, start_times(arguments.start_order))?;
        let completed = run.conduct(|_, _| Ok(()));
        let nodes = run.end();
        completed?;
        (by_name(launch, run.failures()), nodes)
    };
    drop(own);
    join(&folder.draft, launch.scenarios.len() as u32).map_err(|e| Abort::Fatal(e.to_string()))?;
    let written = manifest::write(&folder.draft, launch, run_id, started, &nodes, &failures);
    written.and_then(|()| folder.publish()).map_err(Abort::Unpublished)?;
    Ok(failures)
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

/// The failures as a user is told of them.
fn by_name(launch: &Launch, failures: &Failures) -> BTreeMap<String, String> {
    let name = |(scenario, label): &(u32, String)| match launch.scenarios.get(*scenario as usize) {
        Some(scenario) if launch.scenarios.len() > 1 => format!("{}, {label}", scenario.content.name),
        _ => label.clone(),
    };
    failures.iter().map(|(place, why)| (name(place), why.clone())).collect()
}

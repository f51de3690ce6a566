//! `phasecloud watch`: attaches to a live run and shows what `phasecloud run` shows there.

use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Args;
use kit::shard::{MOST_SHARDS, Shard};
use messages::layout::RosterEntry;
use messages::observe::Observer;
use messages::port::{Inlet, PortError};
use messages::report::{Event, Report};
use messages::reporter::Reporter;
use messages::text::unpack;
use messages::topic::{Roster, Scenario, Status};
use messages::wait::Signals;
use serde_json::json;

use super::web::{self, Feed, Server};
use super::{End, INTERRUPTED, TICK};
use crate::domain::attach::{self, LiveRun, Target};
use crate::domain::{self};
use crate::live::progress::{Progress, Stage};
use crate::live::{View, json as lines};
use crate::record::manifest::{self, Recorded};
use crate::report;
use crate::shown::Shown;

/// Reports that arrive within this time after attaching were sent before it.
const HISTORY: Duration = Duration::from_millis(1500);
/// How long the launcher may take to put the results where they belong after it has ended its processes.
const TIDYING: Duration = Duration::from_secs(10);

/// Arguments of `phasecloud watch`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phasecloud run launch/paper.toml --quiet & phasecloud watch\n  phasecloud watch --web"
)]
pub struct WatchArguments {
    #[command(flatten)]
    pub target: Target,
    /// Also serve a page on this machine that shows the run: its progress, and the report of the cases that have
    /// arrived
    #[arg(long)]
    pub web: bool,
    /// The port of the page [default: any free one]
    #[arg(long, requires = "web", default_value_t = 0, hide_default_value = true)]
    pub port: u16,
    #[command(flatten)]
    pub shown: Shown,
}

/// Watches a run until it ends, and prints its results. A page stays until the user ends it.
pub fn run(arguments: &WatchArguments) -> ExitCode {
    let found = attach::find(&arguments.target)
        .and_then(|run| Ok((run, arguments.web.then(|| Server::start(arguments.port)).transpose()?)));
    let (run, server) = match found {
        Ok(found) => found,
        Err(problem) => return super::fail(&problem, crate::exit::BAD_INPUT),
    };
    match watch(&run, arguments.shown, server.as_ref()) {
        Ok(End::Over) => {
            let code = conclude(&run, arguments.shown);
            if let Some(server) = &server {
                keep(&run, server);
            }
            code
        }
        outcome => super::exit(Ok(outcome)),
    }
}

/// Serves the report of the whole run until the user has seen enough.
fn keep(run: &LiveRun, server: &Server) {
    let report = run.notice.as_ref().and_then(|notice| web::page(&notice.results).ok());
    report.into_iter().for_each(|page| server.set_report(page));
    server.set_state(json!({"title": run.title(), "over": true}));
    remark!("the report stays at {} until this is ended with Ctrl-C", server.address());
    if let Ok(signals) = Signals::catch(&[]) {
        while !signals.stop_requested() && signals.wait(&[], TICK).is_ok() {}
    }
}

fn watch(run: &LiveRun, shown: Shown, server: Option<&Server>) -> Result<End, PortError> {
    let signals = Signals::catch(&[]).map_err(|e| PortError::new("catch", "signals", &e))?;
    let observer = Observer::enter(&run.place, "watch")?;
    let scenarios: Inlet<Scenario> = observer.inlet()?;
    let rosters: Inlet<Roster> = observer.inlet()?;
    let reports: Inlet<Status> = observer.inlet()?;
    let mut feed = server.map(|server| Feed::open(&observer, server, run.title())).transpose()?;
    if let Some(server) = server {
        remark!("{} is shown at {}", run.title(), server.address());
    }
    let attached = Instant::now();
    let mut stages: Vec<Stage> = Vec::new();
    let mut view: Option<View> = None;
    loop {
        let over = !domain::is_live(&run.place);
        while let Some(message) = scenarios.receive()? {
            let header = message.header();
            stages.push(Stage { name: unpack(&header.name), snapshots: header.snapshots.into() });
            if let Some(view) = &mut view {
                view.progress_mut().stages.clone_from(&stages);
            }
        }
        while let Some(message) = rosters.receive()? {
            let cases = message.items();
            let members = |entry: &RosterEntry| {
                let label = unpack(&entry.label);
                Shard::all(entry.shards.min(MOST_SHARDS)).map(move |shard| shard.process_of(&label))
            };
            let propagators = || cases.iter().flat_map(members).collect();
            let view = view.get_or_insert_with(|| View::new(Progress::new(propagators(), stages.clone()), shown));
            for entry in cases.iter().filter(|entry| entry.failed != 0) {
                view.progress_mut().fail(&Reporter::case(unpack(&entry.label)));
            }
        }
        // Reports wait in their buffer until a roster has said which cases there are.
        if let Some(view) = &mut view {
            while let Some(message) = reports.receive()? {
                let Ok(report) = Report::from_parts(message.header(), message.items()) else { continue };
                match &report.event {
                    Event::Failed { of, why } => view.fail(of, why),
                    _ => view.report(&report, attached.elapsed() < HISTORY),
                }
            }
            view.refresh();
        }
        if let Some(feed) = &mut feed {
            feed.update(view.as_ref().map(View::progress))?;
        }
        if signals.stop_requested() {
            return Ok(End::Stopped);
        }
        if over {
            drop(feed);
            drop((scenarios, rosters, reports, observer));
            domain::remove_remains(&run.place);
            return Ok(End::Over);
        }
        signals.wait(&[&scenarios, &rosters, &reports], TICK)?;
    }
}

/// Prints the results once they are where they belong.
fn conclude(run: &LiveRun, shown: Shown) -> ExitCode {
    let Some(notice) = &run.notice else { return ExitCode::SUCCESS };
    let ended = Instant::now();
    loop {
        if let Some(recorded) = manifest::read(&notice.results, &run.id()) {
            let exit_code = match recorded.incomplete {
                Some(_) => INTERRUPTED,
                None => u8::from(!recorded.failures.is_empty()),
            };
            print(&recorded, &notice.results, exit_code, shown);
            return ExitCode::from(exit_code);
        }
        if ended.elapsed() > TIDYING {
            return super::fail(&format!("{} has ended without results", run.title()), 1);
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn print(Recorded { launch, failures, incomplete }: &Recorded, results: &Path, exit_code: u8, shown: Shown) {
    if shown.json {
        lines::result(exit_code, results, failures, incomplete.as_deref());
    } else if !shown.quiet {
        report::print(launch, results);
        say!("\nResults: {}", results.display());
    }
    if let Some(why) = incomplete {
        remark!("interrupted: the results are not whole: {why}");
    }
}

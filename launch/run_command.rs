//! `phasecloud run`: starts every process of a run, looks after them, and ends them.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant, SystemTime};

use messages::domain::{HeldDomain, PREFIX_VARIABLE, Place, ROOT_VARIABLE};
use messages::layout::{RosterEntry, RosterHeader, phase};
use messages::port::{Inlet, Outlet, PortError};
use messages::text::{pack, unpack};
use messages::topic::{Capacity, Roster, Status};
use messages::wait::Signals;
use nodes::log;
use nodes::screen::{Refusal, screen};
use nodes::session::{LABEL_VARIABLE, LAUNCHER_VARIABLE, RUN_VARIABLE};
use tracing::level_filters::LevelFilter;

use crate::BAD_INPUT;
use crate::cli::RunArguments;
use crate::domains::{self, OwnDomain};
use crate::launch_file::{Case, Launch, Runs};
use crate::log_sink::{LogSink, View};
use crate::progress::Progress;
use crate::results_folder::ResultsFolder;
use crate::supervisor::Supervisor;
use crate::{ending, manifest, preflight, report};

/// The user asked to stop.
const INTERRUPTED: u8 = 130;
/// Longest that a process may take to report that it is ready.
const STARTUP: Duration = Duration::from_secs(60);
/// The launcher looks around at least this often.
const TICK: Duration = Duration::from_millis(500);
/// The processes that every run needs besides its cases.
const SERVICES: [&str; 3] = ["estimator", "comparator", "recorder"];

/// The process that publishes the scenarios.
const SCENARIO_NODE: &str = "scenario";

/// Why a run has no results.
enum Abort {
    /// The user asked to stop.
    Interrupted,
    /// Something that every case needs failed.
    Fatal(String),
    /// The run is complete, but its results could not be put where they belong.
    Unpublished(String),
}

impl From<PortError> for Abort {
    fn from(error: PortError) -> Self {
        Self::Fatal(error.to_string())
    }
}

/// Runs a launch file from start to results folder.
pub fn run(arguments: &RunArguments) -> ExitCode {
    let run_id = domains::fresh_run_id();
    let prepared = Launch::load(arguments.launch_file.as_deref(), arguments.scenario.as_deref())
        .map_err(|e| e.to_string())
        .and_then(|launch| {
            preflight::check_shared_memory(&launch)?;
            preflight::check_descriptors(launch.cases.len())?;
            let folder = ResultsFolder::prepare(arguments.out.as_deref(), &launch.name, run_id)?;
            let log = start_log(arguments, &folder, run_id).inspect_err(|_| folder.discard())?;
            Ok((launch, folder, log))
        });
    let (launch, folder, log) = match prepared {
        Ok(prepared) => prepared,
        Err(problem) => {
            eprintln!("error: {problem}");
            return ExitCode::from(BAD_INPUT);
        }
    };
    let outcome = conduct(&launch, &folder, run_id, arguments.quiet, &log);
    match outcome {
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

/// Opens the log of the run; the launcher's own lines go there too. The terminal shows errors unless more is asked for.
fn start_log(arguments: &RunArguments, folder: &ResultsFolder, run_id: u64) -> Result<LogSink, String> {
    let level = arguments.log.unwrap_or(LevelFilter::ERROR);
    let view = View { level, format: arguments.log_format, quiet: arguments.quiet };
    let sink = LogSink::open(&folder.draft, run_id, view)?;
    let (level, own) = (sink.level(), sink.clone());
    log::start("launcher", run_id, level, move |line| own.record(&line));
    Ok(sink)
}

/// Conducts the run in a fresh domain, removes the domain, and publishes the results. Returns the failures by name.
fn conduct(
    launch: &Launch,
    folder: &ResultsFolder,
    run_id: u64,
    quiet: bool,
    log: &LogSink,
) -> Result<BTreeMap<String, String>, Abort> {
    let started = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    domains::sweep();
    let own = OwnDomain::claim(run_id).map_err(Abort::Fatal)?;
    let (failures, nodes) = {
        let mut run = Run::begin(launch, folder, run_id, &own.place, quiet, log)?;
        let completed = run.conduct();
        let nodes = run.end();
        completed?;
        (run.failures.clone(), nodes)
    };
    drop(own);
    log.close();
    let written = manifest::write(&folder.draft, launch, run_id, started, &nodes, &failures);
    written.and_then(|()| folder.publish()).map_err(Abort::Unpublished)?;
    Ok(failures)
}

/// A run under way.
struct Run<'a> {
    launch: &'a Launch,
    folder: &'a ResultsFolder,
    run_id: u64,
    place: &'a Place,
    signals: Signals,
    // Processes end before the domain is closed: fields are dropped in this order.
    supervisor: Supervisor,
    reports: Inlet<Status>,
    roster: Outlet<Roster>,
    _domain: HeldDomain,
    progress: Progress,
    ready: BTreeMap<String, bool>,
    last_heard: BTreeMap<String, Instant>,
    unfinished: BTreeMap<String, bool>,
    failures: BTreeMap<String, String>,
    recorded: usize,
}

impl<'a> Run<'a> {
    fn begin(
        launch: &'a Launch,
        folder: &'a ResultsFolder,
        run_id: u64,
        place: &'a Place,
        quiet: bool,
        log: &LogSink,
    ) -> Result<Self, Abort> {
        let signals = Signals::catch(&[signal_hook::consts::SIGCHLD])
            .map_err(|e| Abort::Fatal(format!("cannot catch signals: {e}")))?;
        let snapshots = launch.scenarios.iter().map(|s| s.content.problem.times.len()).max().unwrap_or(1);
        let capacity = Capacity { propagators: launch.cases.len(), scenarios: launch.scenarios.len(), snapshots };
        let domain = HeldDomain::create(place, &capacity)?;
        let reports = domain.domain.inlet::<Status>()?;
        let roster = domain.domain.outlet::<Roster>(launch.cases.len())?;
        place.reserve().map_err(|e| Abort::Fatal(format!("cannot reserve shared memory: {e}")))?;
        let labels = || launch.cases.iter().map(|case| case.label.as_str());
        let names = || labels().chain(SERVICES).map(str::to_owned);
        let progress = Progress::new(labels(), quiet);
        log.print_with(progress.printer());
        Ok(Self {
            launch,
            folder,
            run_id,
            place,
            signals,
            supervisor: Supervisor::new(log.clone()),
            reports,
            roster,
            _domain: domain,
            progress,
            ready: names().map(|name| (name, false)).collect(),
            last_heard: names().map(|name| (name, Instant::now())).collect(),
            unfinished: labels().map(|label| (label.to_owned(), true)).collect(),
            failures: BTreeMap::new(),
            recorded: 0,
        })
    }

    /// From the start of the first process to the end of the recorder's work.
    fn conduct(&mut self) -> Result<(), Abort> {
        self.start_services()?;
        for case in &self.launch.cases {
            if let Err(why) = self.supervisor.start(&case.label, self.case_command(case)?) {
                self.fail(&case.label, why)?;
            }
        }
        let deadline = Instant::now() + STARTUP;
        while let Some(waiting) = self.not_ready() {
            if Instant::now() > deadline {
                self.fail(&waiting, format!("not ready within {} s", STARTUP.as_secs()))?;
                self.supervisor.kill(&waiting);
            }
            self.look_around()?;
        }
        let ready = self.ready.values().filter(|ready| **ready).count();
        self.progress.note(&format!("{ready} processes are ready"));
        self.publish_roster()?;
        self.hear_all_now();
        self.start_scenario_node()?;
        while self.recorded < self.launch.scenarios.len() {
            self.look_around()?;
            self.give_up_on_the_silent()?;
        }
        Ok(())
    }

    /// Starts everybody's patience anew.
    fn hear_all_now(&mut self) {
        for heard in self.last_heard.values_mut() {
            *heard = Instant::now();
        }
    }

    fn not_ready(&self) -> Option<String> {
        let waiting = self.ready.iter().find(|(name, ready)| !**ready && !self.failures.contains_key(*name));
        waiting.map(|(name, _)| name.clone())
    }

    /// Sleeps until something happens, and deals with it.
    fn look_around(&mut self) -> Result<(), Abort> {
        self.signals.wait(&[&self.reports, &self.roster], TICK)?;
        if self.signals.stop_requested() {
            return Err(Abort::Interrupted);
        }
        let ended = self.supervisor.newly_ended();
        // What a process said before it ended tells more than how it ended.
        self.take_reports()?;
        for (name, status) in ended {
            self.fail(&name, ending::explain(status))?;
        }
        Ok(())
    }

    /// Takes in the reports that have arrived.
    fn take_reports(&mut self) -> Result<(), Abort> {
        while let Some(report) = self.reports.receive()? {
            if let Err(Refusal { sender, why }) = screen(self.run_id, &report) {
                drop(report);
                self.blame(&sender, why)?;
                continue;
            }
            let header = *report.header();
            let units = [report.items().first(), report.items().get(1)].map(|u| u.copied().unwrap_or(0.0) as u64);
            drop(report);
            self.take_report(&header, units)?;
        }
        Ok(())
    }

    fn take_report(&mut self, header: &messages::layout::StatusHeader, [done, of]: [u64; 2]) -> Result<(), Abort> {
        let node = unpack(&header.node);
        self.last_heard.entry(node.clone()).and_modify(|heard| *heard = Instant::now());
        match header.phase {
            phase::READY => {
                self.ready.entry(node).and_modify(|ready| *ready = true);
            }
            phase::WORKING => {
                let scenario = self.launch.scenarios.get(header.scenario as usize);
                let name = scenario.map_or("", |s| &s.content.name);
                self.progress.working(&node, name, done, of);
                self.unfinished.entry(node).and_modify(|unfinished| *unfinished = done < of);
            }
            phase::DONE if node == "recorder" => {
                self.recorded += 1;
                if let Some(scenario) = self.launch.scenarios.get(header.scenario as usize) {
                    self.progress.note(&format!("{} is recorded", scenario.content.name));
                }
                for unfinished in self.unfinished.values_mut() {
                    *unfinished = true;
                }
                self.hear_all_now();
            }
            phase::DONE => {
                self.unfinished.entry(node).and_modify(|unfinished| *unfinished = false);
            }
            phase::FAILED => {
                let (subject, why) = (unpack(&header.subject), unpack(&header.text));
                match node == subject || self.unfinished.contains_key(&node) {
                    true => self.fail(&node, why)?, // a case speaks for itself alone
                    false => self.blame(&subject, why)?,
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Notes a failure. A case that fails is left out of the comparison; without a service there is no run.
    fn fail(&mut self, name: &str, why: String) -> Result<(), Abort> {
        if SERVICES.contains(&name) || name == SCENARIO_NODE {
            return Err(Abort::Fatal(format!("{name}: {why}")));
        }
        if !self.failures.contains_key(name) {
            self.progress.error(&format!("{name}: {why}"));
            tracing::warn!("{name} has failed: {why}");
            self.failures.insert(name.to_owned(), why);
            self.publish_roster()?;
        }
        Ok(())
    }

    /// Fails a case of which another process has complained, and ends it; a stranger is named.
    fn blame(&mut self, sender: &str, why: String) -> Result<(), Abort> {
        let name: String = sender.escape_debug().collect();
        self.fail(&name, why)?;
        self.supervisor.kill(&name);
        Ok(())
    }

    /// Fails the cases that owe work and have not been heard of for too long.
    fn give_up_on_the_silent(&mut self) -> Result<(), Abort> {
        let patience = Duration::from_secs_f64(self.launch.patience.min(1e9));
        let silent: Vec<String> = self
            .last_heard
            .iter()
            .filter(|(name, heard)| heard.elapsed() > patience && self.unfinished.get(*name) == Some(&true))
            .map(|(name, _)| name.clone())
            .filter(|name| !self.failures.contains_key(name))
            .collect();
        for name in silent {
            self.fail(&name, format!("no sign of life for {} s", self.launch.patience))?;
            self.supervisor.kill(&name);
        }
        if self.last_heard.values().all(|heard| heard.elapsed() > 2 * patience) {
            return Err(Abort::Fatal(format!("nothing has happened for {} s", 2.0 * self.launch.patience)));
        }
        Ok(())
    }

    fn publish_roster(&self) -> Result<(), Abort> {
        let header = RosterHeader { run_id: self.run_id, reference: pack(&self.launch.reference) };
        let entry = |case: &Case| RosterEntry {
            label: pack(&case.label),
            failed: u32::from(self.failures.contains_key(&case.label)),
            reserved: 0,
        };
        let entries: Vec<RosterEntry> = self.launch.cases.iter().map(entry).collect();
        Ok(self.roster.send_items(header, &entries)?)
    }

    fn start_services(&mut self) -> Result<(), Abort> {
        for name in SERVICES {
            let mut command = self.own_command(name)?;
            if name == "recorder" {
                command.arg("--out").arg(&self.folder.draft);
            }
            self.supervisor.start(name, command).map_err(Abort::Fatal)?;
        }
        Ok(())
    }

    /// Starts the scenario node last, when all others wait for the scenario. It reads copies of the scenario files, which
    /// stay in the results folder.
    fn start_scenario_node(&mut self) -> Result<(), Abort> {
        let folder = self.folder.draft.join("scenarios");
        let failed = |path: &Path, e: std::io::Error| Abort::Fatal(format!("{}: {e}", path.display()));
        std::fs::create_dir_all(&folder).map_err(|e| failed(&folder, e))?;
        let mut command = self.own_command(SCENARIO_NODE)?;
        command.args(["--bins", &self.launch.bins.0.to_string(), &self.launch.bins.1.to_string()]);
        for scenario in &self.launch.scenarios {
            let path = folder.join(format!("{}.toml", scenario.content.name));
            std::fs::write(&path, &scenario.text).map_err(|e| failed(&path, e))?;
            command.arg("--scenario").arg(path);
        }
        self.supervisor.start(SCENARIO_NODE, command).map_err(Abort::Fatal)
    }

    fn case_command(&self, case: &Case) -> Result<Command, Abort> {
        match &case.runs {
            Runs::BuiltIn { node, settings } => {
                let mut command = self.own_command(node)?;
                command.args(["--label", &case.label]).env(LABEL_VARIABLE, &case.label);
                for line in settings.to_lines().map_err(|e| Abort::Fatal(e.to_string()))? {
                    command.arg("--set").arg(line);
                }
                Ok(command)
            }
            Runs::Command(words) => {
                let (program, rest) =
                    words.split_first().ok_or_else(|| Abort::Fatal(format!("{} has no program", case.label)))?;
                let mut command = Command::new(program);
                command.args(rest);
                self.describe_run(&mut command);
                command.env(LABEL_VARIABLE, &case.label);
                Ok(command)
            }
        }
    }

    /// The command that runs one of our own nodes.
    fn own_command(&self, kind: &str) -> Result<Command, Abort> {
        let program = std::env::current_exe().map_err(|e| Abort::Fatal(format!("cannot find myself: {e}")))?;
        let mut command = Command::new(program);
        command.args(["node", kind, "--run-id", &self.run_id.to_string()]);
        self.describe_run(&mut command);
        Ok(command)
    }

    fn describe_run(&self, command: &mut Command) {
        command.env(ROOT_VARIABLE, &self.place.root).env(PREFIX_VARIABLE, &self.place.prefix);
        command.env(RUN_VARIABLE, self.run_id.to_string()).env_remove(LABEL_VARIABLE);
        command.env(LAUNCHER_VARIABLE, std::process::id().to_string());
    }

    /// Ends all processes and says how each ended.
    fn end(&mut self) -> BTreeMap<String, String> {
        self.supervisor.stop_all().into_iter().map(|(name, status)| (name, status.to_string())).collect()
    }
}

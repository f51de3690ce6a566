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
use nodes::session::{LABEL_VARIABLE, LAUNCHER_VARIABLE, RUN_VARIABLE};

use crate::BAD_INPUT;
use crate::cli::{RunArguments, Shown};
use crate::domains::{self, OwnDomain};
use crate::launch_file::{Case, Launch, Runs, ScenarioInput};
use crate::live::model::{Model, Stage};
use crate::live::{View, json};
use crate::recording::Draft;
use crate::results_folder::ResultsFolder;
use crate::supervisor::Supervisor;
use crate::{attach, manifest, preflight, report};

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

/// How a run is to be done.
#[derive(Debug)]
pub struct Order<'a> {
    /// The results folder, if one is named.
    pub out: Option<&'a Path>,
    /// Where to keep every message, if anywhere.
    pub record: Option<&'a Path>,
    /// How much is said of it.
    pub shown: Shown,
}

/// Runs a launch file from start to results folder.
pub fn run(arguments: &RunArguments) -> ExitCode {
    let launch = Launch::load(arguments.launch_file.as_deref(), arguments.scenario.as_deref());
    let (out, record) = (arguments.out.as_deref(), arguments.record.as_deref());
    execute(launch.map_err(|e| e.to_string()), &Order { out, record, shown: arguments.shown })
}

/// Runs what has been read, or says why that could not be read.
pub fn execute(launch: Result<Launch, String>, order: &Order<'_>) -> ExitCode {
    let run_id = domains::fresh_run_id();
    let prepared = launch.and_then(|launch| {
        preflight::check_shared_memory(&launch)?;
        let folder = ResultsFolder::prepare(order.out, &launch.name, run_id)?;
        let tape = order.record.map(|path| Draft::begin(path, &launch, run_id)).transpose();
        let tape = tape.inspect_err(|_| folder.discard())?;
        Ok((launch, folder, tape))
    });
    let (launch, folder, tape) = match prepared {
        Ok(prepared) => prepared,
        Err(problem) => return end_without_results(order, BAD_INPUT, &format!("error: {problem}")),
    };
    let tape_path = tape.as_ref().map(|tape| tape.draft.as_path());
    let outcome = conduct(&launch, &folder, tape_path, run_id, order.shown);
    let outcome = match tape {
        Some(tape) if matches!(outcome, Err(Abort::Interrupted | Abort::Fatal(_))) => {
            tape.discard();
            outcome
        }
        Some(tape) => tape.publish().map_err(Abort::Unpublished).and(outcome),
        None => outcome,
    };
    match outcome {
        Ok(failures) => {
            let exit_code = u8::from(!failures.is_empty());
            if order.shown.json {
                json::result(exit_code, &folder.path, &failures);
            } else if !order.shown.quiet {
                report::print(&launch, &folder.path);
                println!("\nResults: {}", folder.path.display());
            }
            for (name, why) in &failures {
                eprintln!("error: {name}: {why}");
            }
            ExitCode::from(exit_code)
        }
        Err(Abort::Interrupted) => {
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

fn end_without_results(order: &Order<'_>, exit_code: u8, problem: &str) -> ExitCode {
    if order.shown.json {
        json::no_result(exit_code, problem);
    }
    eprintln!("{problem}");
    ExitCode::from(exit_code)
}

/// Conducts the run in a fresh domain, removes the domain, and publishes the results. Returns the failures by name.
fn conduct(
    launch: &Launch,
    folder: &ResultsFolder,
    tape: Option<&Path>,
    run_id: u64,
    shown: Shown,
) -> Result<BTreeMap<String, String>, Abort> {
    let started = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    domains::sweep();
    let own = OwnDomain::claim(run_id).map_err(Abort::Fatal)?;
    attach::announce(&own.place, launch, &folder.path).map_err(Abort::Fatal)?;
    let (failures, nodes) = {
        let mut run = Run::begin(launch, folder, tape, run_id, &own.place, shown)?;
        let completed = run.conduct();
        let nodes = run.end();
        completed?;
        (run.failures.clone(), nodes)
    };
    drop(own);
    let written = manifest::write(&folder.draft, launch, run_id, started, &nodes, &failures);
    written.and_then(|()| folder.publish()).map_err(Abort::Unpublished)?;
    Ok(failures)
}

/// A run under way.
struct Run<'a> {
    launch: &'a Launch,
    folder: &'a ResultsFolder,
    tape: Option<&'a Path>,
    run_id: u64,
    place: &'a Place,
    signals: Signals,
    // Processes end before the domain is closed: fields are dropped in this order.
    supervisor: Supervisor,
    reports: Inlet<Status>,
    roster: Outlet<Roster>,
    _domain: HeldDomain,
    view: View,
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
        tape: Option<&'a Path>,
        run_id: u64,
        place: &'a Place,
        shown: Shown,
    ) -> Result<Self, Abort> {
        let signals = Signals::catch(&[signal_hook::consts::SIGCHLD])
            .map_err(|e| Abort::Fatal(format!("cannot catch signals: {e}")))?;
        let snapshots = launch.scenarios.iter().map(|s| s.content.problem.times.len()).max().unwrap_or(1);
        let capacity = Capacity { propagators: launch.cases.len(), scenarios: launch.scenarios.len(), snapshots };
        let domain = HeldDomain::create(place, &capacity)?;
        let labels = || launch.cases.iter().map(|case| case.label.as_str());
        let names = || labels().chain(SERVICES).map(str::to_owned);
        Ok(Self {
            launch,
            folder,
            tape,
            run_id,
            place,
            signals,
            supervisor: Supervisor::default(),
            reports: domain.domain.inlet::<Status>()?,
            roster: domain.domain.outlet::<Roster>(launch.cases.len())?,
            _domain: domain,
            view: View::new(Model::new(labels().map(str::to_owned).collect(), stages(launch)), shown),
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
            if let Err(why) = self.supervisor.start(&case.label, self.command(&case.label, &case.runs)?) {
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
        self.view.note(&format!("{ready} processes are ready"));
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
        self.view.refresh();
        let ended = self.supervisor.newly_ended();
        // What a process said before it ended tells more than how it ended.
        self.take_reports()?;
        for (name, status) in ended {
            self.fail(&name, format!("ended before the run did: {status}"))?;
        }
        Ok(())
    }

    /// Takes in the reports that have arrived.
    fn take_reports(&mut self) -> Result<(), Abort> {
        while let Some(report) = self.reports.receive()? {
            let header = *report.header();
            let units = [report.items().first(), report.items().get(1)].map(|u| u.copied().unwrap_or(0.0) as u64);
            drop(report);
            if header.run_id == self.run_id {
                self.take_report(&header, units)?;
            }
        }
        Ok(())
    }

    fn take_report(&mut self, header: &messages::layout::StatusHeader, [done, of]: [u64; 2]) -> Result<(), Abort> {
        let node = unpack(&header.node);
        self.last_heard.insert(node.clone(), Instant::now());
        if header.phase != phase::FAILED {
            self.view.report(header, [done, of], false);
        }
        match header.phase {
            phase::READY => {
                self.ready.insert(node, true);
            }
            phase::WORKING => {
                self.unfinished.entry(node).and_modify(|unfinished| *unfinished = done < of);
            }
            phase::DONE if node == "recorder" => {
                self.recorded += 1;
                if let Some(scenario) = self.launch.scenarios.get(header.scenario as usize) {
                    self.view.note(&format!("{} is recorded", scenario.content.name));
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
                let subject = unpack(&header.subject);
                let blamed = if self.is_known(&subject) || !self.is_known(&node) { subject } else { node };
                self.fail(&blamed, unpack(&header.text))?;
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
            self.view.fail(name, &why);
            self.failures.insert(name.to_owned(), why);
            self.publish_roster()?;
        }
        Ok(())
    }

    /// Whether `name` is a process of the run.
    fn is_known(&self, name: &str) -> bool {
        name == SCENARIO_NODE || self.ready.contains_key(name)
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
            let mut command = match self.launch.substitutes.get(name) {
                Some(runs) => self.command(name, runs)?,
                None => self.own_command(name)?,
            };
            if name == "recorder" {
                command.arg("--out").arg(&self.folder.draft);
                command.args(self.tape.iter().flat_map(|tape| [Path::new("--recording"), tape]));
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

    /// The command that runs something under a name.
    fn command(&self, name: &str, runs: &Runs) -> Result<Command, Abort> {
        match runs {
            Runs::BuiltIn { node, settings } => {
                let mut command = self.own_command(node)?;
                command.args(["--label", name]);
                for line in settings.to_lines().map_err(|e| Abort::Fatal(e.to_string()))? {
                    command.arg("--set").arg(line);
                }
                Ok(command)
            }
            Runs::Recorded(file) => {
                let mut command = self.own_command("player")?;
                command.args(["--label", name, "--recording"]).arg(file);
                Ok(command)
            }
            Runs::Command(words) => {
                let mut command = Command::new(&words[0]);
                command.args(&words[1..]);
                self.describe_run(&mut command);
                command.env(LABEL_VARIABLE, name);
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
        command.env(RUN_VARIABLE, self.run_id.to_string());
        command.env(LAUNCHER_VARIABLE, std::process::id().to_string());
    }

    /// Ends all processes and says how each ended.
    fn end(&mut self) -> BTreeMap<String, String> {
        self.supervisor.stop_all().into_iter().map(|(name, status)| (name, status.to_string())).collect()
    }
}

/// The scenarios as far as progress goes.
fn stages(launch: &Launch) -> Vec<Stage> {
    let stage =
        |s: &ScenarioInput| Stage { name: s.content.name.clone(), snapshots: s.content.problem.times.len() as u64 };
    launch.scenarios.iter().map(stage).collect()
}

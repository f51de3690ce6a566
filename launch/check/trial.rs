//! One propagator's process in one fresh domain: started, asked, listened to, stopped.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::{Command, ExitStatus};
use std::time::{Duration, Instant};

use density::orbits::LostOrbit;
use kit::assignment::Assignment;
use kit::environment::{GRACE_VARIABLE, LABEL_VARIABLE, LAUNCHER_VARIABLE, REDUCE_VARIABLE, RUN_VARIABLE};
use kit::shard::{SHARD_VARIABLE, SHARDS_VARIABLE};
use messages::domain::{HeldDomain, PREFIX_VARIABLE, Place, ROOT_VARIABLE};
use messages::patience::Watch;
use messages::port::{Inlet, Outlet, PortError};
use messages::report::{Event, Report};
use messages::topic::{self, Capacity};
use messages::wait::{Awaited, Signals};

use super::answer::{Answer, Heard, LABEL, Outcome, Ready, Received, Stop, end_of, is_from};
use super::scenarios::{LONGEST, Scenario};
use crate::crew::supervisor::Supervisor;
use crate::domain::{OwnDomain, fresh_run_id};

/// Scenarios that one process is given at most.
const SCENARIOS: usize = 2;
/// How often a process that was asked to end is looked at.
const TICK: Duration = Duration::from_millis(5);
/// Longest sleep while waiting for messages.
const LONGEST_SLEEP: Duration = Duration::from_millis(200);

/// How long a propagator may take.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// The longest time without any sign of life.
    pub patience: Duration,
    /// The longest time from SIGTERM to its end.
    pub grace: Duration,
}

/// Why there are no findings.
#[derive(Debug)]
pub enum Abort {
    /// The user asked to stop.
    Interrupted,
    /// The command cannot be started.
    NotStarted(String),
    /// Something of our own failed.
    Fatal(String),
}

impl From<PortError> for Abort {
    fn from(error: PortError) -> Self {
        Self::Fatal(error.to_string())
    }
}

impl From<LostOrbit> for Abort {
    fn from(error: LostOrbit) -> Self {
        Self::Fatal(error.to_string())
    }
}

/// The ends of the topics that scenario node, estimator, recorder and launcher have in a run.
struct Ports {
    reports: Inlet<topic::Status>,
    snapshots: Inlet<topic::Snapshot>,
    passages: Inlet<topic::Passage>,
    scenarios: Outlet<topic::Scenario>,
}

/// A process under trial.
pub struct Trial<'a> {
    // Dropped in this order: the process ends before the domain is closed and removed.
    supervisor: Supervisor,
    ports: Option<Ports>,
    _held: HeldDomain,
    own: OwnDomain,
    signals: &'a Signals,
    limits: Limits,
    run_id: u64,
    asked: u32,
    ended: Option<ExitStatus>,
    files_before: BTreeSet<PathBuf>,
}

impl<'a> Trial<'a> {
    /// Starts a process.
    ///
    /// # Errors
    /// [`Abort`].
    pub fn start(command: &[String], signals: &'a Signals, limits: &Limits) -> Result<Self, Abort> {
        let run_id = fresh_run_id();
        let own = OwnDomain::claim(run_id).map_err(Abort::NotStarted)?;
        let capacity = Capacity { propagators: 1, cases: 1, snapshots: LONGEST, hosts: 0 };
        let held = HeldDomain::create(&own.place, &capacity)?;
        let ports = Ports {
            reports: held.domain.inlet()?,
            snapshots: held.domain.inlet()?,
            passages: held.domain.inlet()?,
            scenarios: held.domain.outlet(Assignment::numbers(LONGEST))?,
        };
        let files_before = files_of(&own.place);
        let (program, words) = command.split_first().ok_or_else(|| Abort::NotStarted("there is no command".into()))?;
        let mut process = Command::new(program);
        process.args(words).env(ROOT_VARIABLE, &own.place.root).env(PREFIX_VARIABLE, &own.place.prefix);
        process.env_remove(SHARD_VARIABLE).env_remove(SHARDS_VARIABLE).env_remove(REDUCE_VARIABLE);
        // Nobody cleans up after the process, so it may go on computing for most of its time to end, also on a busy
        // machine.
        process.env(GRACE_VARIABLE, (0.9 * limits.grace.as_secs_f64()).to_string());
        process.env(LABEL_VARIABLE, LABEL).env(RUN_VARIABLE, run_id.to_string());
        process.env(LAUNCHER_VARIABLE, std::process::id().to_string());
        let mut supervisor = Supervisor::default();
        supervisor.start(LABEL, process).map_err(Abort::NotStarted)?;
        let (ports, limits) = (Some(ports), *limits);
        Ok(Self { supervisor, ports, _held: held, own, signals, limits, run_id, asked: 0, ended: None, files_before })
    }

    /// Waits until the process reports that it is ready.
    ///
    /// # Errors
    /// [`Abort`].
    pub fn wait_until_ready(&mut self) -> Result<Ready, Abort> {
        let (started, run_id) = (Instant::now(), self.run_id);
        let mut heard = Heard::default();
        let is_ready = |signed: &(u64, Report)| signed.1.event == Event::Ready && is_from(signed, run_id);
        let outcome = self.listen(&mut heard, |heard| heard.reports.iter().any(is_ready).then_some(Outcome::Done))?;
        Ok(Ready { run_id, heard, outcome, after: started.elapsed() })
    }

    /// Gives the propagator a scenario and listens until it is done or has failed.
    ///
    /// # Errors
    /// [`Abort`].
    pub fn ask(&mut self, scenario: Result<Scenario, LostOrbit>) -> Result<Answer, Abort> {
        let assignment = self.send(scenario?)?;
        let mut heard = Heard::default();
        let outcome = self.listen(&mut heard, |heard| end_of(&assignment, heard))?;
        Ok(Answer { assignment, heard, outcome })
    }

    /// Gives the propagator a scenario and listens until it has sent its first snapshot, or nothing more is to be
    /// expected.
    ///
    /// # Errors
    /// [`Abort`].
    pub fn ask_for_the_first_snapshot(&mut self, scenario: Result<Scenario, LostOrbit>) -> Result<Answer, Abort> {
        let assignment = self.send(scenario?)?;
        let mut heard = Heard::default();
        let outcome = self.listen(&mut heard, |heard| {
            let first = (!heard.snapshots.is_empty()).then_some(Outcome::Done);
            first.or_else(|| end_of(&assignment, heard))
        })?;
        Ok(Answer { assignment, heard, outcome })
    }

    fn send(&mut self, scenario: Scenario) -> Result<Assignment, Abort> {
        let assignment = scenario.assignment(self.run_id, (self.asked, SCENARIOS as u32));
        self.asked += 1;
        let (header, items) = assignment.to_parts().map_err(|error| Abort::Fatal(error.to_string()))?;
        if let Some(ports) = &self.ports {
            ports.scenarios.send_items(header, &items)?;
        }
        Ok(assignment)
    }

    /// Takes in what arrives until `end` returns an outcome, the process ends, or it has been silent for too long.
    fn listen(&mut self, heard: &mut Heard, end: impl Fn(&Heard) -> Option<Outcome>) -> Result<Outcome, Abort> {
        let Some(ports) = &self.ports else { return Ok(Outcome::Silent(Duration::ZERO)) };
        let mut watch = Watch::start();
        let mut last_heard = Duration::ZERO;
        loop {
            let ends = self.supervisor.newly_ended();
            self.ended = self.ended.or(ends.first().map(|ended| ended.status));
            // The messages that a process sent before it ended say more than how it ended.
            let known = heard.len();
            ports.receive(heard)?;
            if heard.len() > known {
                last_heard = watch.elapsed();
            }
            if let Some(outcome) = end(heard) {
                return Ok(outcome);
            }
            if let Some(status) = self.ended {
                return Ok(Outcome::Ended(status));
            }
            if watch.elapsed() - last_heard > self.limits.patience {
                return Ok(Outcome::Silent(self.limits.patience));
            }
            let awaited: [&dyn Awaited; 4] = [&ports.reports, &ports.snapshots, &ports.passages, &ports.scenarios];
            self.signals.wait(&awaited, LONGEST_SLEEP)?;
            if self.signals.stop_requested() {
                return Err(Abort::Interrupted);
            }
        }
    }

    /// Asks the process to end and waits at most as long as it may take; the trial is then over.
    ///
    /// # Errors
    /// [`Abort`].
    pub fn stop(&mut self) -> Result<Stop, Abort> {
        self.supervisor.ask_to_end();
        let asked = Instant::now();
        while self.ended.is_none() && asked.elapsed() < self.limits.grace {
            self.signals.wait(&[], TICK)?;
            if self.signals.stop_requested() {
                return Err(Abort::Interrupted);
            }
            self.ended = self.supervisor.newly_ended().first().map(|ended| ended.status);
        }
        let after = asked.elapsed();
        let left_others = self.supervisor.left_others();
        self.ports = None; // the other ends of its connections
        let files = files_of(&self.own.place).difference(&self.files_before).cloned().collect();
        Ok(Stop { status: self.ended, after, left_others, files })
    }
}

impl Ports {
    fn receive(&self, heard: &mut Heard) -> Result<(), PortError> {
        while let Some(message) = self.reports.receive()? {
            if let Ok(report) = Report::from_parts(message.header(), message.items()) {
                heard.reports.push((message.header().run_id, report));
            }
        }
        while let Some(message) = self.snapshots.receive()? {
            heard.snapshots.push(Received { header: *message.header(), items: message.items().to_vec() });
        }
        while let Some(message) = self.passages.receive()? {
            heard.passages.push(Received { header: *message.header(), items: message.items().to_vec() });
        }
        Ok(())
    }
}

/// All files of a domain.
fn files_of(place: &Place) -> BTreeSet<PathBuf> {
    let shared = std::fs::read_dir("/dev/shm").into_iter().flatten().flatten();
    let ours = shared.filter(|entry| entry.file_name().to_string_lossy().starts_with(&place.prefix));
    let mut files: BTreeSet<PathBuf> = ours.map(|entry| entry.path()).collect();
    let mut folders = vec![place.root.clone()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                folders.push(entry.path());
            } else {
                files.insert(entry.path());
            }
        }
    }
    files
}

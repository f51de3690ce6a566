//! A node's access to a run: its name, the run's domain, its reports to the launcher, and its signals.

use std::cell::Cell;
use std::time::{Duration, Instant};

use messages::domain::{Domain, Place, ROOT_VARIABLE};
use messages::port::Outlet;
use messages::report::{Event, Report};
use messages::reporter::Reporter;
use messages::topic::Status;
use messages::wait::{Awaited, Signals};
use rustix::process::{Signal, set_parent_process_death_signal};
use rustix::time::{ClockId, clock_gettime};

use crate::environment::{
    ATTEMPT_VARIABLE, GRACE_VARIABLE, LABEL_VARIABLE, LAUNCHER_VARIABLE, REDUCE_VARIABLE, RUN_VARIABLE,
};
use crate::failure::Failure;
use crate::log;
use crate::refusals::ReportedRefusals;
use crate::shard::Shard;
use crate::threads;

/// Longest time that a node sleeps before it checks its ports, in case a wake-up was missed.
const LONGEST_SLEEP: Duration = Duration::from_secs(1);

/// How long a node that was asked to stop may go on computing, if the environment does not say it: after this time the
/// node ends in the middle of its work, and leaves its files to the launcher.
const GRACE: Duration = Duration::from_secs(1);

/// The scenario in the report of a failure that belongs to no particular scenario.
pub const ANY_SCENARIO: u32 = u32::MAX;

/// A node's access to a run.
#[derive(Debug)]
pub struct Session {
    /// The node's name. The name of a propagator is its label, that of a shard is the label with the shard's number.
    pub name: String,
    /// The label of a propagator; for other nodes the name.
    pub label: String,
    /// The node as its reports name it.
    pub reporter: Reporter,
    /// Which part of its case a propagator computes.
    pub shard: Shard,
    /// Whether a propagator is to reduce its samples before it sends them.
    pub reduce: bool,
    /// Names the run.
    pub run_id: u64,
    /// How often the launcher has restarted this node.
    pub attempt: u32,
    /// The run's domain.
    pub domain: Domain,
    launcher: Option<i32>,
    launcher_seen: Cell<Instant>,
    signals: Signals,
    status: Outlet<Status>,
    pub(crate) reported_refusals: ReportedRefusals,
}

impl Session {
    /// Enters the run that the environment describes, as the launcher has set it for a propagator.
    ///
    /// # Errors
    /// [`Failure::Refused`] if a variable is missing, and as [`Session::enter`].
    pub fn from_environment() -> Result<Self, Failure> {
        let missing = |name: &str| Failure::Refused(format!("{name} is not set; the launcher of a run sets it"));
        let place = Place::from_environment().ok_or_else(|| missing(ROOT_VARIABLE))?;
        let label = std::env::var(LABEL_VARIABLE).map_err(|_| missing(LABEL_VARIABLE))?;
        let run_id = std::env::var(RUN_VARIABLE).ok().and_then(|text| text.parse().ok());
        Self::enter(&place, &label, run_id.ok_or_else(|| missing(RUN_VARIABLE))?)
    }

    /// Enters the domain at `place` as the propagator `label` (or the shard of it that the environment names), or as
    /// another node of that name. From then on SIGINT and SIGTERM ask the node to stop, and so does the end of the
    /// launcher, if one started it.
    ///
    /// # Errors
    /// [`Failure::Port`] if the domain cannot be used, [`Failure::Refused`] if the environment names no valid shard.
    pub fn enter(place: &Place, label: &str, run_id: u64) -> Result<Self, Failure> {
        let shard = Shard::from_environment()?;
        Self::enter_as(place, label, shard, run_id)
    }

    /// Enters the run like [`Session::enter`], as one shard of a case.
    ///
    /// # Errors
    /// The same as those of [`Session::enter`].
    pub fn enter_as(place: &Place, label: &str, shard: Shard, run_id: u64) -> Result<Self, Failure> {
        let reporter = Reporter::started_as(label, shard.number());
        let name = reporter.to_string();
        log::start_from_environment(&name, run_id);
        threads::prepare();
        end_with_launcher()?;
        let refused = |e: std::io::Error| Failure::Refused(format!("cannot catch signals: {e}"));
        // A node that a launcher started ends with the launcher. Like the launcher it outlives the terminal.
        let signals = if launcher().is_some() { Signals::outlive_terminal(&[]) } else { Signals::catch(&[]) };
        let signals = signals.map_err(refused)?;
        signals.end_process_after(grace()).map_err(refused)?;
        let domain = Domain::enter(place, &name)?;
        let status = domain.outlet::<Status>(2)?;
        let attempt = std::env::var(ATTEMPT_VARIABLE).ok().and_then(|text| text.parse().ok()).unwrap_or(0);
        Ok(Self {
            name,
            label: label.into(),
            reporter,
            shard,
            reduce: std::env::var(REDUCE_VARIABLE).is_ok_and(|value| value == "1"),
            run_id,
            attempt,
            domain,
            launcher: launcher(),
            launcher_seen: Cell::new(Instant::now()),
            signals,
            status,
            reported_refusals: ReportedRefusals::default(),
        })
    }

    /// Reports to all readers of the status topic what has happened in the scenario at position `scenario` in the
    /// run.
    ///
    /// # Errors
    /// [`Failure::Port`] if the message cannot be sent.
    pub fn report(&self, scenario: u32, event: Event) -> Result<(), Failure> {
        log::report(scenario, &event);
        let (header, units) = Report { from: self.reporter.clone(), scenario, event }.to_parts(self.run_id);
        Ok(self.status.send_items(header, &units)?)
    }

    /// Reports that the node waits for work.
    ///
    /// # Errors
    /// The same as those of [`Session::report`].
    pub fn ready(&self) -> Result<(), Failure> {
        self.report(0, Event::Ready)
    }

    /// Reports how much of the scenario's work is done; `of` is 0 if that is not known.
    ///
    /// # Errors
    /// The same as those of [`Session::report`].
    pub fn working(&self, scenario: u32, done: usize, of: usize) -> Result<(), Failure> {
        self.report(scenario, Event::Progress { done: done as u64, of: of as u64 })
    }

    /// Reports that the node, after `done` units of work, cannot go on without `what` from a case.
    ///
    /// # Errors
    /// The same as those of [`Session::report`].
    pub fn waits_for(&self, scenario: u32, case: &str, what: &str, done: usize) -> Result<(), Failure> {
        self.report(scenario, Event::WaitsFor { case: case.into(), what: what.into(), done: done as u64 })
    }

    /// Reports that the node has finished a scenario.
    ///
    /// # Errors
    /// The same as those of [`Session::report`].
    pub fn done(&self, scenario: u32) -> Result<(), Failure> {
        self.report(scenario, Event::Done)
    }

    /// Reports that the node itself cannot go on, and why.
    ///
    /// # Errors
    /// The same as those of [`Session::report`].
    pub fn failed(&self, scenario: u32, why: &str) -> Result<(), Failure> {
        self.report(scenario, Event::Failed { of: self.reporter.clone(), why: why.into() })
    }

    /// Reports that a case cannot be completed, and why.
    ///
    /// # Errors
    /// The same as those of [`Session::report`].
    pub fn case_failed(&self, scenario: u32, case: &str, why: &str) -> Result<(), Failure> {
        self.report(scenario, Event::Failed { of: Reporter::case(case), why: why.into() })
    }

    /// Reports why the node ends, and leaves its ports to the holder of the domain, who frees them once it has read the
    /// report: a message of a publisher that closes its port is lost to a reader that has not yet connected to it.
    pub fn last_words(self, why: &str) {
        // Where even that cannot be sent, the launcher still sees that the process ended.
        let _ = self.failed(ANY_SCENARIO, why);
        std::mem::forget(self);
    }

    /// Sleeps until something happens on one of the ports.
    ///
    /// # Errors
    /// [`Failure::Stopped`] if the node has been asked to stop.
    pub fn wait(&self, ports: &[&dyn Awaited]) -> Result<(), Failure> {
        // Readers that come late must also get the reports.
        let ports: Vec<&dyn Awaited> = ports.iter().copied().chain([&self.status as &dyn Awaited]).collect();
        self.signals.wait(&ports, LONGEST_SLEEP)?;
        self.check_launcher()?;
        self.check_stop()
    }

    /// For nodes that wait for something else: delivers earlier reports to late readers.
    ///
    /// # Errors
    /// [`Failure::Stopped`] if the node has been asked to stop, or its launcher is gone.
    pub fn look_up(&self) -> Result<(), Failure> {
        self.status.attend();
        self.check_launcher()?;
        self.check_stop()
    }

    /// Checks, at most once per second, whether the launcher is alive.
    fn check_launcher(&self) -> Result<(), Failure> {
        if self.launcher_seen.get().elapsed() >= LONGEST_SLEEP {
            if self.launcher.is_some_and(|launcher| !is_alive(launcher)) {
                return Err(Failure::Stopped);
            }
            self.launcher_seen.set(Instant::now());
        }
        Ok(())
    }

    /// Checks whether the node has been asked to stop.
    ///
    /// # Errors
    /// [`Failure::Stopped`] if the node has been asked to stop.
    pub fn check_stop(&self) -> Result<(), Failure> {
        if self.signals.stop_requested() { Err(Failure::Stopped) } else { Ok(()) }
    }
}

/// How long the node may go on computing once it has been asked to stop.
fn grace() -> Duration {
    let seconds = std::env::var(GRACE_VARIABLE).ok().and_then(|text| text.parse().ok());
    let seconds = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    seconds.unwrap_or(GRACE)
}

/// The launcher that started this process, if one did.
fn launcher() -> Option<i32> {
    std::env::var(LAUNCHER_VARIABLE).ok()?.parse().ok()
}

/// Whether the launcher that started this process is alive; true if none did.
pub fn has_launcher() -> bool {
    launcher().is_none_or(is_alive)
}

/// Asks the kernel to stop this process should its launcher die, if a launcher started it.
///
/// # Errors
/// [`Failure::Stopped`] if the launcher is dead already.
pub fn end_with_launcher() -> Result<(), Failure> {
    let Some(launcher) = launcher() else { return Ok(()) };
    set_parent_process_death_signal(Some(Signal::TERM))
        .map_err(|e| Failure::Refused(format!("cannot follow the launcher: {e}")))?;
    // The launcher may have died before the kernel was asked. A parent between the launcher and this process is no
    // reason to end.
    if is_alive(launcher) { Ok(()) } else { Err(Failure::Stopped) }
}

/// Whether a process is alive, and not one that has ended but has not been reaped by its parent.
fn is_alive(process: i32) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    // The state follows the name, which is in brackets and may contain anything.
    stat.rsplit_once(") ").is_some_and(|(_, rest)| !rest.starts_with(['Z', 'X']))
}

/// Measures the CPU time that this process, all threads together, spends on something \[s\].
#[derive(Debug, Clone, Copy)]
pub struct EffortClock(f64);

impl EffortClock {
    /// Starts now.
    pub fn start() -> Self {
        Self(cpu_seconds())
    }

    /// CPU time since the start \[s\].
    pub fn seconds(self) -> f64 {
        cpu_seconds() - self.0
    }
}

fn cpu_seconds() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

//! A run under way: its processes are started, looked after, restarted where that helps, and ended.

mod arrivals;
mod budget;
mod closing;
mod failing;
mod patience;
mod reports;

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

use kit::screen::{Refusal, screen};
use messages::domain::HeldDomain;
use messages::layout::{RosterEntry, RosterHeader};
use messages::patience::Watch;
use messages::port::{Inlet, Outlet, PortError};
use messages::report::Report;
use messages::service::Service;
use messages::text::{pack, unpack};
use messages::topic::{Capacity, Roster, Scenario, Status};
use messages::wait::Signals;

use crate::crew::commands::Commands;
use crate::crew::log_sink::LogSink;
use crate::crew::member::Member;
use crate::crew::supervisor::{Ended, Supervisor};
use crate::live::View;
use crate::live::model::{Model, Stage};
use crate::plan::cases::Case;
use crate::plan::launch_file::{Launch, ScenarioInput};
use crate::shown::Shown;

/// The launcher looks around at least this often.
const TICK: Duration = Duration::from_millis(500);

/// Why a run has no results.
pub enum Abort {
    /// The user asked to stop: what has been recorded may be kept.
    Stopped,
    /// The user asked to stop for good: nothing is kept.
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

/// What went wrong: by the scenario's position and the label of the case, why the case has no results there.
pub type Failures = BTreeMap<(u32, String), String>;

/// A scenario that has been published.
struct UnderWay {
    scenario: u32,
    name: String,
    snapshots: u32,
    /// When it was published.
    since: Instant,
}

/// A run under way.
pub struct Run<'a> {
    commands: Commands<'a>,
    signals: Signals,
    // Processes end before the domain is closed: fields are dropped in this order.
    supervisor: Supervisor,
    reports: Inlet<Status>,
    roster: Outlet<Roster>,
    scenarios: Inlet<Scenario>,
    domain: HeldDomain,
    view: View,
    members: BTreeMap<String, Member>,
    all_ready: bool,
    cleaned: Instant,
    /// Position of the scenario under way, which is also the number of scenarios that are recorded.
    scenario: u32,
    /// The scenario that was published last.
    under_way: Option<UnderWay>,
    /// How many scenarios there are, once that is known.
    in_all: Option<u32>,
    estimated: u64,
    compared: bool,
    /// By the name of a service: the case for which it waits, and what it waits for.
    awaited: BTreeMap<String, (String, String)>,
    failures: Failures,
    /// Senders that are no case and scenarios that were refused, and what was wrong with them.
    strangers: BTreeMap<String, String>,
    /// The hosts that have not joined yet; until they have, nothing but the bridge is started.
    absent: BTreeSet<String>,
    /// Distinguishes time that passed from time in which the launcher itself stood still.
    watch: Watch,
    /// The latest reports about the next scenario, which arrive before the end of this one if their senders are
    /// quicker.
    early: BTreeMap<(String, u32), Report>,
    /// Whether what is finished is kept after a request to stop.
    keeps: bool,
    /// The scenario that was under way at the first request to stop, if there was one.
    closing: Option<u32>,
    /// The cases of the last scenario that were left out because of the request to stop.
    cut: Vec<String>,
}

impl<'a> Run<'a> {
    /// Opens the domain; `in_all` is the number of scenarios if it is known, `start_at` says when each process is to be
    /// started.
    ///
    /// # Errors
    /// If the domain cannot be created.
    pub fn begin(
        commands: Commands<'a>,
        snapshots: usize,
        in_all: Option<u32>,
        shown: Shown,
        log: &LogSink,
        mut start_at: impl FnMut() -> Instant,
    ) -> Result<Self, Abort> {
        let signals = Signals::outlive_terminal(&[signal_hook::consts::SIGCHLD])
            .map_err(|e| Abort::Fatal(format!("cannot catch signals: {e}")))?;
        let cases = &commands.launch.cases;
        let capacity = Capacity {
            propagators: commands.launch.propagators(),
            cases: cases.len(),
            snapshots,
            hosts: commands.hosts().len(),
        };
        let domain = HeldDomain::create(commands.place, &capacity)?;
        let reports = domain.domain.inlet::<Status>()?;
        let roster = domain.domain.outlet::<Roster>(cases.len())?;
        let scenarios = domain.domain.inlet::<Scenario>()?;
        commands.place.reserve().map_err(|e| Abort::Fatal(format!("cannot reserve shared memory: {e}")))?;
        let propagators: Vec<String> = cases.iter().flat_map(Case::members).map(|(name, _)| name).collect();
        let away = commands.launch.away();
        let names = Service::OF_EVERY_RUN
            .into_iter()
            .map(|service| service.name().to_owned())
            .chain(propagators.iter().cloned());
        let names = names.chain(commands.launch.hosts.iter().map(|_| Service::Bridge.name().to_owned()));
        let member = |name: String| {
            let member = if away.contains_key(&name) { Member::away(start_at()) } else { Member::new(start_at()) };
            (name, member)
        };
        let members = names.map(member).collect();
        let model = Model::new(propagators, stages(commands.launch, in_all)).with_hosts(away);
        let view = View::new(model, shown);
        log.print_with(view.printer());
        let run = Self {
            signals,
            supervisor: Supervisor::new(log.clone()),
            reports,
            roster,
            scenarios,
            under_way: None,
            in_all,
            domain,
            view,
            members,
            all_ready: false,
            cleaned: Instant::now(),
            scenario: 0,
            estimated: 0,
            compared: false,
            awaited: BTreeMap::new(),
            failures: Failures::new(),
            strangers: BTreeMap::new(),
            absent: commands.hosts().iter().cloned().collect(),
            watch: Watch::start(),
            early: BTreeMap::new(),
            keeps: in_all.is_some(),
            closing: None,
            cut: Vec::new(),
            commands,
        };
        run.publish_roster()?;
        run.announce_hosts();
        Ok(run)
    }

    /// Conducts the run from the start of the first process until all scenarios are recorded. Calls `recorded` after
    /// each with its position.
    ///
    /// # Errors
    /// Why there are no results.
    pub fn conduct(&mut self, mut recorded: impl FnMut(u32, &Failures) -> Result<(), String>) -> Result<(), Abort> {
        let mut told = 0;
        while self.in_all.is_none_or(|in_all| self.scenario < in_all) {
            self.look_around()?;
            while told < self.scenario {
                recorded(told, &self.failures).map_err(Abort::Fatal)?;
                told += 1;
            }
            if self.has_closed() && self.in_all != Some(self.scenario) {
                return Err(Abort::Stopped);
            }
        }
        Ok(())
    }

    /// How many scenarios are recorded.
    pub fn recorded(&self) -> u32 {
        self.scenario
    }

    /// What has gone wrong so far.
    pub fn failures(&self) -> &Failures {
        &self.failures
    }

    /// Senders that are no case of the run and scenarios that were refused, and what was wrong with them.
    pub fn strangers(&self) -> &BTreeMap<String, String> {
        &self.strangers
    }

    /// Ends all processes and returns how each ended.
    pub fn end(&mut self) -> BTreeMap<String, String> {
        let how = |(name, end): (String, String)| {
            let restarts = self.members.get(&name).map_or(0, |member| member.attempt);
            let end = if restarts == 0 { end } else { format!("{end}, restarts: {restarts}") };
            (name, end)
        };
        self.supervisor.stop_all().into_iter().map(how).collect()
    }

    /// Closes the run, and returns the signals, which report further requests to stop.
    pub fn into_signals(self) -> Signals {
        self.signals
    }

    /// Sleeps until something happens, and deals with it.
    fn look_around(&mut self) -> Result<(), Abort> {
        self.start_what_is_due()?;
        self.signals.wait(&[&self.reports, &self.roster, &self.scenarios], self.longest_sleep())?;
        self.forgive_what_was_missed();
        self.take_scenarios()?;
        self.view.refresh();
        let ended = self.supervisor.newly_ended();
        // The reports that a process sent before it ended say more than how it ended.
        self.take_reports()?;
        for Ended { name, status } in &ended {
            self.deal_with_end(name, *status)?;
        }
        if self.signals.stop_requested() {
            self.heed_request()?;
        }
        self.end_what_takes_too_long()?;
        self.give_up_on_the_silent()?;
        if self.cleaned.elapsed() > TICK {
            // Observers may die, too.
            self.clean();
        }
        Ok(())
    }

    fn clean(&mut self) {
        self.domain.domain.clean_up_after_the_dead();
        self.cleaned = Instant::now();
    }

    fn longest_sleep(&self) -> Duration {
        let next = self.members.values().filter_map(|member| member.due).chain(self.next_end_of_a_budget()).min();
        next.map_or(TICK, |due| due.saturating_duration_since(Instant::now()).min(TICK))
    }

    fn start_what_is_due(&mut self) -> Result<(), Abort> {
        let now = Instant::now();
        let due: Vec<String> = self
            .members
            .iter()
            .filter(|(_, member)| member.due.is_some_and(|due| due <= now))
            .filter(|(name, _)| self.absent.is_empty() || Service::Bridge.is(name))
            .map(|(name, _)| name.clone())
            .collect();
        for name in due {
            let Some(member) = self.members.get_mut(&name) else { continue };
            member.started(now);
            let command = self.commands.of(&name, member.attempt, self.scenario);
            if let Err(why) = command.and_then(|command| self.supervisor.start(&name, command)) {
                self.fail(&name, why)?;
            }
        }
        Ok(())
    }

    /// Receives the scenarios that have been published.
    fn take_scenarios(&mut self) -> Result<(), Abort> {
        while let Some(message) = self.scenarios.receive()? {
            if let Err(Refusal { sender, why }) = screen(self.commands.run_id, &message) {
                drop(message);
                self.blame(&sender, why)?;
                continue;
            }
            let header = message.header();
            let (scenario, snapshots) = (header.scenario, header.snapshots);
            if self.under_way.as_ref().is_none_or(|known| known.scenario < scenario) {
                let name = unpack(&header.name);
                self.view.model_mut().set_stage(scenario, Stage { name: name.clone(), snapshots: snapshots.into() });
                // A service may have been idle for long, which is no silence of its processes.
                let now = Instant::now();
                self.under_way = Some(UnderWay { scenario, name, snapshots, since: now });
                self.members.values_mut().for_each(|member| member.heard = now);
            }
        }
        Ok(())
    }

    /// The scenario that everybody works on, if there is one.
    fn current(&self) -> Option<&UnderWay> {
        self.under_way.as_ref().filter(|known| known.scenario == self.scenario)
    }

    /// Begins the next scenario, since the recorder has written this one.
    fn begin_next_scenario(&mut self) -> Result<(), Abort> {
        if let Some(known) = self.current() {
            self.view.note(&format!("{} is recorded", known.name));
        }
        self.scenario += 1;
        (self.estimated, self.compared) = (0, false);
        self.awaited.clear();
        let now = Instant::now();
        for member in self.members.values_mut() {
            member.begin_scenario(now);
        }
        self.publish_roster()?;
        let early = std::mem::take(&mut self.early);
        early.into_values().try_for_each(|report| self.take_report(report))
    }

    /// Counts time in which the launcher itself was stopped, or got no turn, neither as silence nor in a budget.
    fn forgive_what_was_missed(&mut self) {
        let missed = self.watch.missed();
        self.members.values_mut().for_each(|member| member.heard += missed);
        if let Some(known) = &mut self.under_way {
            known.since += missed;
        }
    }

    fn publish_roster(&self) -> Result<(), Abort> {
        let header = RosterHeader { run_id: self.commands.run_id, scenario: self.scenario, reserved: 0 };
        let references = &self.commands.launch.references;
        let entry = |case: &Case| RosterEntry {
            label: pack(&case.label),
            failed: u32::from(self.has_failed(&case.label)),
            reason: self.failures.get(&(self.scenario, case.label.clone())).map_or([0; 384], |why| pack(why)),
            shards: case.shards,
            reference: references.iter().position(|label| *label == case.label).map_or(0, |place| place as u32 + 1),
            baseline: u32::from(self.commands.launch.baseline.as_ref() == Some(&case.label)),
        };
        let entries: Vec<RosterEntry> = self.commands.launch.cases.iter().map(entry).collect();
        Ok(self.roster.send_items(header, &entries)?)
    }
}

/// What is needed of the scenarios to show progress: all those of a run, none yet of a service.
fn stages(launch: &Launch, in_all: Option<u32>) -> Vec<Stage> {
    let stage =
        |s: &ScenarioInput| Stage { name: s.content.name.clone(), snapshots: s.content.problem.times.len() as u64 };
    launch.scenarios.iter().take(in_all.unwrap_or(0) as usize).map(stage).collect()
}

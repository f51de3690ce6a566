//! A run under way: its processes are started, looked after, restarted where that helps, and ended.

mod arrivals;
mod budget;
mod course;
mod failing;
mod patience;
mod reports;
mod stopping;
mod topics;

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use messages::patience::Watch;
use messages::port::PortError;
use messages::reporter::Reporter;
use messages::service::Service;
use messages::topic::Capacity;
use messages::wait::Signals;

use crate::crew::commands::Commands;
use crate::crew::log_sink::LogSink;
use crate::crew::member::Member;
use crate::crew::processes::Processes;
use crate::crew::supervisor::{Ended, Supervisor};
use crate::live::View;
use crate::live::progress::{Progress, Stage};
use crate::plan::cases::Case;
use crate::plan::launch_file::{Launch, Restart};
use crate::plan::scenario_inputs::ScenarioInput;
use crate::shown::Shown;

use arrivals::Arrivals;
use course::Course;
use stopping::Stopping;
use topics::Topics;

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

/// What has gone wrong so far.
#[derive(Default)]
struct Troubles {
    failures: Failures,
    /// Senders that are no case and scenarios that were refused, and what was wrong with them.
    strangers: BTreeMap<String, String>,
}

/// A run under way.
pub struct Run<'a> {
    commands: Commands<'a>,
    signals: Signals,
    // Processes end before the domain is closed: fields are dropped in this order.
    processes: Processes,
    topics: Topics,
    view: View,
    course: Course,
    troubles: Troubles,
    arrivals: Arrivals,
    stopping: Stopping,
    /// Distinguishes time that passed from time in which the launcher itself stood still.
    watch: Watch,
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
        let topics = Topics::open(&commands, &capacity)?;
        commands.place.reserve().map_err(|e| Abort::Fatal(format!("cannot reserve shared memory: {e}")))?;
        let propagators: Vec<Reporter> = cases.iter().flat_map(Case::processes).collect();
        let away = commands.launch.away();
        let bridge = commands.launch.hosts.iter().map(|_| Service::Bridge);
        let services = Service::OF_EVERY_RUN.into_iter().chain(bridge).map(Reporter::Service);
        let member = |who: Reporter| {
            let name = who.to_string();
            let member = match away.contains_key(&name) {
                true => Member::away(who, start_at()),
                false => Member::new(who, start_at()),
            };
            (name, member)
        };
        let members = services.chain(propagators.iter().cloned()).map(member).collect();
        let progress = Progress::new(propagators, stages(commands.launch, in_all)).with_hosts(away);
        let view = View::new(progress, shown);
        log.print_with(view.printer());
        let restarts = commands.launch.restart == Restart::OnFailure;
        let run = Self {
            signals,
            processes: Processes::new(Supervisor::new(log.clone()), members, restarts),
            topics,
            view,
            course: Course::new(in_all),
            troubles: Troubles::default(),
            arrivals: Arrivals::of(commands.hosts()),
            stopping: Stopping::new(in_all.is_some()),
            watch: Watch::start(),
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
        while self.course.in_all.is_none_or(|in_all| self.course.scenario < in_all) {
            self.look_around()?;
            while told < self.course.scenario {
                recorded(told, &self.troubles.failures).map_err(Abort::Fatal)?;
                told += 1;
            }
            if self.has_closed() && self.course.in_all != Some(self.course.scenario) {
                return Err(Abort::Stopped);
            }
        }
        Ok(())
    }

    /// How many scenarios are recorded.
    pub fn recorded(&self) -> u32 {
        self.course.scenario
    }

    /// What has gone wrong so far.
    pub fn failures(&self) -> &Failures {
        &self.troubles.failures
    }

    /// Senders that are no case of the run and scenarios that were refused, and what was wrong with them.
    pub fn strangers(&self) -> &BTreeMap<String, String> {
        &self.troubles.strangers
    }

    /// Ends all processes and returns how each ended.
    pub fn end(&mut self) -> BTreeMap<String, String> {
        let ended = self.processes.supervisor.stop_all();
        let how = |(name, end): (String, String)| {
            let restarts = self.processes.restarts_of(&name);
            let end = if restarts == 0 { end } else { format!("{end}, restarts: {restarts}") };
            (name, end)
        };
        ended.into_iter().map(how).collect()
    }

    /// Closes the run, and returns the signals, which report further requests to stop.
    pub fn into_signals(self) -> Signals {
        self.signals
    }

    /// Sleeps until something happens, and deals with it.
    fn look_around(&mut self) -> Result<(), Abort> {
        self.start_what_is_due()?;
        self.signals
            .wait(&[&self.topics.reports, &self.topics.roster, &self.topics.scenarios], self.longest_sleep())?;
        self.forgive_what_was_missed();
        self.take_scenarios()?;
        self.view.refresh();
        let ended = self.processes.supervisor.newly_ended();
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
        if self.topics.cleaned.elapsed() > TICK {
            // Observers may die, too.
            self.topics.clean();
        }
        Ok(())
    }

    fn longest_sleep(&self) -> Duration {
        let next = self.processes.next_due().into_iter().chain(self.next_end_of_a_budget()).min();
        next.map_or(TICK, |due| due.saturating_duration_since(Instant::now()).min(TICK))
    }

    fn start_what_is_due(&mut self) -> Result<(), Abort> {
        let (absent, commands, scenario) = (&self.arrivals.absent, &self.commands, self.course.scenario);
        let failed = self.processes.start_what_is_due(
            |who| absent.is_empty() || who.is(Service::Bridge),
            |name, attempt| commands.of(name, attempt, scenario),
        );
        failed.into_iter().try_for_each(|(name, why)| self.fail(&name, why))
    }

    /// Counts time in which the launcher itself was stopped, or got no turn, neither as silence nor in a budget.
    fn forgive_what_was_missed(&mut self) {
        let missed = self.watch.missed();
        self.processes.members.values_mut().for_each(|member| member.heard += missed);
        if let Some(known) = &mut self.course.under_way {
            known.since += missed;
        }
    }
}

/// What is needed of the scenarios to show progress: all those of a run, none yet of a service.
fn stages(launch: &Launch, in_all: Option<u32>) -> Vec<Stage> {
    let stage =
        |s: &ScenarioInput| Stage { name: s.content.name().to_owned(), snapshots: s.content.times().len() as u64 };
    launch.scenarios.iter().take(in_all.unwrap_or(0) as usize).map(stage).collect()
}

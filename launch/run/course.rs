//! The course of a run: which scenario is under way, and how far the services are with it.

use std::collections::BTreeMap;
use std::time::Instant;

use kit::screen::{Refusal, screen};
use messages::report::{Event, Report};
use messages::reporter::Reporter;
use messages::service::Service;
use messages::text::unpack;

use super::{Abort, Run};
use crate::live::progress::Stage;

/// Most reports about the next scenario that are kept.
const MOST_EARLY: usize = 4096;

/// A scenario that has been published.
pub(super) struct UnderWay {
    pub(super) scenario: u32,
    pub(super) name: String,
    pub(super) snapshots: u32,
    /// When it was published.
    pub(super) since: Instant,
}

/// Which scenario is under way, and how far the services are with it.
pub(super) struct Course {
    /// Position of the scenario under way, which is also the number of scenarios that are recorded.
    pub(super) scenario: u32,
    /// The scenario that was published last.
    pub(super) under_way: Option<UnderWay>,
    /// How many scenarios there are, once that is known.
    pub(super) in_all: Option<u32>,
    /// How many densities the estimator has published.
    pub(super) estimated: u64,
    /// Whether the comparator is done.
    pub(super) compared: bool,
    /// By the name of a service: the case for which it waits, and what it waits for.
    pub(super) awaited: BTreeMap<String, (String, String)>,
    /// The latest reports about the next scenario, which arrive before the end of this one if their senders are
    /// quicker.
    early: BTreeMap<(Reporter, u32), Report>,
}

impl Course {
    /// No scenario has been published yet; `in_all` is the number of scenarios if it is known.
    pub(super) fn new(in_all: Option<u32>) -> Self {
        Self {
            scenario: 0,
            under_way: None,
            in_all,
            estimated: 0,
            compared: false,
            awaited: BTreeMap::new(),
            early: BTreeMap::new(),
        }
    }

    /// The scenario that everybody works on, if there is one.
    pub(super) fn current(&self) -> Option<&UnderWay> {
        self.under_way.as_ref().filter(|known| known.scenario == self.scenario)
    }

    /// Goes on to the next scenario. Returns the reports about it that have arrived already.
    fn go_on(&mut self) -> impl Iterator<Item = Report> + use<> {
        self.scenario += 1;
        (self.estimated, self.compared) = (0, false);
        self.awaited.clear();
        std::mem::take(&mut self.early).into_values()
    }

    /// Whether a report is about the next scenario, although the end of this one has not been reported yet.
    pub(super) fn is_early(&self, report: &Report) -> bool {
        report.scenario == self.scenario.saturating_add(1)
            && !matches!(report.event, Event::Ready | Event::Joined { .. })
            && !report.from.is(Service::Scenario)
            && self.in_all.is_none_or(|in_all| report.scenario < in_all)
    }

    /// Keeps an early report until its scenario begins.
    pub(super) fn keep_early(&mut self, report: Report) {
        if self.early.len() < MOST_EARLY {
            self.early.insert((report.from.clone(), report.event.code()), report);
        }
    }
}

impl Run<'_> {
    /// Receives the scenarios that have been published.
    pub(super) fn take_scenarios(&mut self) -> Result<(), Abort> {
        while let Some(message) = self.topics.scenarios.receive()? {
            if let Err(Refusal { sender, why }) = screen(self.commands.run_id, &message) {
                drop(message);
                self.blame(&sender, why)?;
                continue;
            }
            let header = message.header();
            let (scenario, snapshots) = (header.scenario, header.snapshots);
            if self.course.under_way.as_ref().is_none_or(|known| known.scenario < scenario) {
                let name = unpack(&header.name);
                self.view.progress_mut().set_stage(scenario, Stage { name: name.clone(), snapshots: snapshots.into() });
                self.course.under_way = Some(UnderWay { scenario, name, snapshots, since: Instant::now() });
                // A service may have been idle for long, which is no silence of its processes.
                self.processes.forget_silence();
            }
        }
        Ok(())
    }

    /// Begins the next scenario, since the recorder has written this one.
    pub(super) fn begin_next_scenario(&mut self) -> Result<(), Abort> {
        if let Some(known) = self.course.current() {
            self.view.note(&format!("{} is recorded", known.name));
        }
        let early = self.course.go_on();
        self.processes.begin_scenario();
        self.publish_roster()?;
        early.into_iter().try_for_each(|report| self.take_report(report))
    }
}

//! How far every node of a run is, from what the nodes report.

use std::collections::BTreeMap;
use std::collections::BTreeSet;
use std::time::Instant;

use messages::report::{Event, Report};
use messages::reporter::Reporter;
use messages::service::Service;
use serde::Serialize;

/// What a node is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Phase {
    /// It has not reported yet.
    Starting,
    /// It waits for work.
    Ready,
    /// It works.
    Working,
    /// It has finished its part of the scenario.
    Done,
    /// It cannot finish.
    Failed,
}

impl Phase {
    /// The phase in one word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Starting => "starting",
            Self::Ready => "ready",
            Self::Working => "working",
            Self::Done => "done",
            Self::Failed => "failed",
        }
    }
}

/// How far a node is.
#[derive(Debug, Clone)]
pub struct NodeState {
    /// Which node it is.
    pub who: Reporter,
    /// The other host on which it runs, if it does.
    pub host: Option<String>,
    /// What it is doing.
    pub phase: Phase,
    /// The scenario it works on, as a position in the run.
    pub scenario: u32,
    /// Units of work done.
    pub done: u64,
    /// Units of work in total.
    pub of: u64,
    /// When the measurement of its rate began, and the units that were done then.
    since: Option<(Instant, u64)>,
}

impl NodeState {
    /// Its name as it is shown: with its host, if that is another one.
    pub fn shown(&self) -> String {
        match &self.host {
            Some(host) => format!("{}@{host}", self.who),
            None => self.who.to_string(),
        }
    }

    /// Units of work per second, once there is something to measure.
    pub fn per_second(&self, now: Instant) -> Option<f64> {
        let (since, before) = self.since?;
        let seconds = now.saturating_duration_since(since).as_secs_f64();
        (self.phase == Phase::Working && self.done > before && seconds > 0.0)
            .then(|| (self.done - before) as f64 / seconds)
    }

    /// Seconds that the remaining work will take at this rate.
    pub fn seconds_left(&self, now: Instant) -> Option<f64> {
        self.per_second(now).map(|rate| self.of.saturating_sub(self.done) as f64 / rate)
    }
}

/// What is needed of a scenario to show progress.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stage {
    /// The scenario's name.
    pub name: String,
    /// How many snapshots it has.
    pub snapshots: u64,
}

/// How far all nodes of a run are.
#[derive(Debug, Clone)]
pub struct Progress {
    nodes: Vec<NodeState>,
    /// The scenarios of the run.
    pub stages: Vec<Stage>,
    cases: BTreeSet<String>,
}

impl Progress {
    /// The nodes of a run of these propagators on these scenarios; the shards of one label belong to one case.
    pub fn new(propagators: Vec<Reporter>, stages: Vec<Stage>) -> Self {
        let cases = propagators.iter().map(|propagator| propagator.label().to_owned()).collect();
        let readers = [Service::Estimator, Service::Comparator, Service::Recorder].map(Reporter::Service);
        let processes = [Reporter::Service(Service::Scenario)].into_iter().chain(propagators).chain(readers);
        let node = |who: Reporter| NodeState {
            who,
            host: None,
            phase: Phase::Starting,
            scenario: 0,
            done: 0,
            of: 0,
            since: None,
        };
        Self { nodes: processes.map(node).collect(), stages, cases }
    }

    /// The same nodes; `away` names those that run on other hosts, with their hosts.
    pub fn with_hosts(mut self, away: BTreeMap<String, String>) -> Self {
        for node in &mut self.nodes {
            node.host = away.get(&node.who.to_string()).cloned();
        }
        self
    }

    /// The nodes, in the order in which messages flow.
    pub fn nodes(&self) -> &[NodeState] {
        &self.nodes
    }

    /// Notes what the scenario at a position is.
    pub fn set_stage(&mut self, scenario: u32, stage: Stage) {
        let unknown = Stage { name: String::new(), snapshots: 0 };
        let position = scenario as usize;
        if self.stages.len() <= position {
            self.stages.resize(position + 1, unknown);
        }
        self.stages[position] = stage;
    }

    /// The name of a scenario.
    pub fn stage_name(&self, scenario: u32) -> &str {
        self.stages.get(scenario as usize).map_or("", |stage| &stage.name)
    }

    /// Takes in a report, and returns the node that it changed. `history` marks a report that its publisher had kept
    /// for late readers: it says how far a node is, not how fast it got there.
    pub fn report(&mut self, report: &Report, history: bool, now: Instant) -> Option<&NodeState> {
        if matches!(report.event, Event::Accepted { .. }) {
            self.begin_scenario(report.scenario, now);
        }
        if let Event::Failed { of, .. } = &report.event {
            return self.fail(of);
        }
        let is_estimator = report.from.is(Service::Estimator);
        // The estimator does not know how many snapshots will come.
        let most = if is_estimator { self.snapshots_of(report.scenario) } else { 0 };
        let node = self.nodes.iter_mut().find(|node| node.who == report.from && node.phase != Phase::Failed)?;
        let mut works = |done: u64, of: u64| {
            (node.phase, node.done, node.of) = (Phase::Working, done, of.max(most));
            if history || node.since.is_none() {
                node.since = Some((now, node.done));
            }
            if is_estimator && node.done >= node.of {
                node.phase = Phase::Done;
            }
        };
        match &report.event {
            Event::Accepted { of, .. } => works(u64::from(report.scenario), u64::from(of.unwrap_or(0))),
            Event::Progress { done, of } => works(*done, *of),
            Event::WaitsFor { done, .. } => works(*done, *done),
            Event::Ready => node.phase = Phase::Ready,
            Event::Done | Event::Total => {
                node.of = node.of.max(1);
                (node.phase, node.done) = (Phase::Done, node.of);
            }
            Event::Refused { .. } | Event::Failed { .. } | Event::Joined { .. } => return None,
        }
        node.scenario = report.scenario;
        Some(node)
    }

    /// Notes that a scenario is finished, if this is the recorder's report of its end: then all nodes have done their
    /// part, whether their own reports have arrived or not. Returns the nodes that this changed.
    pub fn end_scenario(&mut self, report: &Report) -> Vec<NodeState> {
        if !report.is_end_of(report.scenario) {
            return Vec::new();
        }
        let under_way = |node: &&mut NodeState| matches!(node.phase, Phase::Working | Phase::Ready);
        let end = |node: &mut NodeState| {
            node.done = if node.who.is(Service::Scenario) { u64::from(report.scenario) + 1 } else { node.of };
            if node.done >= node.of {
                node.phase = Phase::Done;
            }
            node.clone()
        };
        self.nodes.iter_mut().filter(under_way).map(end).collect()
    }

    /// Notes that a case cannot be finished, nor any of its shards; `of` is the case or one of its shards.
    pub fn fail(&mut self, of: &Reporter) -> Option<&NodeState> {
        let its_own = |node: &&mut NodeState| node.who.label() == of.label();
        self.nodes.iter_mut().filter(its_own).for_each(|node| node.phase = Phase::Failed);
        self.nodes.iter().find(|node| node.who == *of)
    }

    /// Notes that all nodes that have not failed begin the work on a scenario.
    fn begin_scenario(&mut self, scenario: u32, now: Instant) {
        let working = |node: &&mut NodeState| node.phase != Phase::Failed && !node.who.is(Service::Scenario);
        for node in self.nodes.iter_mut().filter(working) {
            // A report from this scenario may have been quicker than the report that it has begun.
            if node.scenario != scenario || node.phase != Phase::Working {
                (node.scenario, node.done, node.of) = (scenario, 0, 0);
                node.since = Some((now, 0));
                node.phase = if node.phase == Phase::Starting { Phase::Starting } else { Phase::Ready };
            }
        }
    }

    /// The number of snapshots of a scenario that all cases together send, without those that have failed.
    fn snapshots_of(&self, scenario: u32) -> u64 {
        let failed = |label: &String| self.nodes.iter().any(|n| n.who.label() == label && n.phase == Phase::Failed);
        let cases = self.cases.iter().filter(|label| !failed(label)).count() as u64;
        self.stages.get(scenario as usize).map_or(0, |stage| stage.snapshots * cases)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    /// The process that the launcher shows under this name.
    fn process(name: &str) -> Reporter {
        match name.split_once('/') {
            Some((label, shard)) => Reporter::shard(label, shard.parse().unwrap()),
            None => Reporter::started_as(name, None),
        }
    }

    fn report(node: &str, event: Event) -> Report {
        Report { from: process(node), scenario: 0, event }
    }

    fn progress(node: &str, done: u64, of: u64) -> Report {
        report(node, Event::Progress { done, of })
    }

    fn failed(node: &str) -> Report {
        report(node, Event::Failed { of: process(node), why: "lost".into() })
    }

    fn started() -> Progress {
        Progress::new(["mc", "mine"].map(process).to_vec(), vec![Stage { name: "s".into(), snapshots: 5 }])
    }

    #[test]
    fn rate_and_time_left_are_measured_from_the_start_of_the_scenario() {
        let (mut run, start) = (started(), Instant::now());
        run.report(&report("scenario", Event::Accepted { name: "s".into(), of: Some(1), request: None }), false, start);
        let now = start + Duration::from_secs(4);
        let node = run.report(&progress("mc", 2, 5), false, now).unwrap();
        assert_eq!((node.per_second(now), node.seconds_left(now)), (Some(0.5), Some(6.0)));
    }

    #[test]
    fn history_says_how_far_but_not_how_fast() {
        let (mut run, start) = (started(), Instant::now());
        let node = run.report(&progress("mc", 2, 5), true, start).unwrap();
        assert_eq!((node.done, node.per_second(start + Duration::from_secs(1))), (2, None));
        let now = start + Duration::from_secs(2);
        let node = run.report(&progress("mc", 3, 5), false, now).unwrap();
        assert_eq!(node.per_second(now), Some(0.5));
    }

    #[test]
    fn shards_are_one_case_and_fail_together() {
        let stages = vec![Stage { name: "s".into(), snapshots: 5 }];
        let propagators = ["mc/0", "mc/1", "exact"].map(process).to_vec();
        let (mut run, now) = (Progress::new(propagators, stages), Instant::now());
        let estimator = |run: &mut Progress| run.report(&progress("estimator", 1, 1), false, now).map(|node| node.of);
        assert_eq!(estimator(&mut run), Some(10));
        run.report(&failed("mc/1"), false, now);
        assert_eq!(estimator(&mut run), Some(5));
        assert!(run.report(&progress("mc/0", 1, 5), false, now).is_none());
    }

    #[test]
    fn the_estimators_work_is_the_snapshots_of_all_cases_that_have_not_failed() {
        let (mut run, now) = (started(), Instant::now());
        let of =
            |run: &mut Progress| run.report(&progress("estimator", 1, 1), false, now).map(|node| (node.phase, node.of));
        assert_eq!(of(&mut run), Some((Phase::Working, 10)));
        run.report(&failed("mine"), false, now);
        assert_eq!(of(&mut run), Some((Phase::Working, 5)));
        assert!(run.report(&report("mine", Event::Ready), false, now).is_none(), "what has failed stays so");
    }
}

//! How far every node of a run is, from what the nodes report.

use std::collections::BTreeMap;
use std::collections::BTreeSet;
use std::time::Instant;

use messages::layout::{StatusHeader, phase};
use messages::text::unpack;
use nodes::shard::label_of_member;
use serde::Serialize;

/// The process that publishes the scenarios.
const SCENARIO_NODE: &str = "scenario";
/// The process that turns every snapshot of every case into a density.
const ESTIMATOR: &str = "estimator";
/// The process whose end of work is the end of a scenario.
const RECORDER: &str = "recorder";

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
    /// In a word.
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
    /// The node's name; a propagator's is its label.
    pub name: String,
    /// The other host on which it runs, if it does.
    pub host: Option<String>,
    /// What it is doing.
    pub phase: Phase,
    /// The scenario it works on, as a position in the run.
    pub scenario: u32,
    /// Units of work done.
    pub done: u64,
    /// Units of work in all.
    pub of: u64,
    /// From when on it has been watched, and the units that were done then.
    since: Option<(Instant, u64)>,
}

impl NodeState {
    /// Its name as it is shown: with its host, if that is another one.
    pub fn shown(&self) -> String {
        match &self.host {
            Some(host) => format!("{}@{host}", self.name),
            None => self.name.clone(),
        }
    }

    /// Units a second, once there is something to measure.
    pub fn per_second(&self, now: Instant) -> Option<f64> {
        let (since, before) = self.since?;
        let seconds = now.saturating_duration_since(since).as_secs_f64();
        (self.phase == Phase::Working && self.done > before && seconds > 0.0)
            .then(|| (self.done - before) as f64 / seconds)
    }

    /// Seconds that what is left will take at this rate.
    pub fn seconds_left(&self, now: Instant) -> Option<f64> {
        self.per_second(now).map(|rate| self.of.saturating_sub(self.done) as f64 / rate)
    }
}

/// A scenario as far as progress goes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stage {
    /// The scenario's name.
    pub name: String,
    /// How many snapshots it has.
    pub snapshots: u64,
}

/// All nodes of a run.
#[derive(Debug, Clone)]
pub struct Model {
    nodes: Vec<NodeState>,
    /// The scenarios of the run.
    pub stages: Vec<Stage>,
    cases: BTreeSet<String>,
}

impl Model {
    /// The nodes of a run of these propagators on these scenarios; shards belong to one case.
    pub fn new(propagators: Vec<String>, stages: Vec<Stage>) -> Self {
        let cases = propagators.iter().map(|name| label_of_member(name).to_owned()).collect();
        let names = std::iter::once(SCENARIO_NODE).chain(propagators.iter().map(String::as_str));
        let names = names.chain([ESTIMATOR, "comparator", RECORDER]);
        let node = |name: &str| NodeState {
            name: name.into(),
            host: None,
            phase: Phase::Starting,
            scenario: 0,
            done: 0,
            of: 0,
            since: None,
        };
        Self { nodes: names.map(node).collect(), stages, cases }
    }

    /// The same nodes, of which these run on other hosts.
    pub fn with_hosts(mut self, away: BTreeMap<String, String>) -> Self {
        for node in &mut self.nodes {
            node.host = away.get(&node.name).cloned();
        }
        self
    }

    /// The nodes, in the order of the flow.
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

    /// Takes in a report, and says which node it changed. What a publisher had kept for late readers is `history`: it says
    /// how far a node is, not how fast it got there.
    pub fn report(
        &mut self,
        header: &StatusHeader,
        units: [u64; 2],
        history: bool,
        now: Instant,
    ) -> Option<&NodeState> {
        let name = unpack(&header.node);
        if name == SCENARIO_NODE && header.phase == phase::WORKING {
            self.begin_scenario(header.scenario, now);
        }
        if header.phase == phase::FAILED {
            return self.fail(&unpack(&header.subject));
        }
        let most = match name.as_str() {
            // It does not know how much will come.
            ESTIMATOR => self.snapshots_of(header.scenario),
            _ => 0,
        };
        let node = self.nodes.iter_mut().find(|node| node.name == name && node.phase != Phase::Failed)?;
        node.scenario = header.scenario;
        match header.phase {
            phase::READY => node.phase = Phase::Ready,
            phase::WORKING => {
                (node.phase, node.done, node.of) = (Phase::Working, units[0], units[1].max(most));
                if history || node.since.is_none() {
                    node.since = Some((now, node.done));
                }
                if name == ESTIMATOR && node.done >= node.of {
                    node.phase = Phase::Done;
                }
            }
            phase::DONE => {
                node.of = node.of.max(1);
                (node.phase, node.done) = (Phase::Done, node.of);
            }
            _ => return None,
        }
        Some(node)
    }

    /// Notes that a scenario is finished, which the recorder's report says: then all have done their part, whether their own
    /// reports have arrived or not. Returns whom that changed.
    pub fn end_scenario(&mut self, header: &StatusHeader) -> Vec<NodeState> {
        if header.phase != phase::DONE || unpack(&header.node) != RECORDER {
            return Vec::new();
        }
        let under_way = |node: &&mut NodeState| matches!(node.phase, Phase::Working | Phase::Ready);
        let end = |node: &mut NodeState| {
            node.done = if node.name == SCENARIO_NODE { u64::from(header.scenario) + 1 } else { node.of };
            if node.done >= node.of {
                node.phase = Phase::Done;
            }
            node.clone()
        };
        self.nodes.iter_mut().filter(under_way).map(end).collect()
    }

    /// Notes that a case cannot be finished, nor any of its shards: one of them may be named.
    pub fn fail(&mut self, name: &str) -> Option<&NodeState> {
        let label = label_of_member(name);
        self.nodes.iter_mut().filter(|node| label_of_member(&node.name) == label).for_each(|n| n.phase = Phase::Failed);
        self.nodes.iter().find(|node| node.name == name)
    }

    /// All nodes that have not failed have a scenario's work before them.
    fn begin_scenario(&mut self, scenario: u32, now: Instant) {
        let working = |node: &&mut NodeState| node.phase != Phase::Failed && node.name != SCENARIO_NODE;
        for node in self.nodes.iter_mut().filter(working) {
            // A report from this scenario may have been quicker than the report that it has begun.
            if node.scenario != scenario || node.phase != Phase::Working {
                (node.scenario, node.done, node.of) = (scenario, 0, 0);
                node.since = Some((now, 0));
                node.phase = if node.phase == Phase::Starting { Phase::Starting } else { Phase::Ready };
            }
        }
    }

    /// Snapshots that all cases together have of a scenario.
    fn snapshots_of(&self, scenario: u32) -> u64 {
        let failed =
            |label: &String| self.nodes.iter().any(|n| label_of_member(&n.name) == label && n.phase == Phase::Failed);
        let cases = self.cases.iter().filter(|label| !failed(label)).count() as u64;
        self.stages.get(scenario as usize).map_or(0, |stage| stage.snapshots * cases)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use messages::text::pack;

    use super::*;

    fn report(node: &str, phase: u32) -> StatusHeader {
        StatusHeader { phase, node: pack(node), subject: pack(node), ..StatusHeader::default() }
    }

    fn model() -> Model {
        Model::new(vec!["mc".into(), "mine".into()], vec![Stage { name: "s".into(), snapshots: 5 }])
    }

    #[test]
    fn rate_and_time_left_are_measured_from_the_start_of_the_scenario() {
        let (mut model, start) = (model(), Instant::now());
        model.report(&report("scenario", phase::WORKING), [0, 1], false, start);
        let now = start + Duration::from_secs(4);
        let node = model.report(&report("mc", phase::WORKING), [2, 5], false, now).unwrap();
        assert_eq!((node.per_second(now), node.seconds_left(now)), (Some(0.5), Some(6.0)));
    }

    #[test]
    fn history_says_how_far_but_not_how_fast() {
        let (mut model, start) = (model(), Instant::now());
        let node = model.report(&report("mc", phase::WORKING), [2, 5], true, start).unwrap();
        assert_eq!((node.done, node.per_second(start + Duration::from_secs(1))), (2, None));
        let now = start + Duration::from_secs(2);
        let node = model.report(&report("mc", phase::WORKING), [3, 5], false, now).unwrap();
        assert_eq!(node.per_second(now), Some(0.5));
    }

    #[test]
    fn shards_are_one_case_and_fail_together() {
        let stages = vec![Stage { name: "s".into(), snapshots: 5 }];
        let (mut model, now) = (Model::new(vec!["mc/0".into(), "mc/1".into(), "exact".into()], stages), Instant::now());
        let estimator = |model: &mut Model| {
            model.report(&report("estimator", phase::WORKING), [1, 1], false, now).map(|node| node.of)
        };
        assert_eq!(estimator(&mut model), Some(10));
        model.report(&report("mc/1", phase::FAILED), [0, 0], false, now);
        assert_eq!(estimator(&mut model), Some(5));
        assert!(model.report(&report("mc/0", phase::WORKING), [1, 5], false, now).is_none());
    }

    #[test]
    fn the_estimators_work_is_the_snapshots_of_all_cases_that_have_not_failed() {
        let (mut model, now) = (model(), Instant::now());
        let of = |model: &mut Model| {
            model.report(&report("estimator", phase::WORKING), [1, 1], false, now).map(|node| (node.phase, node.of))
        };
        assert_eq!(of(&mut model), Some((Phase::Working, 10)));
        model.report(&report("mine", phase::FAILED), [0, 0], false, now);
        assert_eq!(of(&mut model), Some((Phase::Working, 5)));
        assert!(model.report(&report("mine", phase::READY), [0, 0], false, now).is_none(), "what has failed stays so");
    }
}

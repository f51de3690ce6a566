//! What a propagator sent and did, as it was received.

use std::path::PathBuf;
use std::process::ExitStatus;
use std::time::Duration;

use kit::assignment::Assignment;
use messages::layout::{PassageHeader, SnapshotHeader};
use messages::report::{Event, Report};
use messages::reporter::Reporter;

/// The label that the propagator is given.
pub const LABEL: &str = "checked";
/// How waiting for something ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// The propagator reported that it is ready, or that it is done.
    Done,
    /// It reported a failure, in these words.
    Failed(String),
    /// Its process ended.
    Ended(ExitStatus),
    /// Nothing was heard of it for this time.
    Silent(Duration),
}

impl Outcome {
    /// Whether the propagator is ready or done.
    pub fn is_done(&self) -> bool {
        *self == Self::Done
    }

    /// The outcome in words.
    pub fn describe(&self) -> String {
        match self {
            Self::Done => "done".into(),
            Self::Failed(text) if text.is_empty() => "it reported a failure without saying which".into(),
            Self::Failed(text) => format!("it reported: {text}"),
            Self::Ended(status) => format!("its process ended: {status}"),
            Self::Silent(patience) => format!("no sign of life for {} s", patience.as_secs_f64()),
        }
    }
}

/// A message as it was received.
#[derive(Debug, Clone)]
pub struct Received<H> {
    /// Its header.
    pub header: H,
    /// Its numbers.
    pub items: Vec<f64>,
}

/// What arrived from a propagator, in order of arrival.
#[derive(Debug, Default)]
pub struct Heard {
    /// Its reports, each with the run that it names.
    pub reports: Vec<(u64, Report)>,
    /// Its snapshots.
    pub snapshots: Vec<Received<SnapshotHeader>>,
    /// Its first passages.
    pub passages: Vec<Received<PassageHeader>>,
}

impl Heard {
    /// How many messages.
    pub fn len(&self) -> usize {
        self.reports.len() + self.snapshots.len() + self.passages.len()
    }
}

/// How the process came up.
#[derive(Debug)]
pub struct Ready {
    /// The number of the run, as the process was given it.
    pub run_id: u64,
    /// What it sent.
    pub heard: Heard,
    /// How waiting for it ended.
    pub outcome: Outcome,
    /// How long it took.
    pub after: Duration,
}

/// What a propagator made of a scenario.
#[derive(Debug)]
pub struct Answer {
    /// What it was asked.
    pub assignment: Assignment,
    /// What it sent.
    pub heard: Heard,
    /// How it ended.
    pub outcome: Outcome,
}

/// How a process that was asked to end ended.
#[derive(Debug)]
pub struct Stop {
    /// How it ended; `None` if it had to be killed.
    pub status: Option<ExitStatus>,
    /// How long it took.
    pub after: Duration,
    /// Whether processes that it had started outlived it.
    pub left_others: bool,
    /// Files that it left in the domain.
    pub files: Vec<PathBuf>,
}

/// Whether a report names this run and the label of the propagator.
pub fn is_from((named, report): &(u64, Report), run_id: u64) -> bool {
    *named == run_id && report.from == Reporter::case(LABEL)
}

/// The end of the work on a scenario, if it has been reported.
pub fn end_of(assignment: &Assignment, heard: &Heard) -> Option<Outcome> {
    let is_about = |signed: &&(u64, Report)| {
        signed.1.scenario == assignment.scenario() && is_from(signed, assignment.description.run_id)
    };
    heard.reports.iter().filter(is_about).find_map(|(_, report)| match &report.event {
        Event::Done => Some(Outcome::Done),
        Event::Failed { why, .. } => Some(Outcome::Failed(why.clone())),
        _ => None,
    })
}

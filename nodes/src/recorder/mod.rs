//! The recorder: keeps what estimator and comparator publish as plain files, a folder a scenario.
//!
//! A scenario's folder is complete when the recorder says that it is done with the scenario, and not touched again: a recorder
//! that was restarted goes on with the scenario under work. [`join`] makes one results folder of them.

mod densities;
pub mod join;
mod notes;
mod rows;
mod tables;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use messages::layout::{ComparisonHeader, DensityHeader, PassageHeader, comparison};
use messages::port::Message;
use messages::text::unpack;
use messages::topic::{Comparison, Density, Passage, Roster as RosterTopic, Scenario};

use crate::assignment::Assignment;
use crate::failure::Failure;
use crate::newest::Newest;
use crate::roster::Roster;
use crate::session::Session;

/// A density as it was published.
#[derive(Debug)]
struct RecordedDensity {
    header: DensityHeader,
    values: Vec<f64>,
}

/// A comparison as it was published.
#[derive(Debug)]
struct RecordedComparison {
    header: ComparisonHeader,
    values: Vec<f64>,
}

/// A first-passage curve as it was published, or why there is none.
#[derive(Debug)]
struct RecordedPassage {
    header: PassageHeader,
    values: Vec<f64>,
}

/// What has arrived of a scenario.
#[derive(Debug)]
struct Recording {
    assignment: Assignment,
    densities: BTreeMap<(String, u32), RecordedDensity>,
    /// By label, kind and snapshot: a restarted comparator says everything once more.
    comparisons: BTreeMap<(String, u32, u32), RecordedComparison>,
    passages: BTreeMap<String, RecordedPassage>,
}

impl Recording {
    fn new(assignment: Assignment) -> Self {
        Self { assignment, densities: BTreeMap::new(), comparisons: BTreeMap::new(), passages: BTreeMap::new() }
    }

    fn take_density(&mut self, message: &Message<Density>) {
        let header = *message.header();
        if (header.run_id, header.scenario) == (self.assignment.run_id, self.assignment.scenario) {
            let density = RecordedDensity { header, values: message.items().to_vec() };
            self.densities.insert((unpack(&header.label), header.index), density);
        }
    }

    fn take_passage(&mut self, message: &Message<Passage>) {
        let header = *message.header();
        if (header.run_id, header.scenario) == (self.assignment.run_id, self.assignment.scenario) {
            let passage = RecordedPassage { header, values: message.items().to_vec() };
            self.passages.insert(unpack(&header.label), passage);
        }
    }

    fn take_comparison(&mut self, message: &Message<Comparison>) {
        let header = *message.header();
        if (header.run_id, header.scenario) == (self.assignment.run_id, self.assignment.scenario) {
            let comparison = RecordedComparison { header, values: message.items().to_vec() };
            self.comparisons.insert((unpack(&header.label), header.kind, header.index), comparison);
        }
    }

    /// All snapshots of a case, if they are all there.
    fn case(&self, label: &str) -> Option<Vec<&RecordedDensity>> {
        let snapshots: Vec<_> = (0..self.assignment.problem.times.len() as u32)
            .map_while(|index| self.densities.get(&(label.into(), index)))
            .collect();
        (snapshots.len() == self.assignment.problem.times.len()).then_some(snapshots)
    }

    /// Whether the comparator has finished and every density that it compared has arrived here too.
    fn is_complete(&self) -> bool {
        let of_kind = |kind| self.comparisons.values().filter(move |c| c.header.kind == kind);
        of_kind(comparison::END).next().is_some()
            && of_kind(comparison::EFFORT).all(|c| self.case(&unpack(&c.header.label)).is_some())
    }
}

/// The file in a scenario's folder that says what was run.
pub const SCENARIO: &str = "scenario.toml";

/// The folder of a scenario's files, in the folder that the recorder writes to.
pub fn part(folder: &Path, scenario: u32) -> PathBuf {
    folder.join(format!("part-{scenario:06}"))
}

/// Records scenario after scenario, each into its [`part`] of `folder`, which exists.
///
/// # Errors
/// [`Failure::Stopped`] is the normal end; [`Failure::File`] if something cannot be written.
pub fn run(session: &Session, folder: &Path) -> Result<(), Failure> {
    let scenarios = session.domain.inlet::<Scenario>()?;
    let densities = session.domain.inlet::<Density>()?;
    let comparisons = session.domain.inlet::<Comparison>()?;
    let passages = session.domain.inlet::<Passage>()?;
    let rosters = session.domain.inlet::<RosterTopic>()?;
    session.ready()?;
    let mut roster = Roster::default();
    let mut newest = Newest::default();
    let mut current: Option<Recording> = None;
    loop {
        roster.update(&rosters)?;
        while let Some(message) = scenarios.receive()? {
            if newest.is_news(message.header().scenario) {
                current = Some(Recording::new(Assignment::read(&message)?));
            }
        }
        if let Some(recording) = &mut current {
            while let Some(message) = densities.receive()? {
                recording.take_density(&message);
            }
            while let Some(message) = comparisons.receive()? {
                recording.take_comparison(&message);
            }
            while let Some(message) = passages.receive()? {
                recording.take_passage(&message);
            }
            let scenario = recording.assignment.scenario;
            if roster.scenario == scenario && recording.is_complete() {
                tables::write(recording, &roster, &part(folder, scenario))?;
                session.done(scenario)?;
                current = None;
                continue;
            }
        }
        session.wait(&[&scenarios, &densities, &comparisons, &passages, &rosters])?;
    }
}

//! The recorder: keeps what estimator and comparator publish as a folder of plain files.

mod densities;
mod notes;
mod rows;
mod tables;

use std::collections::BTreeMap;
use std::path::Path;

use density::grid::Grid;
use messages::layout::{ComparisonHeader, DensityHeader, PassageHeader, comparison};
use messages::text::unpack;
use messages::topic::{Comparison, Density, Passage, Roster as RosterTopic, Scenario};

use crate::assignment::Assignment;
use crate::failure::Failure;
use crate::roster::Roster;
use crate::screen::{receive, refuse};
use crate::session::Session;
pub(crate) use tables::Tables;

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
pub(crate) struct Recording {
    assignment: Assignment,
    densities: BTreeMap<(String, u32), RecordedDensity>,
    comparisons: BTreeMap<(String, u32, u32), RecordedComparison>,
    passages: BTreeMap<String, RecordedPassage>,
}

impl Recording {
    pub(crate) fn new(assignment: Assignment) -> Self {
        Self { assignment, densities: BTreeMap::new(), comparisons: BTreeMap::new(), passages: BTreeMap::new() }
    }

    /// Takes in a density that passed the screen, if it is of this scenario and its grid.
    pub(crate) fn take_density(&mut self, header: DensityHeader, values: &[f64]) {
        let Assignment { scenario, grids, .. } = &self.assignment;
        let fits = |grid: &Grid| (grid.phi.bins, grid.e.bins) == (header.phi_bins as usize, header.e_bins as usize);
        if header.scenario == *scenario && grids.get(header.index as usize).is_some_and(fits) {
            let density = RecordedDensity { header, values: values.to_vec() };
            self.densities.insert((unpack(&header.label), header.index), density);
        }
    }

    pub(crate) fn take_passage(&mut self, header: PassageHeader, values: &[f64]) {
        if header.scenario == self.assignment.scenario {
            let passage = RecordedPassage { header, values: values.to_vec() };
            self.passages.insert(unpack(&header.label), passage);
        }
    }

    pub(crate) fn take_comparison(&mut self, header: ComparisonHeader, values: &[f64]) {
        if header.scenario == self.assignment.scenario {
            let place = (unpack(&header.label), header.kind, header.index);
            self.comparisons.insert(place, RecordedComparison { header, values: values.to_vec() });
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
    pub(crate) fn is_complete(&self) -> bool {
        let of_kind = |kind| self.comparisons.values().filter(move |c| c.header.kind == kind);
        of_kind(comparison::END).next().is_some()
            && of_kind(comparison::EFFORT).all(|c| self.case(&unpack(&c.header.label)).is_some())
    }
}

/// Records all scenarios of a run into `folder`, which exists.
///
/// # Errors
/// [`Failure::Stopped`] is the normal end; [`Failure::File`] if something cannot be written.
pub fn run(session: &Session, folder: &Path) -> Result<(), Failure> {
    let scenarios = session.domain.inlet::<Scenario>()?;
    let densities = session.domain.inlet::<Density>()?;
    let comparisons = session.domain.inlet::<Comparison>()?;
    let passages = session.domain.inlet::<Passage>()?;
    let rosters = session.domain.inlet::<RosterTopic>()?;
    let mut tables = Some(Tables::create(folder)?);
    session.ready()?;
    let mut roster = Roster::default();
    let mut current: Option<Recording> = None;
    loop {
        if current.is_none()
            && let Some(message) = receive(session, &scenarios)?
        {
            current = Some(Recording::new(Assignment::read(&message)?));
        }
        roster.update(session, &rosters)?;
        if let Some(recording) = &mut current {
            while let Some(message) = receive(session, &densities)? {
                let label = unpack(&message.header().label);
                if roster.cases.iter().all(|(case, _)| *case != label) {
                    refuse::<Density>(session, &label, "it publishes results, but the launch file has no such label")?;
                }
                recording.take_density(*message.header(), message.items());
            }
            while let Some(message) = receive(session, &comparisons)? {
                recording.take_comparison(*message.header(), message.items());
            }
            while let Some(message) = receive(session, &passages)? {
                recording.take_passage(*message.header(), message.items());
            }
            if recording.is_complete()
                && let Some(open) = &mut tables
            {
                open.write(recording, &roster)?;
                let Assignment { scenario, scenarios: count, .. } = recording.assignment;
                if scenario + 1 == count
                    && let Some(all) = tables.take()
                {
                    all.finish()?;
                }
                session.done(scenario)?;
                current = None;
                continue;
            }
        }
        session.wait(&[&scenarios, &densities, &comparisons, &passages, &rosters])?;
    }
}

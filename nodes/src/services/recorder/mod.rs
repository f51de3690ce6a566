//! The recorder: writes what estimator and comparator publish to plain files, one folder per scenario.
//!
//! The folder of a scenario is complete when the recorder reports that it is done with the scenario, and is not
//! changed after that. A recorder that was restarted continues with the scenario under way. [`results::join`] makes one
//! results folder of all of them.
//!
//! | file | idea |
//! |---|---|
//! | `tape` | every message of the run as it was sent |
//! | [`description`] | the description of the scenario |
//! | `rows` | how messages become rows of tables |
//! | `tables` | the files: tables, and the densities |
//! | `densities` | which arrays a snapshot has in the file of densities |
//! | `judgement` | notes, verdicts and usable first-passage curves of a scenario |
//! | `notes`, `fallbacks` | what a user should know about a result, and where another case was the reference |
//! | `verdicts` | what each method is good for |
//! | `agreement`, `cloud` | whether methods with known errors agree, and the moments of two clouds side by side |
//! | `passages`, `curves` | first-passage curves: put together from shards, and compared |
//! | `given` | what re-entry says of an uncertain radiation parameter |
//! | `so_far` | the results as far as they have come |

mod agreement;
mod cloud;
mod curves;
mod densities;
pub mod description;
mod fallbacks;
mod given;
mod judgement;
mod notes;
mod passages;
mod rows;
mod so_far;
mod tables;
mod tape;
mod verdicts;

pub use rows::{interval_of, named};

use std::collections::BTreeMap;
use std::path::Path;

use messages::comparison_kind::ComparisonKind;
use messages::layout::{ComparisonHeader, DensityHeader, GIVEN_COLUMNS, PASSAGE_COLUMNS, PassageHeader};
use messages::port::Inlet;
use messages::text::unpack;
use messages::topic::{Comparison, Density, Passage, Roster as RosterTopic, Scenario};
use messages::wait::Awaited;
use results::files::part;

use crate::services::passage_rules::curve_in;
use crate::services::reading::Reading;
use crate::services::roster::Roster;
use judgement::Judgement;
use kit::assignment::Assignment;
use kit::failure::Failure;
use kit::newest::Newest;
use kit::screen::{receive, refuse};
use kit::session::Session;
pub use so_far::SoFar;
pub(crate) use tables::write;
use tape::Tape;

/// A comparison as it was published.
#[derive(Debug)]
struct RecordedComparison {
    header: ComparisonHeader,
    values: Vec<f64>,
}

/// A first-passage curve as it was published, or why there is none.
#[derive(Debug, Clone)]
struct RecordedPassage {
    header: PassageHeader,
    /// The rows of the curve.
    values: Vec<f64>,
    /// What re-entry says of an uncertain parameter, in rows of [`GIVEN_COLUMNS`]; empty if it was not sent.
    given: Vec<f64>,
}

impl RecordedPassage {
    /// From the items of a message, whose rows may go on with what re-entry says.
    fn new(header: PassageHeader, items: &[f64]) -> Self {
        let rows = items.chunks_exact(PASSAGE_COLUMNS + GIVEN_COLUMNS).filter(|_| header.given != 0);
        let given = rows.flat_map(|row| &row[PASSAGE_COLUMNS..]).copied().collect();
        Self { header, values: curve_in(&header, items), given }
    }
}

/// Takes in the densities that have arrived, refuses those of a case that the run does not have, and reports how many
/// there are.
fn take_densities(
    session: &Session,
    densities: &Inlet<Density>,
    roster: &Roster,
    recording: &mut Recording,
) -> Result<(), Failure> {
    let before = recording.densities.len();
    while let Some(message) = receive(session, densities)? {
        let label = unpack(&message.header().label);
        if roster.is_known() && !roster.takes_part(&label) {
            let why = "it publishes results, but the launch file has no such label";
            refuse::<Density>(session, message.header().scenario, &label, why)?;
        }
        recording.take_density(*message.header(), message.items());
    }
    if roster.is_known() && recording.densities.len() > before {
        let assignment = &recording.assignment;
        let expected = roster.alive() * assignment.times.len();
        session.working(assignment.scenario(), recording.densities.len(), expected)?;
    }
    Ok(())
}

/// The results of a scenario that have arrived.
#[derive(Debug)]
pub(crate) struct Recording {
    assignment: Assignment,
    densities: BTreeMap<(String, u32), Reading>,
    /// By label, kind, snapshot and reference: a restarted comparator sends everything once more, which replaces the
    /// old values.
    comparisons: BTreeMap<(String, u32, u32, String), RecordedComparison>,
    /// By label and shard.
    passages: BTreeMap<(String, u32), RecordedPassage>,
}

impl Recording {
    pub(crate) fn new(assignment: Assignment) -> Self {
        Self { assignment, densities: BTreeMap::new(), comparisons: BTreeMap::new(), passages: BTreeMap::new() }
    }

    /// Adds a density that has passed the screen, if it belongs to this scenario and fits it.
    pub(crate) fn take_density(&mut self, header: DensityHeader, numbers: &[f64]) {
        let fitting = Reading::new(header, numbers, &self.assignment).ok();
        if let Some(reading) = fitting.filter(|_| header.scenario == self.assignment.scenario()) {
            self.densities.insert((unpack(&header.label), header.index), reading);
        }
    }

    pub(crate) fn take_passage(&mut self, header: PassageHeader, values: &[f64]) {
        if header.scenario == self.assignment.scenario() {
            let passage = RecordedPassage::new(header, values);
            self.passages.insert((unpack(&header.label), header.shard), passage);
        }
    }

    pub(crate) fn take_comparison(&mut self, header: ComparisonHeader, values: &[f64]) {
        if header.scenario == self.assignment.scenario() {
            let place = (unpack(&header.label), header.kind, header.index, unpack(&header.reference));
            self.comparisons.insert(place, RecordedComparison { header, values: values.to_vec() });
        }
    }

    /// All snapshots of a case, if they are all there.
    fn case(&self, label: &str) -> Option<Vec<&Reading>> {
        let snapshots: Vec<_> = (0..self.assignment.times.len() as u32)
            .map_while(|index| self.densities.get(&(label.into(), index)))
            .collect();
        (snapshots.len() == self.assignment.times.len()).then_some(snapshots)
    }

    /// The first-passage curve of a case, if one has been sent.
    fn passage(&self, label: &str) -> Option<RecordedPassage> {
        let parts = self.passages.iter().filter(|((of, _), _)| of == label).map(|(_, part)| part);
        passages::merged(&parts.collect::<Vec<_>>())
    }

    /// Labels of the cases that the comparator has finished.
    fn compared(&self) -> impl Iterator<Item = String> {
        let of_effort = self.comparisons.values().filter(|c| c.header.content() == Some(ComparisonKind::Effort));
        of_effort.map(|c| unpack(&c.header.label))
    }

    /// Whether the comparator has finished and every density that it compared has arrived here too.
    pub(crate) fn is_complete(&self) -> bool {
        self.comparisons.values().any(|c| c.header.content() == Some(ComparisonKind::End))
            && self.compared().all(|label| self.case(&label).is_some())
    }

    /// The first case that was compared, has not failed, and whose message on first passages is missing. The
    /// propagator has sent it before its last snapshot, but a message is lost if its publisher ends, and a publisher
    /// does not notice at once a reader that comes late.
    fn without_passage(&self, roster: &Roster) -> Option<String> {
        self.compared().find(|label| !roster.has_failed(label) && !self.has_passage(label))
    }

    /// Whether every process of a case has sent its message on first passages.
    fn has_passage(&self, label: &str) -> bool {
        let mut parts = self.passages.iter().filter(|((of, _), _)| of == label).map(|(_, part)| part);
        parts.next().is_some_and(|part| parts.count() + 1 >= part.header.shards as usize)
    }
}

/// Records scenario after scenario, each into its [`part`] of `folder`, which must exist. If there is a `tape`, a
/// recording that has been begun, every message is added to it. Methods are judged against `tolerance`.
///
/// # Errors
/// [`Failure::Stopped`] is the normal end; [`Failure::File`] if something cannot be written.
pub fn run(session: &Session, folder: &Path, tape: Option<&Path>, tolerance: f64) -> Result<(), Failure> {
    let scenarios = session.domain.inlet::<Scenario>()?;
    let densities = session.domain.inlet::<Density>()?;
    let comparisons = session.domain.inlet::<Comparison>()?;
    let passages = session.domain.inlet::<Passage>()?;
    let rosters = session.domain.inlet::<RosterTopic>()?;
    let mut tape = tape.map(|path| Tape::open(session, path)).transpose()?;
    session.ready()?;
    let mut roster = Roster::default();
    let mut newest = Newest::default();
    let mut current: Option<Recording> = None;
    let mut awaited: Option<String> = None;
    loop {
        roster.update(session, &rosters)?;
        while let Some(message) = receive(session, &scenarios)? {
            if newest.is_news(message.header().scenario) {
                current = Some(Recording::new(Assignment::read(&message)?));
            }
        }
        if let Some(tape) = &mut tape {
            tape.take_all()?;
        }
        if let Some(recording) = &mut current {
            take_densities(session, &densities, &roster, recording)?;
            while let Some(message) = receive(session, &comparisons)? {
                recording.take_comparison(*message.header(), message.items());
            }
            while let Some(message) = receive(session, &passages)? {
                recording.take_passage(*message.header(), message.items());
            }
            let (scenario, count) =
                (recording.assignment.description.scenario, recording.assignment.description.scenarios);
            if roster.is_known() && roster.scenario == scenario && recording.is_complete() {
                let missing = recording.without_passage(&roster);
                if let Some(label) = missing.as_ref().filter(|_| missing != awaited) {
                    let what = "its message on phasecloud/passage, due before its last snapshot";
                    session.waits_for(scenario, label, what, recording.densities.len())?;
                }
                awaited = missing;
                if awaited.is_none() && tape.as_ref().is_none_or(|tape| tape.has_all(recording, &roster)) {
                    write(recording, &roster, &part(folder, scenario), tolerance)?;
                    if scenario + 1 == count {
                        tape.take().map_or(Ok(()), Tape::finish)?;
                    }
                    session.done(scenario)?;
                    current = None;
                    continue;
                }
            }
        }
        let mut ports: Vec<&dyn Awaited> = vec![&scenarios, &densities, &comparisons, &passages, &rosters];
        ports.extend(tape.iter().flat_map(Tape::ports));
        session.wait(&ports)?;
    }
}

#[cfg(test)]
mod tests {
    use messages::text::pack;

    use super::*;

    #[test]
    fn a_passage_that_died_with_its_sender_is_waited_for_unless_the_case_has_failed() {
        let mut recording = Recording::new(kit::example::assignment());
        let roster = |failed| Roster { cases: vec![("mc".into(), failed)], ..Roster::default() };
        assert_eq!(recording.without_passage(&roster(false)), None, "nothing is compared yet");
        let effort =
            ComparisonHeader { kind: ComparisonKind::Effort.code(), label: pack("mc"), ..ComparisonHeader::default() };
        recording.take_comparison(effort, &[0.0; 4]);
        assert_eq!(recording.without_passage(&roster(false)), Some("mc".into()));
        assert_eq!(recording.without_passage(&roster(true)), None);
        recording.take_passage(PassageHeader { label: pack("mc"), ..PassageHeader::default() }, &[]);
        assert_eq!(recording.without_passage(&roster(false)), None);
    }
}

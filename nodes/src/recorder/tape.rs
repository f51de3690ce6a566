//! The tape: every message of the run as it was sent, in one file.
//!
//! The recorder is a reader that publishers wait for, and it calls a scenario done only when all messages of the cases that
//! were compared are on tape, so nothing of them is lost. What cannot be on tape is what is sent after the last result is
//! complete: the last reports on the status topic.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use messages::layout::comparison;
use messages::port::Inlet;
use messages::recording::Writer;
use messages::text::{Label, unpack};
use messages::topic::{Comparison, Density, Passage, Roster as RosterTopic, Scenario, Snapshot, Status, Topic};
use messages::wait::Awaited;

use super::Recording;
use crate::failure::Failure;
use crate::roster::Roster;
use crate::session::Session;

/// A tape under way.
pub(super) struct Tape {
    path: PathBuf,
    writer: Writer,
    scenarios: Inlet<Scenario>,
    snapshots: Inlet<Snapshot>,
    passages: Inlet<Passage>,
    densities: Inlet<Density>,
    comparisons: Inlet<Comparison>,
    reports: Inlet<Status>,
    rosters: Inlet<RosterTopic>,
    snapshots_of: Count,
    passages_of: Count,
    densities_of: Count,
    compared: BTreeSet<u32>,
}

/// How many messages there are of a scenario and a label.
type Count = BTreeMap<(u32, Label), usize>;

impl Tape {
    /// Goes on with a recording that has been begun.
    pub(super) fn open(session: &Session, path: &Path) -> Result<Self, Failure> {
        let domain = &session.domain;
        Ok(Self {
            path: path.into(),
            writer: Writer::append(path).map_err(|e| Failure::file(path, e.problem))?,
            scenarios: domain.inlet()?,
            snapshots: domain.inlet()?,
            passages: domain.inlet()?,
            densities: domain.inlet()?,
            comparisons: domain.inlet()?,
            reports: domain.inlet()?,
            rosters: domain.inlet()?,
            snapshots_of: Count::new(),
            passages_of: Count::new(),
            densities_of: Count::new(),
            compared: BTreeSet::new(),
        })
    }

    /// Takes in what has arrived.
    pub(super) fn take_all(&mut self) -> Result<(), Failure> {
        let Self { path, writer, snapshots_of, passages_of, densities_of, compared, .. } = self;
        take(path, writer, &self.rosters, |_| ())?;
        take(path, writer, &self.scenarios, |_| ())?;
        take(path, writer, &self.snapshots, |h| *snapshots_of.entry((h.scenario, h.label)).or_default() += 1)?;
        take(path, writer, &self.passages, |h| *passages_of.entry((h.scenario, h.label)).or_default() += 1)?;
        take(path, writer, &self.densities, |h| *densities_of.entry((h.scenario, h.label)).or_default() += 1)?;
        take(path, writer, &self.comparisons, |h| {
            if h.kind == comparison::END {
                compared.insert(h.scenario);
            }
        })?;
        take(path, writer, &self.reports, |_| ())
    }

    /// Whether all messages are there of the cases that were compared.
    pub(super) fn has_all(&self, recording: &Recording, roster: &Roster) -> bool {
        let scenario = recording.assignment.scenario;
        let count = recording.assignment.problem.times.len();
        let has = |count: usize, messages: &Count, label: &str| {
            messages.iter().any(|((of, name), have)| *of == scenario && unpack(name) == label && *have >= count)
        };
        self.compared.contains(&scenario)
            && recording.compared().all(|label| {
                has(count, &self.snapshots_of, &label)
                    && has(count, &self.densities_of, &label)
                    && (roster.has_failed(&label) || has(1, &self.passages_of, &label))
            })
    }

    /// Ends the tape with what has arrived.
    pub(super) fn finish(mut self) -> Result<(), Failure> {
        self.take_all()?;
        self.writer.finish().map_err(|e| Failure::file(&self.path, e.problem))
    }

    /// What to wait for.
    pub(super) fn ports(&self) -> [&dyn Awaited; 7] {
        let Self { scenarios, snapshots, passages, densities, comparisons, reports, rosters, .. } = self;
        [scenarios, snapshots, passages, densities, comparisons, reports, rosters]
    }
}

fn take<T: Topic>(
    path: &Path,
    writer: &mut Writer,
    inlet: &Inlet<T>,
    mut count: impl FnMut(&T::Header),
) -> Result<(), Failure> {
    while let Some(message) = inlet.receive()? {
        writer.write::<T>(message.header(), message.items()).map_err(|e| Failure::file(path, e.problem))?;
        count(message.header());
    }
    Ok(())
}

//! The tape: every message of the run as it was sent, in one file.
//!
//! Publishers wait for the recorder, and it reports a scenario as done only when all messages of the cases that were
//! compared are on the tape, so none of these messages is lost. Only messages that are sent after the last result is
//! complete can be missing: the last reports on the status topic.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use messages::comparison_kind::ComparisonKind;
use messages::port::Inlet;
use messages::recording::Writer;
use messages::text::{Label, unpack};
use messages::topic::{Comparison, Density, Passage, Roster as RosterTopic, Scenario, Snapshot, Status, Topic};
use messages::wait::Awaited;

use super::Recording;
use crate::services::roster::Roster;
use kit::failure::Failure;
use kit::session::Session;

/// A tape that is being written.
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
    snapshots_of: BTreeMap<(u32, Label), OfShards>,
    passages_of: BTreeMap<(u32, Label), OfShards>,
    densities_of: Count,
    compared: BTreeSet<u32>,
}

/// Number of messages by scenario and label.
type Count = BTreeMap<(u32, Label), usize>;

/// Number of messages from all shards of a case, and number of these shards.
#[derive(Debug, Default)]
struct OfShards {
    have: usize,
    shards: usize,
}

impl OfShards {
    fn count_one_of(&mut self, shards: u32) {
        (self.have, self.shards) = (self.have + 1, shards.max(1) as usize);
    }
}

impl Tape {
    /// Continues a recording that has been begun.
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
            snapshots_of: BTreeMap::new(),
            passages_of: BTreeMap::new(),
            densities_of: Count::new(),
            compared: BTreeSet::new(),
        })
    }

    /// Records all messages that have arrived.
    pub(super) fn take_all(&mut self) -> Result<(), Failure> {
        let Self { path, writer, snapshots_of, passages_of, densities_of, compared, .. } = self;
        take(path, writer, &self.rosters, |_| ())?;
        take(path, writer, &self.scenarios, |_| ())?;
        take(path, writer, &self.snapshots, |h| {
            snapshots_of.entry((h.scenario, h.label)).or_default().count_one_of(h.shards);
        })?;
        take(path, writer, &self.passages, |h| {
            passages_of.entry((h.scenario, h.label)).or_default().count_one_of(h.shards);
        })?;
        take(path, writer, &self.densities, |h| *densities_of.entry((h.scenario, h.label)).or_default() += 1)?;
        take(path, writer, &self.comparisons, |h| {
            if h.content() == Some(ComparisonKind::End) {
                compared.insert(h.scenario);
            }
        })?;
        take(path, writer, &self.reports, |_| ())
    }

    /// Whether all messages of the cases that were compared have been recorded.
    pub(super) fn has_all(&self, recording: &Recording, roster: &Roster) -> bool {
        let scenario = recording.assignment.scenario();
        let count = recording.assignment.times.len();
        let is_of = |(of, name): &(u32, Label), label: &str| *of == scenario && unpack(name) == label;
        let has = |messages: &BTreeMap<(u32, Label), OfShards>, each: usize, label: &str| {
            messages.iter().any(|(of, case)| is_of(of, label) && case.have >= each * case.shards)
        };
        let has_densities = |label: &str| self.densities_of.iter().any(|(of, have)| is_of(of, label) && *have >= count);
        self.compared.contains(&scenario)
            && recording.compared().all(|label| {
                has(&self.snapshots_of, count, &label)
                    && has_densities(&label)
                    && (roster.has_failed(&label) || has(&self.passages_of, 1, &label))
            })
    }

    /// Records all messages that have arrived, and ends the tape.
    pub(super) fn finish(mut self) -> Result<(), Failure> {
        self.take_all()?;
        self.writer.finish().map_err(|e| Failure::file(&self.path, e.problem))
    }

    /// The ports to wait for.
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

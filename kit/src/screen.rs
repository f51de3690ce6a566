//! Decides which messages a node accepts from a topic.
//!
//! Any process in the domain can send anything, so a message that cannot be right is refused, and its sender is
//! named.
//!
//! There are three questions: does the message belong to this run, may its sender send it, and does it agree with its
//! header? Propagators send only on `snapshot`, `passage` and `status`, and only under their own labels.

use std::collections::BTreeSet;

use messages::comparison_kind::ComparisonKind;
use messages::layout::{
    DISTANCE_COLUMNS, DensityHeader, EFFORT_COLUMNS, ERROR_COLUMNS, GIVEN_COLUMNS, PASSAGE_COLUMNS, PASSAGE_TIMES,
};
use messages::port::{Inlet, Message};
use messages::report::Report;
use messages::scenario::MOST_SNAPSHOTS;
use messages::text::unpack;
use messages::topic::{Comparison, Density, Passage, Roster, Scenario, Snapshot, Status, Topic};

use crate::assignment::Assignment;
use crate::failure::Failure;
use crate::limits::MOST_CASES;
use crate::sender::label_of;
use crate::session::Session;
use crate::shard::MOST_SHARDS;

/// A topic whose messages can be judged.
pub trait Screened: Topic {
    /// The label under which a propagator sends; `None` on topics on which only phasecloud's own processes send.
    fn propagator(header: &Self::Header) -> Option<String>;

    /// Whether header and items fit together.
    ///
    /// # Errors
    /// What does not fit.
    fn check(header: &Self::Header, items: &[Self::Item]) -> Result<(), String>;
}

/// Why a message is refused, and who sent it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// The sender's label, or its process where it has none.
    pub sender: String,
    /// What is wrong.
    pub why: String,
}

/// The next message that is accepted; the others are reported to the launcher.
///
/// # Errors
/// [`Failure::Port`] if the topic cannot be read.
pub fn receive<T: Screened>(session: &Session, inlet: &Inlet<T>) -> Result<Option<Message<T>>, Failure> {
    while let Some(message) = inlet.receive()? {
        let Err(Refusal { sender, why }) = screen(session.run_id, &message) else {
            if T::NAME == Scenario::NAME {
                session.reported_refusals.begin(T::scenario(message.header()));
            }
            return Ok(Some(message));
        };
        refuse::<T>(session, T::scenario(message.header()), &sender, &why)?;
    }
    Ok(None)
}

/// Reports to the launcher, once per scenario, that a message of `sender` on a topic is not used; `scenario` is the
/// one that the message names.
///
/// # Errors
/// [`Failure::Port`] if the launcher cannot be told.
pub fn refuse<T: Topic>(session: &Session, scenario: u32, sender: &str, why: &str) -> Result<(), Failure> {
    let scenario = session.reported_refusals.charged_to(scenario);
    if session.reported_refusals.is_new(scenario, sender, T::NAME) {
        session.case_failed(scenario, sender, why)
    } else {
        Ok(())
    }
}

/// Judges a message.
///
/// # Errors
/// [`Refusal`] if it must not be used.
pub fn screen<T: Screened>(run_id: u64, message: &Message<T>) -> Result<(), Refusal> {
    let process = message.sender();
    let label = process.and_then(label_of);
    judge::<T>(run_id, message.header(), message.items(), label.as_deref()).map_err(|why| Refusal {
        sender: label.unwrap_or_else(|| process.map_or("a process that is gone".into(), |id| format!("process {id}"))),
        why: format!("a message on {}: {why}", T::NAME),
    })
}

/// Judges a message of the propagator `sender`, or of a process that is not known to be a propagator.
fn judge<T: Screened>(run_id: u64, header: &T::Header, items: &[T::Item], sender: Option<&str>) -> Result<(), String> {
    match (sender, T::propagator(header)) {
        (Some(_), None) => return Err("only phasecloud's own processes speak there".into()),
        (Some(sender), Some(label)) if label != sender => {
            return Err(format!("it bears the label \"{}\"", label.escape_default()));
        }
        _ => {}
    }
    if T::run_id(header) != run_id {
        return Err(format!("it belongs to run {:012x}, not to {run_id:012x}", T::run_id(header)));
    }
    T::check(header, items)
}

impl Screened for Scenario {
    fn propagator(_: &Self::Header) -> Option<String> {
        None
    }

    fn check(header: &Self::Header, items: &[f64]) -> Result<(), String> {
        Assignment::from_parts(header, items).map(drop)
    }
}

impl Screened for Snapshot {
    fn propagator(header: &Self::Header) -> Option<String> {
        Some(unpack(&header.label))
    }

    /// The estimator itself checks snapshots, against the scenario.
    fn check(_: &Self::Header, _: &[f64]) -> Result<(), String> {
        Ok(())
    }
}

impl Screened for Density {
    fn propagator(_: &Self::Header) -> Option<String> {
        None
    }

    fn check(header: &Self::Header, items: &[f64]) -> Result<(), String> {
        let DensityHeader { index, count, quantities, .. } = *header;
        // Code that knows the scenario checks whether there are as many as it asks for.
        if items.len() <= 2 * quantities as usize {
            return Err(format!("{} numbers with {quantities} quantities and their errors", items.len()));
        }
        if index >= count || count as usize > MOST_SNAPSHOTS {
            return Err(format!("snapshot {index} of {count}"));
        }
        Ok(())
    }
}

impl Screened for Passage {
    fn propagator(header: &Self::Header) -> Option<String> {
        Some(unpack(&header.label))
    }

    fn check(header: &Self::Header, items: &[f64]) -> Result<(), String> {
        let rows = header.rows as usize;
        let columns = PASSAGE_COLUMNS + if header.given == 0 { 0 } else { GIVEN_COLUMNS };
        if rows > PASSAGE_TIMES || items.len() != rows * columns {
            let numbers = items.len();
            return Err(format!("{numbers} numbers for {rows} rows, at most {PASSAGE_TIMES}, of {columns} numbers"));
        }
        // The probabilities are judged when the curve is recorded: if they are impossible, the case loses its curve,
        // but not its moments.
        match items.chunks_exact(columns).find(|row| !row[0].is_finite()) {
            Some(row) => Err(format!("{} is not a time", row[0])),
            None => Ok(()),
        }
    }
}

impl Screened for Comparison {
    fn propagator(_: &Self::Header) -> Option<String> {
        None
    }

    fn check(header: &Self::Header, items: &[f64]) -> Result<(), String> {
        let length = items.len();
        let is_right = match header.content() {
            Some(ComparisonKind::Moments) => length > 0 && length.is_multiple_of(ERROR_COLUMNS),
            Some(ComparisonKind::Distances) => length > 2 && (length - 2).is_multiple_of(DISTANCE_COLUMNS),
            Some(ComparisonKind::Effort) => length == EFFORT_COLUMNS,
            Some(ComparisonKind::End) => length == 0,
            None => return Err(format!("its kind {} is unknown to this version", header.kind)),
        };
        if !is_right || header.length as usize != length || header.index as usize >= MOST_SNAPSHOTS {
            return Err(format!("{length} numbers where it says {}, for snapshot {}", header.length, header.index));
        }
        Ok(())
    }
}

impl Screened for Roster {
    fn propagator(_: &Self::Header) -> Option<String> {
        None
    }

    fn check(_: &Self::Header, items: &[Self::Item]) -> Result<(), String> {
        let labels: BTreeSet<_> = items.iter().map(|entry| entry.label).collect();
        if labels.len() != items.len() || items.len() > MOST_CASES {
            return Err("labels that repeat, or more than a run can have".into());
        }
        let mut ranks: Vec<u32> = items.iter().map(|entry| entry.reference).filter(|rank| *rank > 0).collect();
        ranks.sort_unstable();
        if ranks.is_empty() || !ranks.iter().copied().eq(1..=ranks.len() as u32) {
            return Err(format!("the references have the places {ranks:?}, not 1, 2 and so on"));
        }
        if let Some(entry) = items.iter().find(|entry| entry.shards > MOST_SHARDS) {
            return Err(format!("a case of {} shards, at most {MOST_SHARDS} are allowed", entry.shards));
        }
        Ok(())
    }
}

impl Screened for Status {
    fn propagator(header: &Self::Header) -> Option<String> {
        // Whatever label it bears, a report in the role of a service is one of that service.
        let sender = Report::sender(header);
        Some(sender.map_or_else(|_| unpack(&header.node), |sender| sender.label().to_owned()))
    }

    fn check(_: &Self::Header, _: &[f64]) -> Result<(), String> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use messages::layout::{SnapshotHeader, StatusHeader, role};
    use messages::text::pack;

    use super::*;

    #[test]
    fn a_propagator_speaks_on_its_own_topics_under_its_own_label() {
        let snapshot = SnapshotHeader { run_id: 7, label: pack("mc"), ..SnapshotHeader::default() };
        assert_eq!(judge::<Snapshot>(7, &snapshot, &[], Some("mc")), Ok(()));
        assert_eq!(judge::<Snapshot>(7, &snapshot, &[], None), Ok(()), "by hand");
        assert!(judge::<Snapshot>(8, &snapshot, &[], Some("mc")).unwrap_err().contains("belongs to run"));
        assert!(judge::<Snapshot>(7, &snapshot, &[], Some("mine")).unwrap_err().contains("the label \"mc\""));
        let shard =
            StatusHeader { run_id: 7, role: role::SHARD, shard: 3, node: pack("mc"), ..StatusHeader::default() };
        assert_eq!(judge::<Status>(7, &shard, &[], Some("mc")), Ok(()));
        let status =
            StatusHeader { run_id: 7, role: role::RECORDER, node: pack("recorder"), ..StatusHeader::default() };
        assert!(judge::<Status>(7, &status, &[], Some("mine")).is_err());
        let posing = StatusHeader { run_id: 7, role: role::RECORDER, node: pack("mine"), ..StatusHeader::default() };
        assert!(judge::<Status>(7, &posing, &[], Some("mine")).unwrap_err().contains("the label \"recorder\""));
        let header = DensityHeader { run_id: 7, quantities: 1, count: 1, ..DensityHeader::default() };
        assert_eq!(judge::<Density>(7, &header, &[1.0; 3], None), Ok(()));
        assert!(judge::<Density>(7, &header, &[1.0; 3], Some("mc")).unwrap_err().contains("own processes"));
    }
}

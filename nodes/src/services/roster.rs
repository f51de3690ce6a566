//! The roster: which cases take part in a run and which have failed, as the launcher reports it.

use std::collections::BTreeMap;

use messages::layout::{RosterEntry, RosterHeader};
use messages::port::Inlet;
use messages::text::unpack;
use messages::topic::Roster as RosterTopic;

use kit::failure::Failure;
use kit::screen::receive;
use kit::session::Session;

/// The cases of a run, and their state in one scenario.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Roster {
    /// Position of that scenario in the run.
    pub scenario: u32,
    /// Labels of the references, in their order: cases are compared with the first that states a quantity and has not
    /// failed.
    pub references: Vec<String>,
    /// Label of the case whose effort is 1, if there is one (Sect. 4.2 of Sun et al. 2022: Monte Carlo's).
    pub baseline: Option<String>,
    /// All labels in the launch file's order, each with whether the case has failed.
    pub cases: Vec<(String, bool)>,
    /// Why cases have failed, by label.
    pub reasons: BTreeMap<String, String>,
    /// How many shards each case has, where that is known.
    pub shards: BTreeMap<String, u32>,
}

impl Roster {
    /// The roster that a message states.
    pub fn new(header: &RosterHeader, items: &[RosterEntry]) -> Self {
        let mut ranked: Vec<_> = items.iter().filter(|entry| entry.reference > 0).collect();
        ranked.sort_by_key(|entry| entry.reference);
        let baseline = items.iter().find(|entry| entry.baseline != 0);
        let split = items.iter().filter(|entry| entry.shards > 0);
        let failed = items.iter().filter(|entry| entry.failed != 0);
        Self {
            scenario: header.scenario,
            references: ranked.into_iter().map(|entry| unpack(&entry.label)).collect(),
            baseline: baseline.map(|entry| unpack(&entry.label)),
            shards: split.map(|entry| (unpack(&entry.label), entry.shards)).collect(),
            reasons: failed.map(|entry| (unpack(&entry.label), unpack(&entry.reason))).collect(),
            cases: items.iter().map(|entry| (unpack(&entry.label), entry.failed != 0)).collect(),
        }
    }

    /// Receives the rosters that the launcher has sent since the last call.
    ///
    /// # Errors
    /// [`Failure::Port`] if the topic cannot be read.
    pub fn update(&mut self, session: &Session, inlet: &Inlet<RosterTopic>) -> Result<(), Failure> {
        while let Some(message) = receive(session, inlet)? {
            *self = Self::new(message.header(), message.items());
        }
        Ok(())
    }

    /// Whether a roster has arrived.
    pub fn is_known(&self) -> bool {
        !self.cases.is_empty()
    }

    /// How many cases take part and have not failed.
    pub fn alive(&self) -> usize {
        self.cases.iter().filter(|(_, failed)| !failed).count()
    }

    /// How many shards the case `label` has, if that is known.
    pub fn shards(&self, label: &str) -> Option<u32> {
        self.shards.get(label).copied()
    }

    /// Whether there is a case `label`.
    pub fn takes_part(&self, label: &str) -> bool {
        self.cases.iter().any(|(name, _)| name == label)
    }

    /// Whether case `label` has failed.
    pub fn has_failed(&self, label: &str) -> bool {
        self.cases.iter().any(|(name, failed)| *failed && name == label)
    }

    /// Why case `label` has failed, if it has and that is known.
    pub fn reason(&self, label: &str) -> Option<&str> {
        self.reasons.get(label).map(String::as_str).filter(|reason| !reason.is_empty())
    }

    /// The references that have not failed, in their order.
    pub fn standing_references(&self) -> impl Iterator<Item = &str> {
        self.references.iter().map(String::as_str).filter(|label| !self.has_failed(label))
    }

    /// Whether the roster of `scenario` has arrived and every case for which `is_complete` does not hold has failed.
    pub fn nothing_more_to_come(&self, scenario: u32, is_complete: impl Fn(&str) -> bool) -> bool {
        self.is_known()
            && self.scenario == scenario
            && self.cases.iter().all(|(label, failed)| *failed || is_complete(label))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_case_is_not_waited_for_but_an_unknown_roster_is() {
        assert!(!Roster::default().nothing_more_to_come(0, |_| true));
        let cases = vec![("mc".into(), false), ("mine".into(), true)];
        let roster = Roster { scenario: 1, references: vec!["mc".into()], cases, ..Roster::default() };
        assert!(roster.nothing_more_to_come(1, |label| label == "mc"));
        assert!(!roster.nothing_more_to_come(1, |label| label == "mine"));
        assert!(!roster.nothing_more_to_come(2, |_| true), "that was about the scenario before");
    }
}

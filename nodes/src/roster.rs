//! Who takes part in a run and who has failed, as the launcher tells.

use messages::port::Inlet;
use messages::text::unpack;
use messages::topic::Roster as RosterTopic;

use crate::failure::Failure;
use crate::screen::receive;
use crate::session::Session;

/// The cases of a run.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Roster {
    /// Label of the case that all are compared with.
    pub reference: String,
    /// All labels in the launch file's order, with whether they have failed.
    pub cases: Vec<(String, bool)>,
}

impl Roster {
    /// Takes in what the launcher has said since.
    ///
    /// # Errors
    /// [`Failure::Port`] if the topic cannot be read.
    pub fn update(&mut self, session: &Session, inlet: &Inlet<RosterTopic>) -> Result<(), Failure> {
        while let Some(message) = receive(session, inlet)? {
            self.reference = unpack(&message.header().reference);
            self.cases = message.items().iter().map(|entry| (unpack(&entry.label), entry.failed != 0)).collect();
        }
        Ok(())
    }

    /// Whether the case `label` takes part and has not failed.
    pub fn is_alive(&self, label: &str) -> bool {
        self.cases.iter().any(|(name, failed)| name == label && !failed)
    }

    /// Whether the roster has arrived and every case for which `is_complete` does not hold has failed.
    pub fn nothing_more_to_come(&self, is_complete: impl Fn(&str) -> bool) -> bool {
        !self.cases.is_empty() && self.cases.iter().all(|(label, failed)| *failed || is_complete(label))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_case_is_not_waited_for_but_an_unknown_roster_is() {
        assert!(!Roster::default().nothing_more_to_come(|_| true));
        let roster = Roster { reference: "mc".into(), cases: vec![("mc".into(), false), ("mine".into(), true)] };
        assert!(roster.nothing_more_to_come(|label| label == "mc"));
        assert!(!roster.nothing_more_to_come(|label| label == "mine"));
    }
}

//! Remembers which refusals of messages a process has reported.

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;

/// Refusals that have been reported, so that each sender is reported only once per scenario and topic.
#[derive(Debug, Default)]
pub struct ReportedRefusals {
    refusals: RefCell<BTreeSet<(u32, String, &'static str)>>,
    /// The newest scenario that this process knows of.
    newest: Cell<u32>,
}

impl ReportedRefusals {
    /// A scenario has begun.
    pub(crate) fn begin(&self, scenario: u32) {
        self.newest.set(scenario);
        self.refusals.borrow_mut().retain(|(of, ..)| *of >= scenario);
    }

    /// The scenario in which a refused message is reported: the one that the message names, which may be over, or
    /// about to begin; if the message names a later one, the newest scenario.
    pub(crate) fn charged_to(&self, claimed: u32) -> u32 {
        let newest = self.newest.get();
        if claimed <= newest.saturating_add(1) { claimed } else { newest }
    }

    /// Whether a refusal has not been reported yet.
    pub(crate) fn is_new(&self, scenario: u32, sender: &str, topic: &'static str) -> bool {
        self.refusals.borrow_mut().insert((scenario, sender.to_owned(), topic))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_is_charged_to_the_scenario_of_its_message_and_told_once_in_each() {
        let told = ReportedRefusals::default();
        told.begin(5);
        assert_eq!([4, 5, 6, 7, u32::MAX].map(|claimed| told.charged_to(claimed)), [4, 5, 6, 5, 5]);
        assert!(told.is_new(5, "mc", "passage") && !told.is_new(5, "mc", "passage"));
        told.begin(6);
        assert!(told.is_new(6, "mc", "passage"), "the next scenario is told of again");
    }
}

//! The processes that a run has besides its propagators.

use crate::layout::role;

/// A process that serves all cases of a run. Its name is the name of its node, so no case may have it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Service {
    /// Publishes the scenarios.
    Scenario,
    /// Turns every snapshot into a density and moments.
    Estimator,
    /// Measures how far every case is from the reference.
    Comparator,
    /// Writes the results.
    Recorder,
    /// Carries messages between hosts.
    Bridge,
}

impl Service {
    /// All services.
    pub const ALL: [Self; 5] = [Self::Scenario, Self::Estimator, Self::Comparator, Self::Recorder, Self::Bridge];
    /// Those that every run needs, in the order in which they are started: the scenario node is the last.
    pub const OF_EVERY_RUN: [Self; 4] = [Self::Estimator, Self::Comparator, Self::Recorder, Self::Scenario];

    /// The name of its node.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Scenario => "scenario",
            Self::Estimator => "estimator",
            Self::Comparator => "comparator",
            Self::Recorder => "recorder",
            Self::Bridge => "bridge",
        }
    }

    /// Its code in [`role`].
    pub const fn code(self) -> u32 {
        match self {
            Self::Scenario => role::SCENARIO,
            Self::Estimator => role::ESTIMATOR,
            Self::Comparator => role::COMPARATOR,
            Self::Recorder => role::RECORDER,
            Self::Bridge => role::BRIDGE,
        }
    }

    /// The service whose node has this name; `None` for a case.
    pub fn named(node: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|service| service.name() == node)
    }

    /// Whether this is the service whose node has this name.
    pub fn is(self, node: &str) -> bool {
        self.name() == node
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_service_is_found_by_its_name_and_a_case_is_none() {
        assert!(Service::ALL.into_iter().all(|service| Service::named(service.name()) == Some(service)));
        assert_eq!(Service::named("mc"), None);
    }
}

//! The topics through which the launcher takes part in a run, and the domain that it holds for everyone.

use std::time::Instant;

use messages::domain::HeldDomain;
use messages::layout::{RosterEntry, RosterHeader};
use messages::port::{Inlet, Outlet, PortError};
use messages::text::pack;
use messages::topic::{Capacity, Roster, Scenario, Status};

use super::{Abort, Run};
use crate::crew::commands::Commands;
use crate::plan::cases::Case;

/// The launcher's ports, which are closed before the domain.
pub(super) struct Topics {
    pub(super) reports: Inlet<Status>,
    pub(super) roster: Outlet<Roster>,
    pub(super) scenarios: Inlet<Scenario>,
    pub(super) domain: HeldDomain,
    /// When the places of dead processes were freed last.
    pub(super) cleaned: Instant,
}

impl Topics {
    /// Opens the domain with room for `capacity`.
    pub(super) fn open(commands: &Commands<'_>, capacity: &Capacity) -> Result<Self, PortError> {
        let domain = HeldDomain::create(commands.place, capacity)?;
        Ok(Self {
            reports: domain.domain.inlet()?,
            roster: domain.domain.outlet(commands.launch.cases.len())?,
            scenarios: domain.domain.inlet()?,
            domain,
            cleaned: Instant::now(),
        })
    }

    /// Frees the places that dead processes have held on the topics.
    pub(super) fn clean(&mut self) {
        self.domain.domain.clean_up_after_the_dead();
        self.cleaned = Instant::now();
    }
}

impl Run<'_> {
    /// Publishes who takes part in the scenario under way, and who has failed in it.
    pub(super) fn publish_roster(&self) -> Result<(), Abort> {
        let launch = self.commands.launch;
        let scenario = self.course.scenario;
        let header = RosterHeader { run_id: self.commands.run_id, scenario, reserved: 0 };
        let entry = |case: &Case| RosterEntry {
            label: pack(&case.label),
            failed: u32::from(self.has_failed(&case.label)),
            reason: self.troubles.failures.get(&(scenario, case.label.clone())).map_or([0; 1024], |why| pack(why)),
            shards: case.shards,
            reference: launch.references.iter().position(|label| *label == case.label).map_or(0, |k| k as u32 + 1),
            baseline: u32::from(launch.baseline.as_ref() == Some(&case.label)),
        };
        let entries: Vec<RosterEntry> = launch.cases.iter().map(entry).collect();
        Ok(self.topics.roster.send_items(header, &entries)?)
    }
}

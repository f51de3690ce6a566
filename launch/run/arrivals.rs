//! The beginning of a run: hosts join, and processes report that they are ready. A run over several hosts begins when
//! all of them are there.

use std::collections::BTreeSet;

use super::Run;

/// Who has yet to arrive.
pub(super) struct Arrivals {
    /// The hosts that have not joined yet; until they have, nothing but the bridge is started.
    pub(super) absent: BTreeSet<String>,
    /// Whether all processes have been ready once.
    all_ready: bool,
}

impl Arrivals {
    /// Waits for these hosts.
    pub(super) fn of(hosts: &[String]) -> Self {
        Self { absent: hosts.iter().cloned().collect(), all_ready: false }
    }
}

impl Run<'_> {
    /// Prints which hosts the run waits for.
    pub(super) fn announce_hosts(&self) {
        if let Some(hosts) = &self.commands.launch.hosts {
            let names = hosts.names.join(", ");
            let endpoint = &hosts.access.endpoint;
            self.view.note(&format!("waiting for {names}: phasecloud join --connect {endpoint} --name NAME"));
        }
    }

    /// Notes that a host has joined.
    pub(super) fn take_in(&mut self, host: &str) {
        if !self.arrivals.absent.remove(host) {
            return;
        }
        self.view.note(&format!("{host} has joined"));
        if self.arrivals.absent.is_empty() {
            self.processes.forget_silence();
        }
    }

    /// Notes when all processes are ready for the first time.
    pub(super) fn note_when_all_are_ready(&mut self) {
        if !self.arrivals.all_ready && self.processes.members.values().all(|member| member.ready) {
            self.arrivals.all_ready = true;
            self.view.note(&format!("{} processes are ready", self.processes.members.len()));
        }
    }
}

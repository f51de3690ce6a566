//! Other hosts: a run over several begins when all of them are there.

use std::time::Instant;

use super::Run;

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
        if !self.absent.remove(host) {
            return;
        }
        self.view.note(&format!("{host} has joined"));
        if self.absent.is_empty() {
            let now = Instant::now();
            self.members.values_mut().for_each(|member| member.heard = now);
        }
    }
}

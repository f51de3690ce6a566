//! Other hosts: a run over several begins when all of them are there.

use std::time::Instant;

use super::Run;

impl Run<'_> {
    /// Says whom the run waits for.
    pub(super) fn announce_hosts(&self) {
        if let Some(hosts) = &self.commands.launch.hosts {
            let names = hosts.names.join(", ");
            let endpoint = &hosts.access.endpoint;
            self.view.note(&format!("waiting for {names}: phasecloud join --connect {endpoint} --name NAME"));
        }
    }

    /// A host has joined, or the bridge itself is ready.
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

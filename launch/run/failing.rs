//! What goes wrong: processes that end, cases that fail.

use std::time::Instant;

use messages::reporter::Reporter;

use super::{Abort, Run};
use crate::crew::processes::Sequel;

impl Run<'_> {
    /// Deals with a process that has ended before the run did: starts it again if that may help.
    pub(super) fn deal_with_end(&mut self, name: &str, status: std::process::ExitStatus) -> Result<(), Abort> {
        self.processes.clean_up_after(name, &self.topics.domain);
        let has_failed = self.has_failed(name);
        match self.processes.after_end(name, status, has_failed) {
            Sequel::Nothing => Ok(()),
            Sequel::Restart => {
                self.view.note(&format!("{name}: {status}; it is started again"));
                Ok(())
            }
            Sequel::Loss(why) => self.fail(name, why),
        }
    }

    /// Whether a process, or the case that it is a shard of, has failed in the scenario under way.
    pub(super) fn has_failed(&self, name: &str) -> bool {
        self.troubles.failures.contains_key(&(self.course.scenario, self.subject(name).to_owned()))
    }

    /// The label of the case to which the process `name` belongs; `name` itself for all others.
    pub(super) fn subject<'n>(&'n self, name: &'n str) -> &'n str {
        self.processes.members.get(name).map_or(name, |member| member.who.label())
    }

    pub(super) fn is_case(&self, name: &str) -> bool {
        self.commands.launch.cases.iter().any(|case| case.label == name)
    }

    /// Fails and ends the case `sender`, of which another process has complained; any other sender is noted as a
    /// stranger.
    pub(super) fn blame(&mut self, sender: &str, why: String) -> Result<(), Abort> {
        let name: String = sender.escape_debug().collect();
        if self.is_case(&name) {
            self.fail(&name, why)?;
            self.kill_case(&name, None);
        } else {
            self.name_stranger(name, why);
        }
        Ok(())
    }

    /// Notes what was wrong with a sender that is no case, or with a scenario that was refused.
    pub(super) fn name_stranger(&mut self, name: String, why: String) {
        self.view.error(&format!("{name}: {why}"));
        tracing::warn!("{name}: {why}");
        self.troubles.strangers.insert(name, why);
    }

    /// Notes a failure. A case that fails is left out of the scenario's comparison; without a service there is no run.
    pub(super) fn fail(&mut self, name: &str, why: String) -> Result<(), Abort> {
        if self.processes.members.get(name).is_some_and(|member| member.who.service().is_some()) {
            return Err(Abort::Fatal(format!("{name}: {why}")));
        }
        if !self.has_failed(name) {
            let label = self.subject(name).to_owned();
            let why = if label == name { why } else { format!("{name}: {why}") };
            self.view.fail(&Reporter::case(label.as_str()), &why);
            tracing::warn!("{label} has failed: {why}");
            // Without one of its shards a case has no result.
            self.kill_case(&label, Some(name));
            for member in self.processes.members.values_mut() {
                if member.who.label() == label {
                    member.is_dismissed = true;
                } else if member.who.service().is_some() {
                    // The services have waited for the case, and now have something to do.
                    member.heard = Instant::now();
                }
            }
            self.troubles.failures.insert((self.course.scenario, label), why);
            self.publish_roster()?;
        }
        Ok(())
    }

    /// Ends the processes of a case except `spared`; a case without shards has one process.
    pub(super) fn kill_case(&mut self, label: &str, spared: Option<&str>) {
        let members = self.processes.members.iter().filter(|(_, member)| member.who.label() == label);
        for (name, _) in members.filter(|(name, _)| Some(name.as_str()) != spared) {
            self.processes.supervisor.kill(name);
        }
    }
}

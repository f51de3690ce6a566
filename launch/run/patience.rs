//! The end of patience: a process that owes work and is silent is named and ended.

use std::time::{Duration, Instant};

use messages::service::Service;

use super::{Abort, Run};
use crate::crew::member::{Member, STARTUP};
use crate::plan::cases::Case;
use crate::plan::launch_file::Restart;

impl Run<'_> {
    /// Kills the processes that owe work and have not been heard of for too long; a case that was silent has failed.
    pub(super) fn give_up_on_the_silent(&mut self) -> Result<(), Abort> {
        let now = Instant::now();
        if !self.arrivals.absent.is_empty() {
            return self.give_up_on_absent_hosts(now);
        }
        let late: Vec<String> =
            self.processes.members.iter().filter(|(_, m)| m.is_late(now)).map(|(name, _)| name.clone()).collect();
        for name in late {
            self.fail(&name, format!("not ready within {} s", STARTUP.as_secs()))?;
            self.processes.supervisor.kill(&name);
        }
        if self.course.in_all.is_none() && self.course.current().is_none() {
            return Ok(()); // a service that has no request
        }
        let patience = Duration::from_secs_f64(self.commands.launch.patience.min(1e9));
        let is_silent = |member: &Member| member.due.is_none() && now > member.heard + patience;
        let silent: Vec<String> = self
            .commands
            .launch
            .cases
            .iter()
            .flat_map(Case::members)
            .map(|(name, _)| name)
            // Before a scenario is published, only the scenario node owes work for it.
            .filter(|name| self.course.current().is_some() && !self.has_failed(name))
            .filter(|name| self.processes.members.get(name).is_some_and(|member| member.owes && is_silent(member)))
            .collect();
        for name in silent {
            self.fail(&name, format!("no sign of life for {} s", self.commands.launch.patience))?;
            self.processes.supervisor.kill(&name);
        }
        let hindrance = self.hindrance();
        if self.processes.members.values().all(is_silent) {
            let patience = self.commands.launch.patience;
            match self.whom_it_waits_for(hindrance) {
                Some((label, what)) => {
                    self.fail(&label, format!("the {hindrance} has waited {patience} s for {what}"))?;
                    self.processes.supervisor.kill(&label);
                }
                None => {
                    self.view.error(&format!("{hindrance}: no sign of life for {patience} s"));
                    self.processes.supervisor.kill(hindrance);
                }
            }
            for member in self.processes.members.values_mut() {
                member.heard = now;
            }
        }
        Ok(())
    }

    /// Ends a run whose hosts do not join.
    fn give_up_on_absent_hosts(&self, now: Instant) -> Result<(), Abort> {
        let patience = Duration::from_secs_f64(self.commands.launch.patience.min(1e9));
        if self.processes.members.values().all(|member| now < member.heard + patience) {
            return Ok(());
        }
        let absent: Vec<&str> = self.arrivals.absent.iter().map(String::as_str).collect();
        let seconds = self.commands.launch.patience;
        Err(Abort::Fatal(format!("{} did not join within {seconds} s", absent.join(", "))))
    }

    /// The case for which the process `hindrance` waits, and what it waits for. The process is believed only if a
    /// restart has not helped, or is not allowed.
    fn whom_it_waits_for(&self, hindrance: &str) -> Option<(String, String)> {
        let never = self.commands.launch.restart == Restart::Never;
        let has_had_its_chance = never || self.processes.members.get(hindrance).is_some_and(Member::was_restarted);
        self.course.awaited.get(hindrance).filter(|(label, _)| has_had_its_chance && !self.has_failed(label)).cloned()
    }

    /// The process for which all others wait, if all cases have done their work.
    fn hindrance(&self) -> &'static str {
        let Some(known) = self.course.current() else { return Service::Scenario.name() };
        let cases = self.commands.launch.cases.iter().filter(|case| !self.has_failed(&case.label)).count();
        let service = match () {
            () if self.course.compared => Service::Recorder,
            () if self.course.estimated >= cases as u64 * u64::from(known.snapshots) => Service::Comparator,
            () => Service::Estimator,
        };
        service.name()
    }
}

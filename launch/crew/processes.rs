//! The processes that one launcher looks after: each is started when it is due, started again where that may help, and
//! left stopped until the next scenario where it does not. A launcher and a worker host do this in the same way.

use std::collections::BTreeMap;
use std::process::{Command, ExitStatus};
use std::time::Instant;

use messages::domain::HeldDomain;
use messages::reporter::Reporter;

use super::ending;
use super::member::{MOST_RESTARTS, Member};
use super::supervisor::Supervisor;

/// The processes of a run, or of a worker host's share of it.
pub struct Processes {
    /// The processes as children of this one.
    pub supervisor: Supervisor,
    /// The processes by name, those on other hosts too.
    pub members: BTreeMap<String, Member>,
    /// Whether a process that fails is started again.
    restarts: bool,
}

/// What follows from the end of a process.
#[derive(Debug, PartialEq, Eq)]
pub enum Sequel {
    /// Its end was expected, or it belongs to no case or service of the run.
    Nothing,
    /// It is started again.
    Restart,
    /// It stays stopped until the next scenario, since starting it again is not allowed or has not helped: why it
    /// ended.
    Loss(String),
}

impl Processes {
    /// Processes that have not been started yet; `restarts` says whether one that fails is started again.
    pub fn new(supervisor: Supervisor, members: BTreeMap<String, Member>, restarts: bool) -> Self {
        Self { supervisor, members, restarts }
    }

    /// When the next process is to be started.
    pub fn next_due(&self) -> Option<Instant> {
        self.members.values().filter_map(|member| member.due).min()
    }

    /// Starts the processes that are due and `may_start`, each with the `command` for its name and the number of its
    /// attempt. Returns those that cannot be started, and why.
    pub fn start_what_is_due(
        &mut self,
        may_start: impl Fn(&Reporter) -> bool,
        command: impl Fn(&str, u32) -> Result<Command, String>,
    ) -> Vec<(String, String)> {
        let now = Instant::now();
        let is_due =
            |(_, member): &(&String, &mut Member)| member.due.is_some_and(|due| due <= now) && may_start(&member.who);
        let mut failed = Vec::new();
        for (name, member) in self.members.iter_mut().filter(is_due) {
            member.started(now);
            if let Err(why) = command(name, member.attempt).and_then(|command| self.supervisor.start(name, command)) {
                failed.push((name.clone(), why));
            }
        }
        failed
    }

    /// Removes what an ended process has left: its own processes, and its places on the topics, which its successor
    /// needs.
    pub fn clean_up_after(&self, name: &str, domain: &HeldDomain) {
        self.supervisor.kill_leftovers(name);
        domain.domain.clean_up_after_the_dead();
    }

    /// Decides what follows from the end of a process; `has_failed` says whether its case has failed in the scenario
    /// under way.
    pub fn after_end(&mut self, name: &str, status: ExitStatus, has_failed: bool) -> Sequel {
        let may_restart = self.restarts && !status.success();
        let Some(member) = self.members.get_mut(name) else { return Sequel::Nothing };
        if has_failed {
            // The reason is known already; the process is started again with the next scenario.
            member.rest();
            return Sequel::Nothing;
        }
        if std::mem::take(&mut member.is_dismissed) {
            // Its case failed in the previous scenario, and this one began before the process had ended.
            member.plan_restart(Instant::now());
            return Sequel::Nothing;
        }
        if may_restart && member.plan_restart(Instant::now()) {
            tracing::warn!("{name} has ended, {status}; it is started again");
            return Sequel::Restart;
        }
        member.rest();
        let restarted = if may_restart { format!(", also after {MOST_RESTARTS} restarts") } else { String::new() };
        Sequel::Loss(format!("{}{restarted}", ending::explain(status)))
    }

    /// Notes that the next scenario begins: every process has work again, and its restarts.
    pub fn begin_scenario(&mut self) {
        let now = Instant::now();
        self.members.values_mut().for_each(|member| member.begin_scenario(now));
    }

    /// Counts the silence of all processes from now on.
    pub fn forget_silence(&mut self) {
        let now = Instant::now();
        self.members.values_mut().for_each(|member| member.heard = now);
    }

    /// How often a process has been started again in the whole run.
    pub fn restarts_of(&self, name: &str) -> u32 {
        self.members.get(name).map_or(0, |member| member.attempt)
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::process::ExitStatusExt;

    use messages::reporter::Reporter;

    use super::*;

    fn one(restarts: bool) -> Processes {
        let members = BTreeMap::from([("mc".to_owned(), Member::new(Reporter::case("mc"), Instant::now()))]);
        Processes::new(Supervisor::default(), members, restarts)
    }

    fn killed() -> ExitStatus {
        ExitStatus::from_raw(9)
    }

    #[test]
    fn a_process_that_dies_is_started_again_a_few_times_and_then_lost_until_the_next_scenario() {
        let mut processes = one(true);
        for _ in 0..MOST_RESTARTS {
            assert_eq!(processes.after_end("mc", killed(), false), Sequel::Restart);
        }
        let Sequel::Loss(why) = processes.after_end("mc", killed(), false) else { panic!("it has no chance left") };
        assert!(why.contains("also after 3 restarts"), "{why}");
        processes.begin_scenario();
        assert_eq!(processes.after_end("mc", killed(), false), Sequel::Restart);
    }

    #[test]
    fn a_process_that_ends_well_too_early_or_must_not_be_started_again_is_lost_at_once() {
        assert!(matches!(one(true).after_end("mc", ExitStatus::from_raw(0), false), Sequel::Loss(_)));
        assert!(matches!(one(false).after_end("mc", killed(), false), Sequel::Loss(_)));
    }

    #[test]
    fn the_end_of_a_process_whose_case_has_failed_is_no_news() {
        let mut processes = one(true);
        assert_eq!(processes.after_end("mc", killed(), true), Sequel::Nothing);
        processes.members.get_mut("mc").unwrap().is_dismissed = true;
        assert_eq!(processes.after_end("mc", killed(), false), Sequel::Nothing);
        assert_eq!(processes.after_end("stranger", killed(), false), Sequel::Nothing);
    }

    #[test]
    fn only_what_is_due_and_allowed_is_started_and_what_cannot_be_is_named() {
        let mut processes = one(true);
        let nowhere = |_: &str, _: u32| Ok(Command::new("/nowhere/at/all"));
        assert!(processes.start_what_is_due(|_| false, nowhere).is_empty());
        let failed = processes.start_what_is_due(|_| true, nowhere);
        assert!(failed.len() == 1 && failed[0].0 == "mc" && failed[0].1.contains("/nowhere/at/all"), "{failed:?}");
        assert!(processes.next_due().is_none() && processes.start_what_is_due(|_| true, nowhere).is_empty());
    }
}

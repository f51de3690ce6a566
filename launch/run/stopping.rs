//! A request to stop: what is finished is kept. A second request discards everything.

use super::{Abort, Run};
use crate::plan::cases::Case;

/// A request to stop, and what it has left out.
pub(super) struct Stopping {
    /// Whether what is finished is kept after a request to stop.
    keeps: bool,
    /// The scenario that was under way at the first request to stop, if there was one.
    since: Option<u32>,
    /// The cases of the last scenario that were left out because of the request to stop.
    cut: Vec<String>,
}

impl Stopping {
    /// Nobody has asked to stop; `keeps` says whether what is finished is kept if somebody does.
    pub(super) fn new(keeps: bool) -> Self {
        Self { keeps, since: None, cut: Vec::new() }
    }
}

impl Run<'_> {
    /// Follows a request of the user to stop. At the first request the cases that have delivered all their snapshots
    /// are compared and recorded, the others are left out.
    pub(super) fn heed_request(&mut self) -> Result<(), Abort> {
        let requests = self.signals.take_requests();
        if !self.stopping.keeps || self.stopping.since.is_some() || requests > 1 {
            return Err(Abort::Interrupted);
        }
        self.stopping.since = Some(self.course.scenario);
        let at_work: Vec<String> = self.cases_where(|run, case| run.is_at_work(case));
        let has_finished = |run: &Self, case: &Case| !run.is_at_work(case) && !run.has_failed(&case.label);
        if self.course.current().is_none() || self.cases_where(has_finished).is_empty() {
            return Err(Abort::Stopped);
        }
        self.view.announce(
            "stopping: what is finished by now, if anything is, is written; another Ctrl-C discards everything",
        );
        for label in &at_work {
            self.fail(label, "it had not finished when the run was stopped".into())?;
            self.kill_case(label, None);
        }
        self.stopping.cut = at_work;
        Ok(())
    }

    /// Whether there was a request to stop, and what was finished is recorded.
    pub(super) fn has_closed(&self) -> bool {
        self.stopping.since.is_some_and(|scenario| self.course.scenario > scenario)
    }

    /// Why the results are not whole, if they are not.
    pub fn incompleteness(&self) -> Option<String> {
        let scenarios = &self.commands.launch.scenarios;
        let name = |position: usize| scenarios.get(position).map_or("", |input| input.content.name());
        let (recorded, all) = (self.course.scenario as usize, scenarios.len());
        let mut missing = Vec::new();
        if !self.stopping.cut.is_empty() {
            missing.push(format!("{} of {}", self.stopping.cut.join(", "), name(recorded.saturating_sub(1))));
        }
        missing.extend((recorded..all).map(|position| format!("all of {}", name(position))));
        (!missing.is_empty()).then(|| format!("the run was stopped on request; missing: {}", missing.join("; ")))
    }

    fn cases_where(&self, holds: impl Fn(&Self, &Case) -> bool) -> Vec<String> {
        let cases = self.commands.launch.cases.iter().filter(|case| holds(self, case));
        cases.map(|case| case.label.clone()).collect()
    }
}

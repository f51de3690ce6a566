//! A request to stop: what is finished is kept. A second request discards everything.

use super::{Abort, Run};
use crate::plan::cases::Case;

impl Run<'_> {
    /// Follows a request of the user to stop. At the first request the cases that have delivered all their snapshots
    /// are compared and recorded, the others are left out.
    pub(super) fn heed_request(&mut self) -> Result<(), Abort> {
        let requests = self.signals.take_requests();
        if !self.keeps || self.closing.is_some() || requests > 1 {
            return Err(Abort::Interrupted);
        }
        self.closing = Some(self.scenario);
        let at_work: Vec<String> = self.cases_where(|run, case| run.is_at_work(case));
        let has_finished = |run: &Self, case: &Case| !run.is_at_work(case) && !run.has_failed(&case.label);
        if self.current().is_none() || self.cases_where(has_finished).is_empty() {
            return Err(Abort::Stopped);
        }
        self.view.announce("stopping: what is finished is written; another Ctrl-C discards everything");
        for label in &at_work {
            self.fail(label, "it had not finished when the run was stopped".into())?;
            self.kill_case(label, None);
        }
        self.cut = at_work;
        Ok(())
    }

    /// Whether there was a request to stop, and what was finished is recorded.
    pub(super) fn has_closed(&self) -> bool {
        self.closing.is_some_and(|scenario| self.scenario > scenario)
    }

    /// Why the results are not whole, if they are not.
    pub fn incompleteness(&self) -> Option<String> {
        let scenarios = &self.commands.launch.scenarios;
        let name = |position: usize| scenarios.get(position).map_or("", |input| input.content.name.as_str());
        let (recorded, all) = (self.scenario as usize, scenarios.len());
        let mut missing = Vec::new();
        if !self.cut.is_empty() {
            missing.push(format!("{} of {}", self.cut.join(", "), name(recorded.saturating_sub(1))));
        }
        missing.extend((recorded..all).map(|position| format!("all of {}", name(position))));
        (!missing.is_empty()).then(|| format!("the run was stopped on request; missing: {}", missing.join("; ")))
    }

    fn cases_where(&self, holds: impl Fn(&Self, &Case) -> bool) -> Vec<String> {
        let cases = self.commands.launch.cases.iter().filter(|case| holds(self, case));
        cases.map(|case| case.label.clone()).collect()
    }
}

//! The budgets of the cases: a case that takes longer than its `most_seconds` is left out of the scenario.

use std::time::{Duration, Instant};

use super::{Abort, Run};
use crate::plan::cases::Case;

impl Run<'_> {
    /// Ends the cases that have used up their budgets; they get another chance with the next scenario.
    pub(super) fn end_what_takes_too_long(&mut self) -> Result<(), Abort> {
        let now = Instant::now();
        let over = self.budgets().filter(|(_, _, end)| *end <= now);
        let over: Vec<(String, f64)> = over.map(|(case, most, _)| (case.label.clone(), most)).collect();
        for (label, most) in over {
            self.fail(&label, format!("it has used its budget of {most} s (most_seconds)"))?;
            self.kill_case(&label, None);
        }
        Ok(())
    }

    /// When the next budget will be used up.
    pub(super) fn next_end_of_a_budget(&self) -> Option<Instant> {
        self.budgets().map(|(_, _, end)| end).min()
    }

    /// The cases at work that have a budget, with its seconds and its end.
    fn budgets(&self) -> impl Iterator<Item = (&Case, f64, Instant)> {
        let since = self.course.current().map(|known| known.since);
        let cases = self.commands.launch.cases.iter().filter(|case| self.is_at_work(case));
        cases.filter_map(move |case| {
            let most = case.most_seconds?;
            Some((case, most, since? + Duration::from_secs_f64(most)))
        })
    }

    /// Whether a case has work left in the scenario under way.
    pub(super) fn is_at_work(&self, case: &Case) -> bool {
        let owes = |name: &str| self.processes.members.get(name).is_some_and(|member| member.owes);
        !self.has_failed(&case.label) && case.members().any(|(name, _)| owes(&name))
    }
}

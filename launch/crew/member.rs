//! A process of the run as the launcher sees it: whether it runs, whether it owes work, when it is started again.

use std::time::{Duration, Instant};

use messages::reporter::Reporter;

/// Most restarts of a process in one scenario.
pub const MOST_RESTARTS: u32 = 3;
/// Wait before the first restart in a scenario; it doubles with each further one.
const BACK_OFF: Duration = Duration::from_millis(100);
/// Longest that a process may take to report that it is ready.
pub const STARTUP: Duration = Duration::from_secs(60);

/// A process of the run.
#[derive(Debug)]
pub struct Member {
    /// Which process it is.
    pub who: Reporter,
    /// When it is to be started, if it does not run.
    pub due: Option<Instant>,
    /// Whether it has reported that it is ready since its last start.
    pub ready: bool,
    /// When it was last heard of, or started.
    pub heard: Instant,
    /// Whether it has work to do in the scenario under way.
    pub owes: bool,
    /// How often it has been restarted in the whole run.
    pub attempt: u32,
    /// How often it has been restarted in the scenario under way.
    restarts: u32,
    /// Whether it is not started again before the next scenario.
    pub rests: bool,
    /// Whether its case has failed and it has not worked since: its end is then expected, not a new failure.
    pub is_dismissed: bool,
}

impl Member {
    /// A process to be started at `due`.
    pub fn new(who: Reporter, due: Instant) -> Self {
        Self {
            who,
            due: Some(due),
            ready: false,
            heard: due,
            owes: true,
            attempt: 0,
            restarts: 0,
            rests: false,
            is_dismissed: false,
        }
    }

    /// A process on another host, which is started and looked after there.
    pub fn away(who: Reporter, now: Instant) -> Self {
        Self { due: None, ..Self::new(who, now) }
    }

    /// Notes that it has been started.
    pub fn started(&mut self, now: Instant) {
        (self.due, self.ready, self.heard, self.is_dismissed) = (None, false, now, false);
    }

    /// Notes that it works on the scenario under way; `owes` says whether it has more to do.
    pub fn is_at_work(&mut self, owes: bool) {
        (self.owes, self.is_dismissed) = (owes, false);
    }

    /// Plans a restart after a pause; returns `false` if it has used up its restarts in this scenario.
    pub fn plan_restart(&mut self, now: Instant) -> bool {
        let has_chances = self.restarts < MOST_RESTARTS;
        if has_chances {
            self.due = Some(now + BACK_OFF * 2u32.pow(self.restarts));
            self.restarts += 1;
            self.attempt += 1;
        }
        has_chances
    }

    /// Leaves it stopped until the next scenario begins.
    pub fn rest(&mut self) {
        self.rests = true;
    }

    /// Whether it has been started again in the scenario under way.
    pub fn was_restarted(&self) -> bool {
        self.restarts > 0
    }

    /// Notes that the next scenario begins.
    pub fn begin_scenario(&mut self, now: Instant) {
        (self.owes, self.heard, self.restarts) = (true, now, 0);
        if std::mem::take(&mut self.rests) {
            self.plan_restart(now);
        }
    }

    /// Whether it has been started and has not reported for longer than a start may take.
    pub fn is_late(&self, now: Instant) -> bool {
        self.due.is_none() && !self.ready && !self.rests && now > self.heard + STARTUP
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_has_a_few_chances_a_scenario_with_growing_pauses() {
        let now = Instant::now();
        let mut member = Member::new(Reporter::case("mc"), now);
        let pauses: Vec<_> = (0..MOST_RESTARTS)
            .map(|_| {
                assert!(member.plan_restart(now));
                member.due.unwrap() - now
            })
            .collect();
        assert!(pauses.windows(2).all(|pair| pair[1] == 2 * pair[0]), "{pauses:?}");
        assert!(!member.plan_restart(now));
        member.begin_scenario(now);
        assert!(member.plan_restart(now), "the next scenario is a new chance");
        assert_eq!(member.attempt, MOST_RESTARTS + 1, "attempts are numbered through");
    }
}

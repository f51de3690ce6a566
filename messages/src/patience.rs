//! Clocks that leave out the time in which their own process did not run.
//!
//! A process that was stopped, or got no CPU time, cannot say that others were silent in that time.

use std::time::{Duration, Instant};

/// Longest pause between two looks at the clock that counts in full; every process looks at least once per second.
const LONGEST_GAP: Duration = Duration::from_millis(1500);

/// Counts the time in which a process looks at the clock regularly. A pause that is longer than `LONGEST_GAP` counts
/// as `LONGEST_GAP`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Attention {
    seen: Duration,
    counted: Duration,
}

impl Attention {
    /// Takes the time that has passed since the beginning, and returns how much of it counts. A time that is less
    /// than at the last look means that there is a new beginning.
    pub fn count(&mut self, passed: Duration) -> Duration {
        if passed < self.seen {
            *self = Self::default();
        }
        self.counted += (passed - self.seen).min(LONGEST_GAP);
        self.seen = passed;
        self.counted
    }

    /// How much of the time up to the last look does not count.
    fn missed(&self) -> Duration {
        self.seen - self.counted
    }
}

/// A clock that stands still while its process is stopped.
#[derive(Debug, Clone, Copy)]
pub struct Watch {
    begun: Instant,
    attention: Attention,
}

impl Watch {
    /// Begins now.
    pub fn start() -> Self {
        Self { begun: Instant::now(), attention: Attention::default() }
    }

    /// The time that counts since the beginning.
    pub fn elapsed(&mut self) -> Duration {
        self.attention.count(self.begun.elapsed())
    }

    /// The time since the last look that does not count.
    pub fn missed(&mut self) -> Duration {
        let before = self.attention.missed();
        self.attention.count(self.begun.elapsed());
        self.attention.missed() - before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_an_hour_in_which_nobody_looked_only_the_longest_gap_counts() {
        let mut attention = Attention::default();
        let second = Duration::from_secs(1);
        assert_eq!(attention.count(second), second);
        assert_eq!(attention.count(second * 3601), second + LONGEST_GAP);
        assert_eq!(attention.count(second * 3602), second * 2 + LONGEST_GAP);
        assert_eq!(attention.count(second / 2), second / 2, "a new beginning");
    }
}

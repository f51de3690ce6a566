//! Time that passes while a process looks on. Whoever was stopped himself, or got no turn, has no right to call others silent.

use std::time::{Duration, Instant};

/// Longest pause between two looks that counts in full; every process looks around at least once a second.
const LONGEST_GAP: Duration = Duration::from_millis(1500);

/// Counts the time that passes while a process looks on: of a longer gap between two looks only its beginning.
#[derive(Debug, Clone, Copy, Default)]
pub struct Attention {
    seen: Duration,
    counted: Duration,
}

impl Attention {
    /// Takes in how much time has passed since the beginning, less than at the last look if that is a new one. Returns how
    /// much of it counts.
    pub fn count(&mut self, passed: Duration) -> Duration {
        if passed < self.seen {
            *self = Self::default();
        }
        self.counted += (passed - self.seen).min(LONGEST_GAP);
        self.seen = passed;
        self.counted
    }

    /// How much of the time taken in does not count.
    fn missed(&self) -> Duration {
        self.seen - self.counted
    }
}

/// A clock that stands still while its process does.
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

//! How far a map is, once every few seconds.

use std::time::{Duration, Instant};

use humantime::format_duration;

/// Time between two lines.
const PAUSE: Duration = Duration::from_secs(3);

/// How far a map is.
#[derive(Debug)]
pub(super) struct Progress {
    /// The most that there can be to compute.
    most: usize,
    /// How much was there at the start.
    before: usize,
    begun: Instant,
    said: Instant,
    is_quiet: bool,
}

impl Progress {
    pub(super) fn new(most: usize, before: usize, is_quiet: bool) -> Self {
        let now = Instant::now();
        if before > 0 && !is_quiet {
            remark!("the map was begun before: {before} of at most {most} parts are there");
        }
        Self { most, before, begun: now, said: now, is_quiet }
    }

    /// So many parts are there now.
    pub(super) fn reached(&mut self, count: usize) {
        if self.is_quiet || self.said.elapsed() < PAUSE {
            return;
        }
        self.said = Instant::now();
        let pace = self.begun.elapsed().as_secs_f64() / (count - self.before).max(1) as f64;
        let left = Duration::from_secs((pace * (self.most - count.min(self.most)) as f64).ceil() as u64);
        remark!(
            "{count} of at most {} parts of the map are computed, at most {} left",
            self.most,
            format_duration(left)
        );
    }

    /// The map is done.
    pub(super) fn end(&self, count: usize) {
        if !self.is_quiet {
            let seconds = self.begun.elapsed().as_secs_f64();
            remark!(
                "{count} of {} parts of the map were computed, the rest is interpolated; {seconds:.1} s",
                self.most
            );
        }
    }
}

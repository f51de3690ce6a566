//! How far a map is, once every few seconds, also while a single part takes long.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use humantime::format_duration;

/// Time between two lines.
const PAUSE: Duration = Duration::from_secs(3);

/// How far a map is.
#[derive(Debug)]
pub(super) struct Progress {
    /// The most that there can be to compute.
    most: usize,
    count: Arc<AtomicUsize>,
    begun: Instant,
    /// The thread that says it, if anybody wants to hear; it ends when the sender is dropped.
    speaker: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Progress {
    pub(super) fn new(most: usize, before: usize, is_quiet: bool) -> Self {
        if before > 0 && !is_quiet {
            remark!("the map was begun before: {before} of at most {most} parts are there");
        }
        let (count, begun) = (Arc::new(AtomicUsize::new(before)), Instant::now());
        let speaker = (!is_quiet).then(|| {
            let (sender, receiver) = channel();
            let count = Arc::clone(&count);
            let speak = move || {
                while receiver.recv_timeout(PAUSE) == Err(RecvTimeoutError::Timeout) {
                    remark!("{}", so_far(count.load(Ordering::Relaxed), before, most, begun.elapsed()));
                }
            };
            (sender, std::thread::spawn(speak))
        });
        Self { most, count, begun, speaker }
    }

    /// So many parts are there now.
    pub(super) fn reached(&self, count: usize) {
        self.count.store(count, Ordering::Relaxed);
    }

    /// The map is done.
    pub(super) fn end(self, count: usize) {
        let Some((sender, speaker)) = self.speaker else { return };
        drop(sender);
        // A thread that could not speak has no say in whether the map is done.
        let _ = speaker.join();
        let seconds = self.begun.elapsed().as_secs_f64();
        remark!("{count} of {} parts of the map were computed, the rest is interpolated; {seconds:.1} s", self.most);
    }
}

/// What is said while a map is computed.
fn so_far(count: usize, before: usize, most: usize, elapsed: Duration) -> String {
    let since = format_duration(Duration::from_secs(elapsed.as_secs()));
    if count == before {
        return format!("{count} of at most {most} parts of the map are computed, the next ones since {since}");
    }
    let pace = elapsed.as_secs_f64() / (count - before) as f64;
    let left = Duration::from_secs((pace * most.saturating_sub(count) as f64).ceil() as u64);
    format!("{count} of at most {most} parts of the map are computed, at most {} left", format_duration(left))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_that_takes_long_is_said_to_be_under_way_and_the_time_left_follows_from_the_pace() {
        let said = so_far(5, 5, 20, Duration::from_millis(9500));
        assert_eq!(said, "5 of at most 20 parts of the map are computed, the next ones since 9s");
        let said = so_far(10, 5, 20, Duration::from_secs(10));
        assert_eq!(said, "10 of at most 20 parts of the map are computed, at most 20s left");
    }
}

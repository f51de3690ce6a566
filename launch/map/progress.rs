//! How far a map is, once every few seconds, also while a single part takes long.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use humantime::format_duration;

/// Time between two lines.
const PAUSE: Duration = Duration::from_secs(3);

/// What has been computed, and by how many hosts.
#[derive(Debug, Default)]
pub(super) struct Tally {
    /// The parts that are there.
    count: AtomicUsize,
    /// Those of them that worker hosts have brought.
    away: AtomicUsize,
    /// The hosts at work; 0 where the map file names no other ones.
    hosts: AtomicUsize,
}

impl Tally {
    /// So many parts are there, and so many hosts are at work.
    pub(super) fn of(count: usize, hosts: usize) -> Self {
        Self { count: count.into(), away: 0.into(), hosts: hosts.into() }
    }

    /// One more part is there, computed on a worker host if it `is_from_away`.
    pub(super) fn one_more(&self, is_from_away: bool) {
        self.count.fetch_add(1, Ordering::Relaxed);
        self.away.fetch_add(usize::from(is_from_away), Ordering::Relaxed);
    }

    /// So many hosts are at work now.
    pub(super) fn hosts_are(&self, hosts: usize) {
        self.hosts.store(hosts, Ordering::Relaxed);
    }

    fn count(&self) -> usize {
        self.count.load(Ordering::Relaxed)
    }

    /// The hosts at work in words, if there may be several.
    fn on_hosts(&self) -> String {
        match self.hosts.load(Ordering::Relaxed) {
            0 => String::new(),
            1 => " on 1 host".into(),
            hosts => format!(" on {hosts} hosts"),
        }
    }

    /// How many parts came from worker hosts in words, if there may be any.
    fn by_others(&self) -> String {
        match (self.hosts.load(Ordering::Relaxed), self.away.load(Ordering::Relaxed)) {
            (0, _) => String::new(),
            (_, away) => format!(", {away} of them on other hosts"),
        }
    }
}

/// How far a map is.
#[derive(Debug)]
pub(super) struct Progress {
    /// How many parts there are at most.
    most: usize,
    tally: Arc<Tally>,
    begun: Instant,
    /// The thread that says it, if anybody wants to hear; it ends when the sender is dropped.
    speaker: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Progress {
    pub(super) fn new(most: usize, tally: &Arc<Tally>, is_quiet: bool) -> Self {
        let before = tally.count();
        if before > 0 && !is_quiet {
            remark!("the map was begun before: {before} of at most {most} parts are there");
        }
        let begun = Instant::now();
        let speaker = (!is_quiet).then(|| {
            let (sender, receiver) = channel();
            let tally = Arc::clone(tally);
            let speak = move || {
                while receiver.recv_timeout(PAUSE) == Err(RecvTimeoutError::Timeout) {
                    remark!("{}", so_far(&tally, before, most, begun.elapsed()));
                }
            };
            (sender, std::thread::spawn(speak))
        });
        Self { most, tally: Arc::clone(tally), begun, speaker }
    }

    /// The map is done.
    pub(super) fn end(self) {
        let Some((sender, speaker)) = self.speaker else { return };
        drop(sender);
        // A thread that could not speak has no say in whether the map is done.
        let _ = speaker.join();
        let (count, away) = (self.tally.count(), self.tally.by_others());
        let (most, seconds) = (self.most, self.begun.elapsed().as_secs_f64());
        remark!("{count} of {most} parts of the map were computed{away}, the rest is interpolated; {seconds:.1} s");
    }
}

/// What is said while a map is computed.
fn so_far(tally: &Tally, before: usize, most: usize, elapsed: Duration) -> String {
    let (count, hosts) = (tally.count(), tally.on_hosts());
    let since = format_duration(Duration::from_secs(elapsed.as_secs()));
    if count == before {
        return format!("{count} of at most {most} parts of the map are computed, the next ones{hosts} since {since}");
    }
    let pace = elapsed.as_secs_f64() / (count - before) as f64;
    let left = Duration::from_secs((pace * most.saturating_sub(count) as f64).ceil() as u64);
    format!("{count} of at most {most} parts of the map are computed{hosts}, about {} left", format_duration(left))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_that_takes_long_is_said_to_be_under_way_and_the_time_left_follows_from_the_pace() {
        let said = so_far(&Tally::of(5, 0), 5, 20, Duration::from_millis(9500));
        assert_eq!(said, "5 of at most 20 parts of the map are computed, the next ones since 9s");
        let said = so_far(&Tally::of(10, 0), 5, 20, Duration::from_secs(10));
        assert_eq!(said, "10 of at most 20 parts of the map are computed, about 20s left");
    }

    #[test]
    fn the_hosts_at_work_are_counted_where_there_may_be_several() {
        let tally = Tally::of(5, 1);
        let said = so_far(&tally, 5, 20, Duration::from_secs(9));
        assert_eq!(said, "5 of at most 20 parts of the map are computed, the next ones on 1 host since 9s");
        tally.hosts_are(3);
        tally.one_more(true);
        tally.one_more(false);
        let said = so_far(&tally, 5, 20, Duration::from_secs(2));
        assert_eq!(said, "7 of at most 20 parts of the map are computed on 3 hosts, about 13s left");
        assert_eq!(tally.by_others(), ", 1 of them on other hosts");
    }
}

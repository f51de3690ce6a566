//! When another host was last heard of.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Home is lost to a worker host that has heard nothing of it for so long: more than a cut of five seconds and the opening of a
/// new link; little enough that the worker has ended within ten seconds.
pub const HOME_LOST: Duration = Duration::from_secs(8);
/// A worker host is lost to home after so long: it may be busy, and comes back by itself while it has not given up home.
pub const WORKER_LOST: Duration = Duration::from_secs(12);
/// A worker host that has just joined has processes to start before it is first heard of: so much longer.
const STARTUP: Duration = Duration::from_secs(30);

/// What the threads that deal with one other host share.
#[derive(Debug)]
pub struct Contact {
    start: Instant,
    patience: Duration,
    heard: AtomicU64,
    carried: AtomicU64,
    ended: AtomicBool,
    stop: AtomicBool,
}

impl Contact {
    /// With home, which has just been heard of.
    pub fn with_home() -> Self {
        Self::lost_after(HOME_LOST, Duration::ZERO)
    }

    /// With a worker host that has just joined.
    pub fn with_worker() -> Self {
        Self::lost_after(WORKER_LOST, STARTUP)
    }

    fn lost_after(patience: Duration, startup: Duration) -> Self {
        Self {
            start: Instant::now(),
            patience,
            heard: AtomicU64::new(startup.as_millis() as u64),
            carried: AtomicU64::new(0),
            ended: AtomicBool::new(false),
            stop: AtomicBool::new(false),
        }
    }

    /// The other host has said something.
    pub fn hear(&self) {
        self.heard.store(self.start.elapsed().as_millis() as u64, Ordering::Relaxed);
    }

    /// So many bytes of messages have come from it.
    pub fn carry(&self, bytes: usize) {
        self.carried.fetch_add(bytes as u64, Ordering::Relaxed);
    }

    /// Bytes of messages that have come from it so far.
    pub fn carried(&self) -> u64 {
        self.carried.load(Ordering::Relaxed)
    }

    /// How long nothing has been heard of it.
    pub fn silence(&self) -> Duration {
        self.start.elapsed().saturating_sub(Duration::from_millis(self.heard.load(Ordering::Relaxed)))
    }

    /// Whether it is lost.
    pub fn is_lost(&self) -> bool {
        self.silence() > self.patience
    }

    /// Whether nothing more is to be expected of it.
    pub fn is_gone(&self) -> bool {
        self.has_ended() || self.is_lost()
    }

    /// The other host says that it ends.
    pub fn end(&self) {
        self.ended.store(true, Ordering::Relaxed);
    }

    /// Whether it has said so.
    pub fn has_ended(&self) -> bool {
        self.ended.load(Ordering::Relaxed)
    }

    /// Asks the threads to stop.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Whether they have been asked to.
    pub fn is_to_stop(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

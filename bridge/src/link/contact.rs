//! When another host was last heard of.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// A worker host that has heard nothing of home for this time takes home for lost. It is longer than a cut of five
/// seconds and the opening of a new link, and short enough that the worker has ended within ten seconds.
pub const HOME_LOST: Duration = Duration::from_secs(8);
/// Home takes a worker host for lost after this time: the host may be busy, and comes back by itself if it has not
/// given up home.
pub const WORKER_LOST: Duration = Duration::from_secs(12);
/// How much longer home waits for a worker host that has just joined, because it has processes to start first.
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
    /// A contact with home, which has just been heard of.
    pub fn with_home() -> Self {
        Self::lost_after(HOME_LOST, Duration::ZERO)
    }

    /// A contact with a worker host that has just joined.
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

    /// Notes that the other host has been heard of.
    pub fn hear(&self) {
        self.heard.store(self.start.elapsed().as_millis() as u64, Ordering::Relaxed);
    }

    /// Notes that `bytes` bytes of messages have come from the other host.
    pub fn carry(&self, bytes: usize) {
        self.carried.fetch_add(bytes as u64, Ordering::Relaxed);
    }

    /// Bytes of messages that have come from the other host so far.
    pub fn carried(&self) -> u64 {
        self.carried.load(Ordering::Relaxed)
    }

    /// For how long nothing has been heard of the other host.
    pub fn silence(&self) -> Duration {
        self.start.elapsed().saturating_sub(Duration::from_millis(self.heard.load(Ordering::Relaxed)))
    }

    /// Whether the other host is lost, because it has been silent for too long.
    pub fn is_lost(&self) -> bool {
        self.silence() > self.patience
    }

    /// Whether nothing more is to be expected of the other host.
    pub fn is_gone(&self) -> bool {
        self.has_ended() || self.is_lost()
    }

    /// Notes that the other host has said that it ends.
    pub fn end(&self) {
        self.ended.store(true, Ordering::Relaxed);
    }

    /// Whether the other host has said that it ends.
    pub fn has_ended(&self) -> bool {
        self.ended.load(Ordering::Relaxed)
    }

    /// Asks the threads to stop.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Whether the threads have been asked to stop.
    pub fn is_to_stop(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

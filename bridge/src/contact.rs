//! When another host was last heard of.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Another host of which nothing has been heard for so long is lost. More than a cut of five seconds and the opening of a
/// new link; little enough that a host whose home is lost ends within ten seconds.
pub const LOST: Duration = Duration::from_secs(8);

/// A host that has just joined may take so long until it is first heard of: it has processes to start.
const GRACE: Duration = Duration::from_secs(30);

/// What the threads that deal with one other host share.
#[derive(Debug)]
pub struct Contact {
    start: Instant,
    heard: AtomicU64,
    carried: AtomicU64,
    ended: AtomicBool,
    stop: AtomicBool,
}

impl Default for Contact {
    fn default() -> Self {
        Self {
            start: Instant::now(),
            heard: AtomicU64::new(GRACE.as_millis() as u64),
            carried: AtomicU64::new(0),
            ended: AtomicBool::new(false),
            stop: AtomicBool::new(false),
        }
    }
}

impl Contact {
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
        self.silence() > LOST
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

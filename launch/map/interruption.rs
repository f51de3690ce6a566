//! What happens when the user asks to stop while a map is computed: the worker hosts are told, and the process ends
//! without waiting for the parts that are under way.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::{JoinHandle, sleep, spawn};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::{Handle, Signals};

use super::allotment::Allotment;
use crate::exit::INTERRUPTED;

/// How long worker hosts have to hear that home ends and to bring what they have; they ask every half second.
const LAST_WORDS: Duration = Duration::from_secs(3);
/// Time between two looks whether they have left.
const LOOK: Duration = Duration::from_millis(20);

/// Watches for requests to stop until it is ended.
pub(super) struct Watch {
    handle: Handle,
    watcher: JoinHandle<()>,
}

impl Watch {
    /// Watches while the parts of an allotment, at most `most`, are computed and kept in `folder`.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub(super) fn begin(allotment: &Arc<Allotment>, most: usize, folder: &Path) -> Result<Self, String> {
        let mut signals = Signals::new([SIGINT, SIGTERM]).map_err(|e| format!("cannot catch signals: {e}"))?;
        let handle = signals.handle();
        let (allotment, folder) = (Arc::clone(allotment), PathBuf::from(folder));
        let watcher = spawn(move || {
            if signals.forever().next().is_some() && allotment.interrupt() {
                let start = Instant::now();
                // A second request ends the waiting.
                while allotment.is_shared() && start.elapsed() < LAST_WORDS && signals.pending().next().is_none() {
                    sleep(LOOK);
                }
                end_process(&allotment, most, &folder);
            }
        });
        Ok(Self { handle, watcher })
    }

    /// The map has ended. Does not return if the user has asked to stop before that.
    pub(super) fn end(self) {
        self.handle.close();
        // A watcher that has crashed has no say in how the map has ended.
        let _ = self.watcher.join();
    }
}

/// Ends the process: the parts that are under way may take long, and nobody waits for them. Nothing is kept any more
/// while the words are said, so that they are true.
fn end_process(allotment: &Allotment, most: usize, folder: &Path) {
    allotment.with_count(|count| {
        remark!(
            "interrupted: {count} of at most {most} parts of the map are computed and kept in {}; the same command goes on with them",
            folder.display()
        );
        std::process::exit(i32::from(INTERRUPTED))
    });
}

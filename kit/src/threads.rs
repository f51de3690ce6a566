//! The threads with which a process computes.

use rayon::ThreadPoolBuilder;

/// Prevents computations from failing for lack of threads: if the system refuses new threads (`ulimit -u`,
/// `ulimit -v`), the existing thread computes alone, with the same results. Must be called by the thread that will
/// compute.
pub(crate) fn prepare() {
    if let Err(refused) = ThreadPoolBuilder::new().build() {
        tracing::warn!("one thread computes alone: {refused}");
        let _ = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global();
    }
}

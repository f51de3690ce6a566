//! The threads that a process computes with.

use rayon::ThreadPoolBuilder;

/// Sees to it that computing does not fail for want of threads: where the system refuses them (`ulimit -u`, `ulimit -v`), the
/// one that there is computes alone, with the same results. To be called by the thread that will compute.
pub(crate) fn prepare() {
    if let Err(refused) = ThreadPoolBuilder::new().build() {
        tracing::warn!("one thread computes alone: {refused}");
        let _ = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global();
    }
}

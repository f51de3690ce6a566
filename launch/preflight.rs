//! What must be there before anything is started.

use crate::launch_file::{Case, Launch, Runs};

/// Where iceoryx2 keeps messages.
const SHARED_MEMORY: &str = "/dev/shm";
/// Room for management data, per process \[bytes\].
const OVERHEAD: u64 = 2 << 20;

/// Checks that shared memory can hold the run: a full /dev/shm kills a process by SIGBUS instead of giving an error.
///
/// # Errors
/// How much is needed and how much is there.
pub fn check_shared_memory(launch: &Launch) -> Result<(), String> {
    let status = rustix::fs::statvfs(SHARED_MEMORY).map_err(|e| format!("{SHARED_MEMORY}: {e}"))?;
    let free = status.f_bavail * status.f_frsize;
    let needed = needed_bytes(launch);
    if needed <= free {
        return Ok(());
    }
    Err(format!(
        "the run needs {} MiB of shared memory, {SHARED_MEMORY} has {} MiB free; take fewer samples or enlarge it",
        needed.div_ceil(1 << 20),
        free >> 20
    ))
}

/// Every snapshot and density of a scenario is held until the scenario ends.
fn needed_bytes(launch: &Launch) -> u64 {
    let snapshots = launch.scenarios.iter().map(|s| s.content.problem.times.len()).max().unwrap_or(0) as u64;
    let (phi, e) = (launch.bins.0 as u64, launch.bins.1 as u64);
    let density_numbers = phi * e + phi + e;
    let numbers = |case: &Case| match &case.runs {
        Runs::BuiltIn { settings, .. } => settings.most_numbers(launch.bins) as u64,
        // Nobody knows what a foreign program will ask for, and a recorded case is checked where it is played.
        Runs::Command(_) | Runs::Recorded(_) => 0,
    };
    let per_snapshot = launch.cases.iter().map(|case| numbers(case).saturating_add(density_numbers));
    let per_snapshot = per_snapshot.fold(0, u64::saturating_add);
    let payload = per_snapshot.saturating_mul(8 * (snapshots + 1));
    payload.saturating_add((launch.cases.len() as u64 + 5) * OVERHEAD)
}

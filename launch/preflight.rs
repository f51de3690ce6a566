//! What must be there before anything is started.

use nodes::reduced;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use crate::cases::{Case, Runs};
use crate::launch_file::Launch;

/// Where iceoryx2 keeps messages.
const SHARED_MEMORY: &str = "/dev/shm";
/// Descriptors of a process in a run without propagators, and for each; 144 and 7 were measured.
const DESCRIPTORS: usize = 250;
const DESCRIPTORS_PER_PROPAGATOR: usize = 10;
/// Address space without which a launcher of a few processes has been seen to be refused the memory for its own lists \[bytes\].
const ADDRESSES: u64 = 96 << 20;
/// Room for management data, per process \[bytes\].
const OVERHEAD: u64 = 2 << 20;

/// Checks that shared memory can hold a scenario of so many snapshots: a full /dev/shm kills a process by SIGBUS instead of giving
/// an error.
///
/// # Errors
/// How much is needed and how much is there.
pub fn check_shared_memory(launch: &Launch, snapshots: usize) -> Result<(), String> {
    let status = rustix::fs::statvfs(SHARED_MEMORY).map_err(|e| format!("{SHARED_MEMORY}: {e}"))?;
    let free = status.f_bavail * status.f_frsize;
    let needed = needed_bytes(launch, snapshots as u64);
    if needed <= free {
        return Ok(());
    }
    Err(format!(
        "the run needs {} MiB of shared memory, {SHARED_MEMORY} has {} MiB free; take fewer samples or enlarge it",
        needed.div_ceil(1 << 20),
        free >> 20
    ))
}

/// Checks that a process of the run can hold all connections, and raises its limit where it may.
///
/// # Errors
/// How many descriptors are needed and how many are allowed.
pub fn check_descriptors(propagators: usize) -> Result<(), String> {
    let needed = (DESCRIPTORS + DESCRIPTORS_PER_PROPAGATOR * propagators) as u64;
    let limit = getrlimit(Resource::Nofile);
    if limit.current.is_none_or(|current| current >= needed) {
        return Ok(());
    }
    let raised = Rlimit { current: limit.maximum.map_or(Some(needed), |most| Some(most.min(needed))), ..limit };
    if limit.maximum.is_none_or(|most| most >= needed) && setrlimit(Resource::Nofile, raised).is_ok() {
        return Ok(());
    }
    let allowed = limit.maximum.unwrap_or(0);
    Err(format!(
        "the run needs up to {needed} file descriptors a process, {allowed} are allowed; raise the limit (ulimit -n)"
    ))
}

/// Checks that processes may have some address space: without it they are aborted in the midst of whatever they do.
///
/// # Errors
/// How much is needed and how much is allowed.
pub fn check_address_space() -> Result<(), String> {
    match getrlimit(Resource::As).current {
        Some(allowed) if allowed < ADDRESSES => Err(format!(
            "the run needs at least {} MiB of address space a process, {} MiB are allowed; raise the limit (ulimit -v)",
            ADDRESSES >> 20,
            allowed >> 20
        )),
        _ => Ok(()),
    }
}

/// Every snapshot and density of a scenario is held until the scenario ends.
fn needed_bytes(launch: &Launch, snapshots: u64) -> u64 {
    let (phi, e) = (launch.bins.0 as u64, launch.bins.1 as u64);
    let density_numbers = phi * e + phi + e;
    let numbers = |case: &Case| match &case.runs {
        Runs::BuiltIn { .. } if case.reduce => {
            u64::from(case.shards).saturating_mul(reduced::most_numbers(launch.bins.0 * launch.bins.1) as u64)
        }
        Runs::BuiltIn { settings, .. } => settings.most_numbers(launch.bins) as u64,
        // Nobody knows what a foreign program will ask for, and a recorded case is checked where it is played.
        Runs::Command(_) | Runs::Recorded(_) => 0,
    };
    let per_snapshot = launch.cases.iter().map(|case| numbers(case).saturating_add(density_numbers));
    let per_snapshot = per_snapshot.fold(0, u64::saturating_add);
    let payload = per_snapshot.saturating_mul(8 * (snapshots + 1));
    payload.saturating_add((launch.propagators() as u64 + 5) * OVERHEAD)
}

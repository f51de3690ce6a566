//! What must be there before anything is started.

use std::path::Path;

use kit::reduced;
use messages::domain::segment_bytes;
use messages::topic::{Capacity, Density, Snapshot};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use crate::plan::cases::{Case, Runs};
use crate::plan::launch_file::Launch;

/// Where iceoryx2 keeps messages.
const SHARED_MEMORY: &str = "/dev/shm";
/// File descriptors of a process in a run without propagators, and how many more per propagator; 144 and 7 were
/// measured.
const DESCRIPTORS: usize = 250;
const DESCRIPTORS_PER_PROPAGATOR: usize = 10;
/// Address space of a process besides the messages of large cases: code, stacks, and what the memory allocator sets
/// aside for each thread \[bytes\]. With 290 MiB processes of a small run have been seen to wait for ever.
const ADDRESSES: u64 = 512 << 20;
/// Least stack and least data \[bytes\]; with less a process crashes before it can print a message.
const STACK: u64 = 512 << 10;
const DATA: u64 = 64 << 20;
/// Room for the log, the tables and the report, and for what a file of messages holds besides messages \[bytes\].
const FILES: u64 = 64 << 20;
/// Room for management data, per process \[bytes\].
const OVERHEAD: u64 = 2 << 20;

/// Checks that shared memory can hold a scenario of the given number of snapshots: a full /dev/shm kills a process by
/// SIGBUS instead of giving an error.
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

/// Checks that processes may have enough address space: with less they are aborted in the middle of their work.
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

/// Checks what this process and its children may have of stack and data, before anything else is done.
///
/// # Errors
/// How much is needed and how much is allowed.
pub fn check_stack_and_data() -> Result<(), String> {
    for (resource, name, option, needed) in
        [(Resource::Stack, "stack", "-s", STACK), (Resource::Data, "data", "-d", DATA)]
    {
        if let Some(allowed) = getrlimit(resource).current.filter(|allowed| *allowed < needed) {
            return Err(format!(
                "a process needs at least {} KiB of {name}, {} KiB are allowed; raise the limit (ulimit {option})",
                needed >> 10,
                allowed >> 10
            ));
        }
    }
    Ok(())
}

/// Checks that files may be as long as those of a run are. The messages of a process lie in one file of shared memory,
/// and a process whose file becomes longer than allowed is killed.
///
/// # Errors
/// How much is needed and how much is allowed.
pub fn check_file_size(launch: &Launch, snapshots: usize) -> Result<(), String> {
    let needed = longest_segment(launch, snapshots).saturating_add(FILES);
    match getrlimit(Resource::Fsize).current {
        Some(allowed) if allowed < needed => Err(format!(
            "the run needs files of up to {} MiB, most of it in shared memory and not filled, {} KiB are allowed; raise the limit \
             (ulimit -f)",
            needed.div_ceil(1 << 20),
            allowed >> 10
        )),
        _ => Ok(()),
    }
}

/// Checks that the path that `option` names can be given to the processes of a run, and written into its files.
///
/// # Errors
/// If it is not UTF-8 text.
pub fn check_path(option: &str, path: &Path) -> Result<(), String> {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.into());
    match whole.to_str() {
        Some(_) => Ok(()),
        None => Err(format!("{option}: the path {whole:?} is not UTF-8 text, as it must be; name another")),
    }
}

/// Length of the longest file that holds the messages of a process \[bytes\].
fn longest_segment(launch: &Launch, snapshots: usize) -> u64 {
    let hosts = launch.hosts.as_ref().map_or(0, |hosts| hosts.names.len());
    let capacity = Capacity { propagators: launch.propagators(), cases: launch.cases.len(), snapshots, hosts };
    let of_shard = |case: &Case| numbers(launch, case).div_ceil(u64::from(case.shards));
    let snapshot = launch.cases.iter().map(of_shard).max().unwrap_or(0);
    segment_bytes::<Snapshot>(&capacity, snapshot).max(segment_bytes::<Density>(&capacity, density_numbers(launch)))
}

/// Shared memory that a run needs \[bytes\]: every snapshot and density of a scenario is held until the scenario ends.
fn needed_bytes(launch: &Launch, snapshots: u64) -> u64 {
    let per_snapshot = launch.cases.iter().map(|case| numbers(launch, case).saturating_add(density_numbers(launch)));
    let per_snapshot = per_snapshot.fold(0, u64::saturating_add);
    let payload = per_snapshot.saturating_mul(8 * (snapshots + 1));
    payload.saturating_add((launch.propagators() as u64 + 5) * OVERHEAD)
}

/// Numbers of a density on the comparison grid, with its marginals; in space there are a second pair of variables and
/// two more marginals.
fn density_numbers(launch: &Launch) -> u64 {
    let (phi, e) = (launch.bins.0 as u64, launch.bins.1 as u64);
    let in_plane = phi * e + phi + e;
    let is_in_space = launch.scenarios.iter().any(|scenario| scenario.content.in_plane().is_none());
    if is_in_space { in_plane + e * e + 2 * e } else { in_plane }
}

/// The largest count of numbers that a snapshot of a case can have.
fn numbers(launch: &Launch, case: &Case) -> u64 {
    match &case.runs {
        Runs::BuiltIn { .. } if case.reduce => {
            u64::from(case.shards).saturating_mul(reduced::most_numbers(launch.bins.0 * launch.bins.1) as u64)
        }
        Runs::BuiltIn { settings, .. } => settings.most_numbers(launch.bins, launch.most_variables()) as u64,
        // Nobody knows what a foreign program will ask for, and a recorded case is checked where it is played.
        Runs::Command(_) | Runs::Recorded(_) => 0,
    }
}

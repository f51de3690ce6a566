//! What the end of a process means, in words.

use std::os::unix::process::ExitStatusExt;
use std::process::ExitStatus;

const SIGABRT: i32 = 6;
const SIGBUS: i32 = 7;
const SIGKILL: i32 = 9;

/// Why a process that should have gone on has ended, and what to look at.
pub fn explain(status: ExitStatus) -> String {
    let hint = match status.signal() {
        Some(SIGBUS) => "; /dev/shm has run full: take fewer samples, enlarge it, or remove what others keep there",
        Some(SIGABRT) => "; it gave up, perhaps because it was refused memory: log.jsonl has its last words",
        Some(SIGKILL) => "; somebody killed it, perhaps the kernel because memory ran out",
        _ => "",
    };
    format!("ended before the run did: {status}{hint}")
}

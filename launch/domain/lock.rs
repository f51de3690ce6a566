//! The lock of a domain: who holds it lives, and nobody cleans up there.

use std::fs::File;
use std::path::Path;

use rustix::fs::{FlockOperation, flock};

/// The locked file.
pub const LOCK: &str = "launcher.lock";

/// Makes and holds the lock of the domain whose folder is `root`.
///
/// # Errors
/// If that is not possible.
pub fn lock_in(root: &Path) -> std::io::Result<File> {
    // Locked before it has the name under which others look: nobody sees it without its owner.
    let unnamed = root.join("lock.new");
    let lock = File::create(&unnamed)?;
    flock(&lock, FlockOperation::NonBlockingLockExclusive)?;
    std::fs::rename(&unnamed, root.join(LOCK))?;
    Ok(lock)
}

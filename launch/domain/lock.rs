//! The lock of a domain: as long as a launcher holds it, nobody removes the domain.

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
    // The file is locked before it gets the name under which others look for it, so that nobody sees it unlocked.
    let unnamed = root.join("lock.new");
    let lock = File::create(&unnamed)?;
    flock(&lock, FlockOperation::NonBlockingLockExclusive)?;
    std::fs::rename(&unnamed, root.join(LOCK))?;
    Ok(lock)
}

//! The domains of this user's runs: a fresh one a run, and the remains of runs whose launcher is gone.
//!
//! A launcher holds a lock on a file in its domain's folder for as long as it lives, however it ends. A folder whose lock is
//! free belongs to nobody.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use messages::domain::Place;
use rustix::fs::{FlockOperation, flock};

/// The locked file.
const LOCK: &str = "launcher.lock";

/// A number that no other run has; 48 bits, so that names made of it stay short.
pub fn fresh_run_id() -> u64 {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    ((now.as_nanos() as u64) ^ (u64::from(std::process::id()) << 28)) & 0xffff_ffff_ffff
}

/// The folder of this user's domains, among the temporary files.
fn user_folder(temporary: &Path) -> PathBuf {
    temporary.join(format!("phasecloud-{}", rustix::process::getuid().as_raw()))
}

fn place_in(folder: &Path, name: &str) -> Place {
    Place { root: folder.join(name), prefix: format!("pc{name}-") }
}

/// The domain of this process's run; dropping it removes it.
#[derive(Debug)]
pub struct OwnDomain {
    /// Where it lies.
    pub place: Place,
    _lock: File,
}

impl OwnDomain {
    /// Creates the folder of run `run_id`'s domain and locks it.
    ///
    /// # Errors
    /// If that is not possible.
    pub fn claim(run_id: u64) -> Result<Self, String> {
        let name = format!("{run_id:012x}");
        let place = place_in(&user_folder(&std::env::temp_dir()), &name);
        let place = if place.is_short_enough() { place } else { place_in(&user_folder(Path::new("/tmp")), &name) };
        let failed = |e: &dyn std::fmt::Display| format!("{}: {e}", place.root.display());
        place.create().map_err(|e| failed(&e))?;
        let lock = File::create(place.root.join(LOCK)).map_err(|e| failed(&e))?;
        flock(&lock, FlockOperation::NonBlockingLockExclusive).map_err(|e| failed(&e))?;
        Ok(Self { place, _lock: lock })
    }
}

impl Drop for OwnDomain {
    fn drop(&mut self) {
        if let Err(error) = self.place.remove() {
            eprintln!("warning: {} is left behind: {error}", self.place.root.display());
        }
    }
}

/// Removes the domains whose launcher is gone; never touches a live one.
pub fn sweep() {
    let folder = user_folder(&std::env::temp_dir());
    for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
        let Ok(lock) = File::open(entry.path().join(LOCK)) else { continue };
        if flock(&lock, FlockOperation::NonBlockingLockExclusive).is_ok() {
            let _ = place_in(&folder, &entry.file_name().to_string_lossy()).remove();
        }
    }
}

/// The domains of this user's runs whose launcher lives.
pub fn live() -> Vec<Place> {
    let folder = user_folder(&std::env::temp_dir());
    // The same choice as for a new domain.
    let is_short = place_in(&folder, &format!("{:012x}", 0)).is_short_enough();
    let folder = if is_short { folder } else { user_folder(Path::new("/tmp")) };
    let entries = std::fs::read_dir(&folder).into_iter().flatten().flatten();
    let mut places: Vec<Place> = entries
        .map(|entry| place_in(&folder, &entry.file_name().to_string_lossy()))
        .filter(|place| place.root.join(LOCK).exists() && is_live(place))
        .collect();
    places.sort_by(|a, b| a.root.cmp(&b.root));
    places
}

/// Whether the domain at `place` is somebody's: it is there, and if a launcher made it, that launcher lives.
pub fn is_live(place: &Place) -> bool {
    match File::open(place.root.join(LOCK)) {
        Ok(lock) => flock(&lock, FlockOperation::NonBlockingLockShared).is_err(),
        Err(_) => place.root.is_dir(),
    }
}

/// Removes what is left of a run whose launcher is gone: an observer that attached in the launcher's last moment may have
/// added to what the launcher had already removed.
pub fn remove_remains(place: &Place) {
    let name = place.root.file_name().unwrap_or_default().to_string_lossy();
    if !is_live(place) && place.prefix == format!("pc{name}-") {
        let _ = place.remove();
    }
}

//! The domains of this user's runs: one per run, and the removal of those whose launcher is gone.
//!
//! A launcher holds a lock on a file in its domain's folder for as long as it lives, however it ends. A folder whose
//! lock is free belongs to nobody.

pub mod attach;
pub mod keeper;
pub mod lock;

use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use messages::domain::Place;
use rustix::fs::{Access, FlockOperation, flock};

use crate::domain::keeper::{Keeper, TOPICS};
use lock::{LOCK, lock_in};

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

/// The folder in which new domains are made: the user's among the temporary files, or the one in `/tmp` if paths in it
/// are too long for the names of sockets.
fn home() -> PathBuf {
    let folder = user_folder(&std::env::temp_dir());
    let name_of_a_run = format!("{:012x}", 0);
    if place_in(&folder, &name_of_a_run).is_short_enough() { folder } else { user_folder(Path::new("/tmp")) }
}

/// Checks that `TMPDIR`, if it is set, names a folder that can be written: no other is taken in its place.
fn check_temporary_folder() -> Result<(), String> {
    let Some(named) = std::env::var_os("TMPDIR") else { return Ok(()) };
    let folder = Path::new(&named);
    let problem = match folder.metadata() {
        _ if named.is_empty() => "it names nothing".to_owned(),
        Err(error) => error.to_string(),
        Ok(found) if !found.is_dir() => "it is not a folder".to_owned(),
        Ok(_) => match rustix::fs::access(folder, Access::WRITE_OK | Access::EXEC_OK) {
            Ok(()) => return Ok(()),
            Err(error) => format!("it cannot be written: {error}"),
        },
    };
    let shown = folder.display();
    Err(format!(
        "TMPDIR={shown}: {problem}; it must name a folder for temporary files that is there and can be written, or be unset"
    ))
}

/// Where the domain called `name` lies.
fn place_of(name: &str) -> Place {
    place_in(&home(), name)
}

/// The domain that this user calls `name`. Names in shared memory start with the user's number, because all users share
/// it; every prefix ends in '-', which no name contains, so that no prefix is the start of another.
///
/// # Errors
/// If the name is not plain letters and digits.
pub fn named(name: &str) -> Result<Place, String> {
    if !(1..=16).contains(&name.len()) || !name.bytes().all(|byte| byte.is_ascii_alphanumeric()) {
        return Err(format!("\"{name}\" is not allowed as a domain's name, it must be 1 to 16 letters or digits"));
    }
    Ok(place_of(&format!("{}_{name}", rustix::process::getuid().as_raw())))
}

/// The domain of this process's run; dropping it removes it.
#[derive(Debug)]
pub struct OwnDomain {
    /// Where it lies.
    pub place: Place,
    keeper: Option<Keeper>,
    _lock: File,
}

impl OwnDomain {
    /// Creates the folder of run `run_id`'s domain and locks it.
    ///
    /// # Errors
    /// If that is not possible; the message says which variable names another place.
    pub fn claim(run_id: u64) -> Result<Self, String> {
        check_temporary_folder()?;
        Self::claim_at(place_of(&format!("{run_id:012x}"))).map_err(elsewhere)
    }

    /// Creates and locks the domain that [`named`] names; the remains of one whose holder is gone are removed first.
    ///
    /// # Errors
    /// If another process holds it, or it cannot be created.
    pub fn claim_named(name: &str) -> Result<Self, String> {
        let place = named(name)?;
        check_temporary_folder()?;
        if let Ok(lock) = File::open(place.root.join(LOCK)) {
            let held = || format!("another process holds the domain \"{name}\"; take another name");
            flock(&lock, FlockOperation::NonBlockingLockExclusive).map_err(|_| held())?;
            place.remove().map_err(|e| format!("{}: {e}", place.root.display()))?;
        }
        Self::claim_at(place).map_err(elsewhere)
    }

    fn claim_at(place: Place) -> Result<Self, String> {
        let failed = |e: &dyn std::fmt::Display| format!("{}: {e}", place.root.display());
        if place.root.to_str().is_none() {
            return Err(format!("the path {:?} is not UTF-8 text, as it must be", place.root));
        }
        place.create().map_err(|e| failed(&e))?;
        let lock = lock_in(&place.root).map_err(|e| failed(&e))?;
        let keeper = Some(Keeper::start(&place.root, lock.try_clone().map_err(|e| failed(&e))?));
        Ok(Self { place, keeper, _lock: lock })
    }
}

impl OwnDomain {
    /// Remembers what lies in the domain now, so that it is made anew if a cleaner removes it.
    pub fn keep(&self) {
        if let Some(keeper) = &self.keeper {
            keeper.go_round();
        }
    }
}

/// Adds to a problem what can be done if a domain cannot be made.
fn elsewhere(problem: String) -> String {
    format!("{problem}; TMPDIR can name another folder for temporary files, one that can be written")
}

impl Drop for OwnDomain {
    fn drop(&mut self) {
        // The keeper would make anew what is to be removed.
        drop(self.keeper.take());
        if let Err(error) = self.place.remove() {
            remark!("warning: {} is left behind: {error}", self.place.root.display());
        }
    }
}

/// Removes the domains whose launcher is gone, and returns them; never touches a live one.
pub fn sweep() -> Vec<Place> {
    let dead = places().into_iter().filter(|place| match File::open(place.root.join(LOCK)) {
        Ok(lock) => flock(&lock, FlockOperation::NonBlockingLockExclusive).is_ok() && place.remove().is_ok(),
        Err(_) => is_forsaken(place) && place.remove().is_ok(),
    });
    dead.collect()
}

/// The domains of this user's runs whose launcher lives.
pub fn live() -> Vec<Place> {
    places().into_iter().filter(|place| place.root.join(LOCK).exists() && is_live(place)).collect()
}

/// All domains, dead or alive, in the folder in which new ones are made.
fn places() -> Vec<Place> {
    let folder = home();
    let entries = std::fs::read_dir(&folder).into_iter().flatten().flatten();
    let mut places: Vec<Place> = entries.map(|entry| place_in(&folder, &entry.file_name().to_string_lossy())).collect();
    places.sort_by(|a, b| a.root.cmp(&b.root));
    places
}

/// Whether a folder without a lock is too old to belong to a launcher that is just about to lock it.
fn is_forsaken(place: &Place) -> bool {
    const WHILE: Duration = Duration::from_secs(60);
    let changed = std::fs::metadata(&place.root).and_then(|folder| folder.modified());
    changed.is_ok_and(|changed| changed.elapsed().is_ok_and(|age| age > WHILE))
}

/// Whether the domain at `place` is in use: it exists, and if a launcher made it, that launcher lives.
pub fn is_live(place: &Place) -> bool {
    match File::open(place.root.join(LOCK)) {
        Ok(lock) => flock(&lock, FlockOperation::NonBlockingLockShared).is_err(),
        Err(_) => has_topics(place),
    }
}

/// Whether topics have been opened at a place. This only reads the folder, since entering a place that is no domain
/// would make it one.
fn has_topics(place: &Place) -> bool {
    let files = std::fs::read_dir(place.root.join(TOPICS)).into_iter().flatten().flatten();
    files.into_iter().any(|file| file.file_name().to_string_lossy().starts_with(&place.prefix))
}

/// Removes what is left of a run whose launcher is gone: an observer that attached in the launcher's last moment may
/// have added to what the launcher had already removed.
pub fn remove_remains(place: &Place) {
    let name = place.root.file_name().unwrap_or_default().to_string_lossy();
    if !is_live(place) && place.prefix == format!("pc{name}-") {
        let _ = place.remove();
    }
}

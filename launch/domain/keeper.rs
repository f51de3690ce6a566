//! The keeper of a domain: it protects the domain's temporary files from programs that remove old files.
//!
//! It renews the times of all files again and again, so that nothing looks old. If the lock, the notice or the files
//! that say how each topic is to be opened have been removed all the same, it makes them anew. So a run or service
//! stays reachable however long it lives.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, Permissions};
use std::io::Write;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use rustix::fs::{AtFlags, CWD, Timespec, Timestamps, UTIME_NOW, utimensat};

use crate::domain::lock::{LOCK, lock_in};

/// The file in a domain's folder in which the launcher says what it runs.
pub const NOTICE: &str = "run.json";
/// Time between two rounds.
const ROUND: Duration = Duration::from_secs(5);
/// The folder in which iceoryx2 says how each topic is to be opened; the launcher holds all topics open.
pub const TOPICS: &str = "services";

/// A thread that goes through the files in rounds until this is dropped.
#[derive(Debug)]
pub struct Keeper {
    /// A message asks for a round at once; the thread ends when this is dropped.
    rounds: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Keeper {
    /// Keeps the domain's folder `root`, whose lock is `lock`. If no thread can be started, nothing is kept.
    pub fn start(root: &Path, lock: File) -> Self {
        let (asks, asked) = channel();
        let mut kept = Kept { root: root.into(), lock, files: BTreeMap::new() };
        let rounds = move || {
            while asked.recv_timeout(ROUND) != Err(RecvTimeoutError::Disconnected) {
                kept.go_round();
            }
        };
        Self { rounds: Some(asks), thread: std::thread::Builder::new().name("keeper".into()).spawn(rounds).ok() }
    }
}

impl Keeper {
    /// Asks for a round at once, so that what is there now is remembered before anybody removes it.
    pub fn go_round(&self) {
        // Without its thread nothing is kept.
        let _ = self.rounds.as_ref().map(|asks| asks.send(()));
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        drop(self.rounds.take());
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// What is kept.
struct Kept {
    root: PathBuf,
    lock: File,
    /// The content and the mode of files that stay as they are as long as the domain does.
    files: BTreeMap<PathBuf, (Vec<u8>, u32)>,
}

impl Kept {
    fn go_round(&mut self) {
        self.restore();
        self.remember(self.root.join(NOTICE));
        for entry in std::fs::read_dir(self.root.join(TOPICS)).into_iter().flatten().flatten() {
            self.remember(entry.path());
        }
        if let Some(folder) = self.root.parent() {
            touch(folder);
        }
        touch_all(&self.root);
    }

    fn remember(&mut self, path: PathBuf) {
        if self.files.contains_key(&path) || !path.is_file() {
            return;
        }
        if let (Ok(content), Ok(data)) = (std::fs::read(&path), path.metadata())
            && !content.is_empty()
        {
            self.files.insert(path, (content, data.mode() & 0o777));
        }
    }

    /// Makes anew what is no longer there. A failure is not reported, because the next round tries again.
    fn restore(&mut self) {
        let place = self.root.join(LOCK);
        let is_ours = |file: &File| match (file.metadata(), place.metadata()) {
            (Ok(own), Ok(found)) => (own.dev(), own.ino()) == (found.dev(), found.ino()),
            _ => false,
        };
        if !is_ours(&self.lock) {
            let _ = std::fs::DirBuilder::new().recursive(true).mode(0o700).create(&self.root);
            if let Ok(lock) = lock_in(&self.root) {
                self.lock = lock;
            }
        }
        for (path, (content, mode)) in self.files.iter().filter(|(path, _)| !path.exists()) {
            let _ = put_back(path, content, *mode);
        }
    }
}

/// Writes a file under another name first, so that nobody finds half of it.
fn put_back(path: &Path, content: &[u8], mode: u32) -> std::io::Result<()> {
    let folder = path.parent().unwrap_or(path);
    std::fs::DirBuilder::new().recursive(true).mode(0o750).create(folder)?;
    let draft = path.with_extension("kept");
    let mut file = OpenOptions::new().write(true).create(true).truncate(true).mode(0o600).open(&draft)?;
    file.write_all(content)?;
    std::fs::set_permissions(&draft, Permissions::from_mode(mode))?;
    std::fs::rename(&draft, path)
}

/// Renews the times of a folder and of everything below it.
fn touch_all(folder: &Path) {
    touch(folder);
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        match entry.file_type() {
            Ok(kind) if kind.is_dir() => touch_all(&entry.path()),
            _ => touch(&entry.path()),
        }
    }
}

fn touch(path: &Path) {
    let now = Timespec { tv_sec: 0, tv_nsec: UTIME_NOW };
    let times = Timestamps { last_access: now, last_modification: now };
    let _ = utimensat(CWD, path, &times, AtFlags::SYMLINK_NOFOLLOW);
}

#[cfg(test)]
mod tests {
    use std::time::SystemTime;

    use super::*;

    #[test]
    fn what_a_cleaner_has_removed_is_made_anew_and_nothing_looks_old() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().join("domain");
        std::fs::create_dir_all(root.join(TOPICS)).unwrap();
        let lock = lock_in(&root).unwrap();
        let topic = root.join(TOPICS).join("a.service");
        std::fs::write(&topic, "how").unwrap();
        std::fs::write(root.join(NOTICE), "what").unwrap();
        let mut kept = Kept { root: root.clone(), lock, files: BTreeMap::new() };
        kept.go_round();
        let old = File::open(&topic).unwrap();
        old.set_modified(SystemTime::UNIX_EPOCH).unwrap();
        kept.go_round();
        assert!(topic.metadata().unwrap().modified().unwrap().elapsed().unwrap() < Duration::from_secs(3600));
        std::fs::remove_dir_all(&root).unwrap();
        kept.go_round();
        assert_eq!(std::fs::read_to_string(&topic).unwrap(), "how");
        assert_eq!(std::fs::read_to_string(root.join(NOTICE)).unwrap(), "what");
        let found = File::open(root.join(LOCK)).unwrap();
        assert!(rustix::fs::flock(&found, rustix::fs::FlockOperation::NonBlockingLockShared).is_err(), "it is held");
    }
}

//! The part of shared memory that belongs to one run: a root folder and a prefix of names.
//!
//! Two domains never see each other. The launcher makes a new domain for each run and holds every topic open while
//! the run lasts. Only the launcher cleans up after dead nodes, and it removes the domain at the end.

use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::time::Duration;

use iceoryx2::prelude::*;

use crate::port::{Inlet, MOST_DRAFTS, Outlet, READER, Services};
use crate::port_error::PortError;
use crate::topic::{Capacity, Comparison, Density, Passage, Request, Roster, Scenario, Snapshot, Status, Topic};

/// Environment variable that names the root folder.
pub const ROOT_VARIABLE: &str = "PHASECLOUD_ROOT";
/// Environment variable that names the prefix.
pub const PREFIX_VARIABLE: &str = "PHASECLOUD_PREFIX";

/// Messages of a topic that a reader may hold at once.
pub const MOST_HELD: usize = 4;
/// Upper bound of what iceoryx2 puts before a message \[bytes\].
const MESSAGE_OVERHEAD: u64 = 256;

/// Greatest length of root and prefix together \[bytes\]. With a slash, a number of 39 digits and `.event` they form
/// the name of a Unix socket, which has at most 107 bytes.
const LONGEST: usize = 107 - 1 - 39 - 6;

/// Where a domain lies.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Folder of its management files.
    pub root: PathBuf,
    /// The beginning of its names in shared memory.
    pub prefix: String,
}

impl Place {
    /// The place that the environment names, if it names one.
    pub fn from_environment() -> Option<Self> {
        let root = std::env::var_os(ROOT_VARIABLE)?.into();
        let prefix = std::env::var(PREFIX_VARIABLE).ok()?;
        Some(Self { root, prefix })
    }

    /// Whether the names of the domain's sockets fit into what the operating system allows.
    pub fn is_short_enough(&self) -> bool {
        self.root.as_os_str().len() + self.prefix.len() <= LONGEST
    }

    /// Creates the root folder, for its owner alone.
    ///
    /// # Errors
    /// If it cannot be created, or its path is too long.
    pub fn create(&self) -> std::io::Result<()> {
        if !self.is_short_enough() {
            let problem = format!("root and prefix together must not be longer than {LONGEST} bytes");
            return Err(std::io::Error::new(std::io::ErrorKind::InvalidInput, problem));
        }
        std::fs::DirBuilder::new().recursive(true).mode(0o700).create(&self.root)?;
        // Another user may have made the folder, or the one in which it lies, before.
        let parent = self.root.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let (own, above) = (self.root.symlink_metadata()?, parent.metadata()?);
        let user = rustix::process::getuid().as_raw();
        if own.is_dir() && own.uid() == user && own.mode() & 0o077 == 0 && [user, 0].contains(&above.uid()) {
            return Ok(());
        }
        let problem = "it is not a folder that its user alone can enter";
        Err(std::io::Error::new(std::io::ErrorKind::PermissionDenied, problem))
    }

    /// Reserves the memory of everything that the domain has so far, so that its later use cannot fail for lack of
    /// memory: when /dev/shm is full, the first access to a page kills the process by SIGBUS.
    ///
    /// # Errors
    /// If there is not enough.
    pub fn reserve(&self) -> std::io::Result<()> {
        for path in self.files_in_shared_memory()? {
            let file = std::fs::File::options().write(true).open(path)?;
            let length = file.metadata()?.len();
            if length > 0 {
                rustix::fs::fallocate(&file, rustix::fs::FallocateFlags::empty(), 0, length)?;
            }
        }
        Ok(())
    }

    /// Removes the access of other users to the domain's files: iceoryx2 leaves one of them, a counter, open to
    /// everybody.
    fn close_to_others(&self) -> std::io::Result<()> {
        for path in self.files_in_shared_memory()? {
            let mode = path.metadata()?.mode();
            std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode & 0o700))?;
        }
        Ok(())
    }

    fn files_in_shared_memory(&self) -> std::io::Result<Vec<PathBuf>> {
        if self.prefix.is_empty() {
            return Err(std::io::Error::new(std::io::ErrorKind::InvalidInput, "a domain without a prefix"));
        }
        let files = std::fs::read_dir("/dev/shm")?.flatten();
        let own = files.filter(|entry| entry.file_name().to_string_lossy().starts_with(&self.prefix));
        Ok(own.map(|entry| entry.path()).collect())
    }

    /// Removes everything that the domain's processes may have left. Only the process that created the domain may do
    /// so, after all others have ended.
    ///
    /// # Errors
    /// The first file that cannot be removed.
    pub fn remove(&self) -> std::io::Result<()> {
        // A folder that changes while it is listed may hide a file from the list: look until there is none.
        loop {
            let files = self.files_in_shared_memory()?;
            if files.is_empty() {
                break;
            }
            for file in files {
                remove_if_present(std::fs::remove_file(file))?;
            }
        }
        remove_if_present(std::fs::remove_dir_all(&self.root))
    }

    pub(crate) fn config(&self) -> Result<Config, PortError> {
        let failed = |error: &dyn std::fmt::Debug| PortError::new("open", &self.root.display().to_string(), error);
        let mut config = Config::default();
        let root = iceoryx2::prelude::Path::new(path_bytes(&self.root)).map_err(|e| failed(&e))?;
        config.global.set_root_path(&root);
        config.global.prefix = FileName::new(self.prefix.as_bytes()).map_err(|e| failed(&e))?;
        config.global.node.cleanup_dead_nodes_on_creation = false;
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        config.global.service.cleanup_dead_nodes_on_open = false;
        Ok(config)
    }
}

fn path_bytes(path: &Path) -> &[u8] {
    std::os::unix::ffi::OsStrExt::as_bytes(path.as_os_str())
}

fn remove_if_present(result: std::io::Result<()>) -> std::io::Result<()> {
    match result {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(()),
        other => other,
    }
}

/// Longest wait of a publisher for a reader whose buffer is full, unless set otherwise.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// A process's access to a domain.
#[derive(Debug)]
pub struct Domain {
    node: Node<ipc::Service>,
    patience: Duration,
}

impl Domain {
    /// Enters the domain as a node called `name`.
    ///
    /// # Errors
    /// [`PortError`] if the place cannot be used.
    pub fn enter(place: &Place, name: &str) -> Result<Self, PortError> {
        set_log_level_from_env_or(LogLevel::Fatal);
        let failed = |error: &dyn std::fmt::Debug| PortError::new("enter the domain as", name, error);
        let node_name = NodeName::new(name).map_err(|e| failed(&e))?;
        let node = NodeBuilder::new()
            .name(&node_name)
            .config(&place.config()?)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map_err(|e| failed(&e))?;
        Ok(Self { node, patience: PATIENCE })
    }

    /// The same access with another patience of publishers for readers whose buffers are full.
    pub fn with_patience(self, patience: Duration) -> Self {
        Self { patience, ..self }
    }

    /// Removes what dead nodes have left behind, including their ports on the topics. Only the launcher may do so:
    /// messages of a dead publisher to which a reader has not yet connected are lost with that publisher.
    pub fn clean_up_after_the_dead(&self) {
        let _ = self.node.try_cleanup_dead_nodes();
    }

    /// A way to receive the messages of a topic.
    ///
    /// # Errors
    /// [`PortError`] if the topic does not exist, is of another version, or has no room for another reader.
    pub fn inlet<T: Topic>(&self) -> Result<Inlet<T>, PortError> {
        Inlet::create(self.open::<T>()?, READER)
    }

    /// A way to send messages of at most `most_items` items on a topic.
    ///
    /// # Errors
    /// [`PortError`] if the topic does not exist, is of another version, or has no room for another publisher.
    pub fn outlet<T: Topic>(&self, most_items: usize) -> Result<Outlet<T>, PortError> {
        Outlet::create(self.open::<T>()?, most_items, self.patience)
    }

    pub(crate) fn open<T: Topic>(&self) -> Result<Services<T>, PortError> {
        let failed = |error: &dyn std::fmt::Debug| PortError::new("open", T::NAME, error);
        let name = ServiceName::new(T::NAME).map_err(|e| failed(&e))?;
        let messages = self
            .node
            .service_builder(&name)
            .publish_subscribe::<[T::Item]>()
            .user_header::<T::Header>()
            .open()
            .map_err(|e| failed(&e))?;
        let events = self.node.service_builder(&name).event().open().map_err(|e| failed(&e))?;
        Ok((messages, events))
    }

    fn create<T: Topic>(&self, capacity: &Capacity) -> Result<Services<T>, PortError> {
        let failed = |error: &dyn std::fmt::Debug| PortError::new("create", T::NAME, error);
        let name = ServiceName::new(T::NAME).map_err(|e| failed(&e))?;
        let depth = T::depth(capacity);
        let messages = self
            .node
            .service_builder(&name)
            .publish_subscribe::<[T::Item]>()
            .user_header::<T::Header>()
            .enable_safe_overflow(T::LATCHED)
            .history_size(history::<T>(capacity))
            .subscriber_max_buffer_size(depth)
            .subscriber_max_borrowed_samples(MOST_HELD)
            .max_publishers(capacity.nodes())
            .max_subscribers(capacity.nodes())
            .max_nodes(capacity.nodes())
            .create()
            .map_err(|e| failed(&e))?;
        let events = self
            .node
            .service_builder(&name)
            .event()
            .max_notifiers(2 * capacity.nodes())
            .max_listeners(capacity.nodes())
            .max_nodes(capacity.nodes())
            .create()
            .map_err(|e| failed(&e))?;
        Ok((messages, events))
    }
}

/// Number of messages of a topic that are kept for later readers.
fn history<T: Topic>(capacity: &Capacity) -> usize {
    if T::LATCHED { 1 } else { T::depth(capacity) }
}

/// Approximate length of the file in shared memory that holds all messages of one publisher \[bytes\], if each has at
/// most `most_items` items. The file has room for the messages that every reader may leave waiting or hold, for those
/// that are kept for later readers, and for those that are being written. Only messages that are written take up
/// memory.
pub fn segment_bytes<T: Topic>(capacity: &Capacity, most_items: u64) -> u64 {
    let waiting = capacity.nodes() * (T::depth(capacity) + MOST_HELD);
    let messages = (waiting + history::<T>(capacity) + MOST_DRAFTS) as u64;
    let message = most_items.saturating_mul(size_of::<T::Item>() as u64).saturating_add(size_of::<T::Header>() as u64);
    messages.saturating_mul(message.saturating_add(MESSAGE_OVERHEAD))
}

/// The domain of a run, with every topic held open. Dropping it closes them; [`Place::remove`] then removes the rest.
#[derive(Debug)]
pub struct HeldDomain {
    /// The holder's own access.
    pub domain: Domain,
    _scenario: Services<Scenario>,
    _snapshot: Services<Snapshot>,
    _density: Services<Density>,
    _passage: Services<Passage>,
    _comparison: Services<Comparison>,
    _status: Services<Status>,
    _roster: Services<Roster>,
    _request: Services<Request>,
}

impl HeldDomain {
    /// Creates the domain at `place` and all topics in it.
    ///
    /// # Errors
    /// [`PortError`] if that fails. What was created until then must still be removed with [`Place::remove`].
    pub fn create(place: &Place, capacity: &Capacity) -> Result<Self, PortError> {
        place.create().map_err(|e| PortError::new("create", &place.root.display().to_string(), &e))?;
        let domain = Domain::enter(place, "launcher")?;
        place.close_to_others().map_err(|e| PortError::new("close to others", &place.prefix, &e))?;
        Ok(Self {
            _scenario: domain.create::<Scenario>(capacity)?,
            _snapshot: domain.create::<Snapshot>(capacity)?,
            _density: domain.create::<Density>(capacity)?,
            _passage: domain.create::<Passage>(capacity)?,
            _comparison: domain.create::<Comparison>(capacity)?,
            _status: domain.create::<Status>(capacity)?,
            _roster: domain.create::<Roster>(capacity)?,
            _request: domain.create::<Request>(capacity)?,
            domain,
        })
    }
}

#[cfg(test)]
mod tests;

//! Sleeping until a message or a signal to stop arrives, without polling.

use std::cell::RefCell;
use std::io::Read;
use std::os::fd::AsRawFd;
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use iceoryx2::identifiers::UniqueListenerId;
use iceoryx2::port::listener::Listener;
use iceoryx2::prelude::*;
use iceoryx2::waitset::WaitSetRunError;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use crate::port_error::PortError;

/// Signals that ask a process to stop.
const STOP: [i32; 3] = [SIGINT, SIGTERM, SIGHUP];

/// Signals to this process, caught from its creation on: for each signal a byte arrives on a socket, which a wait can
/// watch.
#[derive(Debug)]
pub struct Signals {
    pipe: Wakeup,
    stop: Arc<AtomicBool>,
    /// Receives one byte per request to stop.
    requests: UnixStream,
    /// The signals that ask to stop.
    heeded: Vec<i32>,
    watch: RefCell<Option<Watch>>,
}

#[derive(Debug)]
struct Wakeup {
    stream: UnixStream,
    descriptor: FileDescriptor,
}

impl FileDescriptorBased for Wakeup {
    fn file_descriptor(&self) -> &FileDescriptor {
        &self.descriptor
    }
}

impl SynchronousMultiplexing for Wakeup {}

impl Signals {
    /// Catches SIGINT, SIGTERM and SIGHUP, which ask the process to stop, and wakes up for `others` as well. SIGHUP
    /// stays ignored if the process was started that way, for example by `nohup`.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub fn catch(others: &[i32]) -> std::io::Result<Self> {
        let heeded = STOP.into_iter().filter(|&signal| signal != SIGHUP || !is_ignored(SIGHUP)).collect();
        Self::catch_only(heeded, others)
    }

    /// As `catch`, but the loss of the terminal, which SIGHUP reports, is no request to stop.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub fn outlive_terminal(others: &[i32]) -> std::io::Result<Self> {
        let hangup = if is_ignored(SIGHUP) { None } else { Some(SIGHUP) };
        let others: Vec<i32> = others.iter().copied().chain(hangup).collect();
        Self::catch_only(vec![SIGINT, SIGTERM], &others)
    }

    fn catch_only(heeded: Vec<i32>, others: &[i32]) -> std::io::Result<Self> {
        let (stream, sender) = UnixStream::pair()?;
        stream.set_nonblocking(true)?;
        let (requests, asker) = UnixStream::pair()?;
        requests.set_nonblocking(true)?;
        let stop = Arc::<AtomicBool>::default();
        for &signal in &heeded {
            // In this order, so that the byte is there once the flag is seen.
            signal_hook::low_level::pipe::register(signal, asker.try_clone()?)?;
            signal_hook::flag::register(signal, Arc::clone(&stop))?;
        }
        for &signal in heeded.iter().chain(others) {
            signal_hook::low_level::pipe::register(signal, sender.try_clone()?)?;
        }
        let descriptor = FileDescriptor::non_owning_new(stream.as_raw_fd())
            .ok_or_else(|| std::io::Error::other("the signal socket has no descriptor"))?;
        Ok(Self { pipe: Wakeup { stream, descriptor }, stop, requests, heeded, watch: RefCell::default() })
    }

    /// Ends the process once `grace` has passed since it was asked to stop, for example if it is still deep in a
    /// computation.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub fn end_process_after(&self, grace: Duration) -> std::io::Result<()> {
        let (mut stream, sender) = UnixStream::pair()?;
        for &signal in &self.heeded {
            signal_hook::low_level::pipe::register(signal, sender.try_clone()?)?;
        }
        let wait_and_end = move || {
            if matches!(stream.read(&mut [0]), Ok(1)) {
                std::thread::sleep(grace);
                std::process::exit(0);
            }
        };
        std::thread::Builder::new().name("last-resort".into()).spawn(wait_and_end).map(drop)
    }

    /// Whether the process has been asked to stop.
    pub fn stop_requested(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Returns how many requests to stop have come since the last call. After that the process counts as not asked to
    /// stop, until the next request comes.
    pub fn take_requests(&self) -> usize {
        self.stop.store(false, Ordering::Relaxed);
        (&self.requests).read(&mut [0; 16]).unwrap_or(0)
    }

    /// Sleeps until something arrives on one of the ports, a signal comes, or `timeout` has passed. It may return
    /// early, so check all ports after each return.
    ///
    /// # Errors
    /// [`PortError`] if the wait set cannot be made.
    pub fn wait(&self, ports: &[&dyn Awaited], timeout: Duration) -> Result<(), PortError> {
        if self.stop_requested() {
            return Ok(());
        }
        let failed = |error: &dyn std::fmt::Debug| PortError::new("wait", "wait set", error);
        let mut kept = self.watch.borrow_mut();
        if kept.as_ref().is_some_and(|watch| !watch.is_of(ports)) {
            *kept = None;
        }
        let watch = match &mut *kept {
            Some(watch) => watch,
            none => none.insert(Watch::new(&self.pipe, ports).map_err(|e| failed(&e))?),
        };
        for port in watch.wait(timeout).map_err(|e| failed(&e))? {
            match ports.get(port) {
                Some(port) => port.attend(),
                None => self.drain(),
            }
        }
        Ok(())
    }

    fn drain(&self) {
        let mut bytes = [0; 64];
        while matches!((&self.pipe.stream).read(&mut bytes), Ok(count) if count == bytes.len()) {}
    }
}

/// Whether this process ignores a signal, according to the kernel. A child process inherits this from its parent.
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// The wait set of the last wait. It is kept, since most waits are for the same ports as the one before.
#[derive(Debug)]
struct Watch {
    /// In a box, since the identifiers of its members contain the address of the set.
    set: Box<WaitSet<ipc::Service>>,
    /// The set's identifier of each port, and after them that of the signals.
    names: Vec<WaitSetAttachmentId<ipc::Service>>,
    listeners: Vec<UniqueListenerId>,
}

impl Watch {
    fn new(signals: &Wakeup, ports: &[&dyn Awaited]) -> Result<Self, Box<dyn std::fmt::Debug>> {
        let set = WaitSetBuilder::new()
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map(Box::new)
            .map_err(|e| Box::new(e) as _)?;
        let mut names = Vec::new();
        {
            let mut keep = |guard: WaitSetGuard<'_, '_, ipc::Service>| {
                names.push(WaitSetAttachmentId::from_guard(&guard));
                // The kernel detaches a descriptor when the descriptor or the set is closed: nothing is left for the
                // guard to do.
                std::mem::forget(guard);
            };
            for port in ports {
                keep(set.attach_notification(port.listener()).map_err(|e| Box::new(e) as _)?);
            }
            keep(set.attach_notification(signals).map_err(|e| Box::new(e) as _)?);
        }
        Ok(Self { set, names, listeners: ports.iter().map(|port| port.listener().id()).collect() })
    }

    fn is_of(&self, ports: &[&dyn Awaited]) -> bool {
        self.listeners.iter().copied().eq(ports.iter().map(|port| port.listener().id()))
    }

    /// The positions of the ports on which something has arrived; the number of ports stands for the signals.
    fn wait(&self, timeout: Duration) -> Result<Vec<usize>, WaitSetRunError> {
        let mut arrived = Vec::new();
        let note = |id| {
            arrived.extend(self.names.iter().position(|name| *name == id));
            CallbackProgression::Continue
        };
        self.set.wait_and_process_once_with_timeout(note, timeout)?;
        Ok(arrived)
    }
}

/// A port for which events arrive.
pub trait Awaited {
    /// The listener to watch.
    fn listener(&self) -> &Listener<ipc::Service>;

    /// Takes the events that have arrived and does what they ask for.
    fn attend(&self);
}

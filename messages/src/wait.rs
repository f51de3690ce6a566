//! Sleeping until a message or a signal to stop arrives. Nobody spins.

use std::io::Read;
use std::os::fd::AsRawFd;
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use iceoryx2::port::listener::Listener;
use iceoryx2::prelude::*;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use crate::port::PortError;

/// Signals that ask a process to stop.
const STOP: [i32; 3] = [SIGINT, SIGTERM, SIGHUP];

/// Signals to this process, caught from now on: a byte arrives on a socket for each, so that waiting can watch it.
#[derive(Debug)]
pub struct Signals {
    pipe: Wakeup,
    stop: Arc<AtomicBool>,
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
    /// Catches SIGINT, SIGTERM and SIGHUP, which ask the process to stop, and wakes up for `others` as well.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub fn catch(others: &[i32]) -> std::io::Result<Self> {
        let (stream, sender) = UnixStream::pair()?;
        stream.set_nonblocking(true)?;
        let stop = Arc::<AtomicBool>::default();
        for signal in STOP {
            signal_hook::flag::register(signal, Arc::clone(&stop))?;
        }
        for &signal in STOP.iter().chain(others) {
            signal_hook::low_level::pipe::register(signal, sender.try_clone()?)?;
        }
        let descriptor = FileDescriptor::non_owning_new(stream.as_raw_fd())
            .ok_or_else(|| std::io::Error::other("the signal socket has no descriptor"))?;
        Ok(Self { pipe: Wakeup { stream, descriptor }, stop })
    }

    /// Ends the process `grace` after it has been asked to stop, should it still be there: deep in a computation, say.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub fn end_process_after(&self, grace: Duration) -> std::io::Result<()> {
        let (mut stream, sender) = UnixStream::pair()?;
        for signal in STOP {
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

    /// Sleeps until something arrives on one of the ports, a signal comes, or `timeout` has passed. May return early;
    /// look at everything after each return.
    ///
    /// # Errors
    /// [`PortError`] if the wait set cannot be made.
    pub fn wait(&self, ports: &[&dyn Awaited], timeout: Duration) -> Result<(), PortError> {
        if self.stop_requested() {
            return Ok(());
        }
        let failed = |error: &dyn std::fmt::Debug| PortError::new("wait", "wait set", error);
        let set = WaitSetBuilder::new()
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map_err(|e| failed(&e))?;
        let _signal_guard = set.attach_notification(&self.pipe).map_err(|e| failed(&e))?;
        let _guards = ports
            .iter()
            .map(|port| set.attach_notification(port.listener()))
            .collect::<Result<Vec<_>, _>>()
            .map_err(|e| failed(&e))?;
        set.wait_and_process_once_with_timeout(|_| CallbackProgression::Continue, timeout).map_err(|e| failed(&e))?;
        for port in ports {
            port.attend();
        }
        self.drain();
        Ok(())
    }

    fn drain(&self) {
        let mut bytes = [0; 64];
        while matches!((&self.pipe.stream).read(&mut bytes), Ok(count) if count == bytes.len()) {}
    }
}

/// Something that events arrive for.
pub trait Awaited {
    /// What to watch.
    fn listener(&self) -> &Listener<ipc::Service>;

    /// Takes the events that have arrived and does what they ask for.
    fn attend(&self);
}

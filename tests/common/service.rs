//! A service for requests, as a test starts, asks and ends it.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

use super::Bench;

/// Long past anything that a healthy machine takes; only to end a test that would hang.
pub const WATCHDOG: Duration = Duration::from_secs(120);

/// Two cases that are done in no time.
pub const SMALL: &str = "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 2_000\n\
     [[propagator]]\nlabel = \"dee\"\nnode = \"dee\"\nsamples = 441\n";

/// Starts a service for requests and waits until it prints that it serves.
pub fn start(bench: &Bench, launch: &Path) -> Child {
    let mut command = bench.phasecloud();
    command.arg("serve").arg(launch).arg("--out").arg(bench.path("served"));
    let mut service = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(service.stdout.take().unwrap()).read_line(&mut line).unwrap();
    assert!(line.contains("serving as"), "{line}");
    service
}

/// Asks the service to end, and returns its exit code.
pub fn end(mut service: Child) -> Option<i32> {
    kill_process(Pid::from_child(&service), Signal::INT).unwrap();
    let asked = Instant::now();
    loop {
        if let Some(status) = service.try_wait().unwrap() {
            return status.code();
        }
        assert!(asked.elapsed() < WATCHDOG, "the service does not end");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Submits a scenario file and waits for its results.
pub fn submit(bench: &Bench, file: &Path) -> std::process::Output {
    bench.phasecloud().arg("submit").arg(file).output().unwrap()
}

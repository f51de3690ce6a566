//! The processes of a run, found by their environment.

#![allow(dead_code, reason = "each test file uses its own part")]

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ExitStatus};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

/// A process whose environment names a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Process {
    pub pid: i32,
    /// The node's name, or the propagator's label.
    pub label: String,
}

/// Sends a signal to a process, if it is still there.
pub fn signal(process: &Process, signal: Signal) {
    let _ = kill_process(Pid::from_raw(process.pid).unwrap(), signal);
}

/// Far longer than a loaded machine needs; only ends a test that would hang.
pub const WATCHDOG: Duration = Duration::from_secs(180);

/// Calls `look` again and again until it finds something.
pub fn wait_for<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(begun.elapsed() < WATCHDOG, "{what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Waits for the end of a process.
pub fn end_of(child: &mut Child) -> ExitStatus {
    wait_for("the process does not end", || child.try_wait().unwrap())
}

/// Sends a signal to a child.
pub fn signal_child(child: &Child, signal: Signal) {
    kill_process(Pid::from_child(child), signal).unwrap();
}

/// The output of a process, line by line as it comes.
pub struct Said {
    lines: Receiver<String>,
    /// The output so far.
    pub so_far: String,
}

impl Said {
    pub fn by(output: impl Read + Send + 'static) -> Self {
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            BufReader::new(output).lines().map_while(Result::ok).try_for_each(|line| sender.send(line))
        });
        Self { lines, so_far: String::new() }
    }

    /// Waits for a line that contains these words.
    pub fn wait_for(&mut self, words: &str) {
        let begun = Instant::now();
        loop {
            let left = WATCHDOG.saturating_sub(begun.elapsed());
            let line = self.lines.recv_timeout(left).unwrap_or_else(|_| panic!("no \"{words}\" in {}", self.so_far));
            self.so_far += &format!("{line}\n");
            if line.contains(words) {
                return;
            }
        }
    }

    /// All output until the end.
    pub fn rest(mut self) -> String {
        self.so_far += &self.lines.iter().map(|line| line + "\n").collect::<String>();
        self.so_far
    }
}

/// Processes of the run whose domain lies below `folder`, other than the launcher itself.
pub fn of_runs_below(folder: &Path) -> Vec<Process> {
    let root = format!("PHASECLOUD_ROOT={}", folder.display());
    let of_run = |(pid, variables): (i32, Vec<String>)| {
        variables.iter().find(|variable| variable.starts_with(&root))?;
        let label = variables.iter().find_map(|variable| variable.strip_prefix("PHASECLOUD_NODE="))?.to_owned();
        Some(Process { pid, label })
    };
    environments().filter_map(of_run).collect()
}

/// All processes that may be read, with the variables of their environments.
fn environments() -> impl Iterator<Item = (i32, Vec<String>)> {
    std::fs::read_dir("/proc").unwrap().flatten().filter_map(|entry| {
        let pid = entry.file_name().to_str()?.parse().ok()?;
        let environment = std::fs::read(entry.path().join("environ")).ok()?;
        let variables =
            environment.split(|&byte| byte == 0).map(|variable| String::from_utf8_lossy(variable).into_owned());
        Some((pid, variables.collect()))
    })
}

/// Ends the launchers whose temporary folder is `folder`, with the processes of their runs, and waits until they are
/// gone.
pub fn end_launchers_of(folder: &Path) {
    let temporary = format!("TMPDIR={}", folder.display());
    let is_launcher = |variables: &[String]| {
        variables.contains(&temporary) && !variables.iter().any(|variable| variable.starts_with("PHASECLOUD_NODE="))
    };
    let launchers = || environments().filter(|(_, variables)| is_launcher(variables)).map(|(pid, _)| pid);
    let begun = Instant::now();
    for pid in launchers() {
        let _ = kill_process(Pid::from_raw(pid).unwrap(), Signal::TERM);
    }
    while launchers().next().is_some() && begun.elapsed() < WATCHDOG {
        std::thread::sleep(Duration::from_millis(10));
    }
}

//! Child processes: started, watched, and ended without exception.

use std::io::{BufRead, BufReader, PipeReader, Read};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use kit::log::{FORMAT_VARIABLE, LEVEL_VARIABLE};
use messages::text::printable;
use rustix::process::{Pid, Signal, kill_process_group, test_kill_process_group};

use crate::crew::log_sink::LogSink;

/// Longest line that is passed on in one piece \[bytes\].
const LONGEST_LINE: u64 = 1 << 12;
/// How long a process may take to end after it was asked to.
const GRACE: Duration = Duration::from_millis(1500);

/// What is said of the end of a process that was asked to end.
pub const ON_REQUEST: &str = "ended on request";

/// A process of the run.
#[derive(Debug)]
struct Process {
    name: String,
    child: Child,
    end: Option<ExitStatus>,
    /// Whether it was there when all were asked to end.
    asked: bool,
}

impl Process {
    /// Looks whether the process has ended.
    fn reap(&mut self) -> Option<ExitStatus> {
        if self.end.is_none() {
            self.end = self.child.try_wait().ok().flatten();
        }
        self.end
    }

    /// How it ended, in words. An interpreter that is asked twice, or while it is ending, has no handler left and is
    /// ended by the signal; this counts as an end on request.
    fn end_in_words(&self) -> Option<String> {
        let status = self.end?;
        let is_on_request = status.success() || status.signal() == Some(Signal::TERM.as_raw());
        Some(if self.asked && is_on_request { ON_REQUEST.into() } else { status.to_string() })
    }

    /// Signals the process and whatever it has started itself.
    fn signal(&self, signal: Signal) {
        if let Some(group) = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw) {
            let _ = kill_process_group(group, signal);
        }
    }
}

/// A process that has ended, and how.
#[derive(Debug)]
pub struct Ended {
    /// Its name.
    pub name: String,
    /// How it ended.
    pub status: ExitStatus,
}

/// All processes of a run. Dropping it kills those that are left.
#[derive(Default)]
pub struct Supervisor {
    processes: Vec<Process>,
    /// The log that takes the output of the processes; without it the output goes to standard error.
    log: Option<LogSink>,
    /// The threads that pass the output on to standard error.
    speakers: Vec<JoinHandle<()>>,
}

impl Supervisor {
    /// No processes yet; their output will go to `log`.
    pub fn new(log: LogSink) -> Self {
        Self { processes: Vec::new(), log: Some(log), speakers: Vec::new() }
    }

    /// Starts a process in a group of its own, so that Ctrl-C reaches the launcher alone.
    ///
    /// # Errors
    /// If the program cannot be started.
    pub fn start(&mut self, name: &str, mut command: Command) -> Result<(), String> {
        let program = command.get_program().to_string_lossy().into_owned();
        let failed = |e: std::io::Error| format!("{program} cannot be started: {e}");
        command.stdin(Stdio::null()).process_group(0);
        let child = match &self.log {
            Some(log) => {
                let (output, input) = std::io::pipe().map_err(failed)?;
                command.stdout(input.try_clone().map_err(failed)?).stderr(input);
                command.env(FORMAT_VARIABLE, "json").env(LEVEL_VARIABLE, log.level().to_string());
                // The log listens before the process starts, so that no output is lost.
                log.follow(name, output).map_err(failed)?;
                command.spawn().map_err(failed)?
            }
            None => {
                let (output, input) = std::io::pipe().map_err(failed)?;
                command.stdout(input.try_clone().map_err(failed)?).stderr(input);
                self.speakers.push(std::thread::Builder::new().spawn(move || pass_on(output)).map_err(failed)?);
                command.spawn().map_err(failed)?
            }
        };
        tracing::info!(process = child.id(), "started {name}");
        self.processes.push(Process { name: name.into(), child, end: None, asked: false });
        Ok(())
    }

    /// The processes that have ended since the last call, and how they ended.
    pub fn newly_ended(&mut self) -> Vec<Ended> {
        self.processes
            .iter_mut()
            .filter(|process| process.end.is_none())
            .filter_map(|process| Some(Ended { name: process.name.clone(), status: process.reap()? }))
            .inspect(|Ended { name, status }| tracing::info!("{name} has ended: {status}"))
            .collect()
    }

    /// Kills one process.
    pub fn kill(&mut self, name: &str) {
        for process in self.processes.iter().filter(|process| process.name == name && process.end.is_none()) {
            process.signal(Signal::KILL);
        }
    }

    /// Kills what a process that has ended may have left behind in its group.
    pub fn kill_leftovers(&self, name: &str) {
        for process in self.processes.iter().filter(|process| process.name == name && process.end.is_some()) {
            process.signal(Signal::KILL);
        }
    }

    /// Asks all processes to end, and does not wait.
    pub fn ask_to_end(&mut self) {
        for process in self.processes.iter_mut().filter(|process| process.end.is_none()) {
            process.asked = process.reap().is_none();
            process.signal(Signal::TERM);
        }
    }

    /// Whether a process that has ended left others behind in its group.
    pub fn left_others(&self) -> bool {
        let group = |process: &Process| i32::try_from(process.child.id()).ok().and_then(Pid::from_raw);
        let ended = self.processes.iter().filter(|process| process.end.is_some());
        ended.filter_map(group).any(|group| test_kill_process_group(group).is_ok())
    }

    /// Asks all processes to end, kills those that have not ended after a while, and returns how each ended.
    pub fn stop_all(&mut self) -> Vec<(String, String)> {
        self.ask_to_end();
        let deadline = Instant::now() + GRACE;
        while Instant::now() < deadline && self.processes.iter_mut().any(|process| process.reap().is_none()) {
            std::thread::sleep(Duration::from_millis(2));
        }
        for process in &mut self.processes {
            // Also after a normal end: a program may have left children behind in its group.
            process.signal(Signal::KILL);
            if process.end.is_none() {
                process.end = process.child.wait().ok();
            }
        }
        self.processes.iter().filter_map(|process| Some((process.name.clone(), process.end_in_words()?))).collect()
    }
}

impl Drop for Supervisor {
    fn drop(&mut self) {
        self.stop_all();
        let deadline = Instant::now() + GRACE;
        while Instant::now() < deadline && !self.speakers.iter().all(JoinHandle::is_finished) {
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

/// Prints the output of a program line by line and escaped, so that it cannot command a terminal.
fn pass_on(output: PipeReader) {
    let mut output = BufReader::new(output);
    let mut bytes = Vec::new();
    while matches!(output.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut bytes), Ok(1..)) {
        remark!("{}", printable(String::from_utf8_lossy(&bytes).trim_end_matches(['\r', '\n'])));
        bytes.clear();
    }
}

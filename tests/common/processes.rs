//! The processes of a run, found by their environment.

#![allow(dead_code, reason = "each test file uses its own part")]

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

/// Processes of the run whose domain lies below `folder`, other than the launcher itself.
pub fn of_runs_below(folder: &std::path::Path) -> Vec<Process> {
    let root = format!("PHASECLOUD_ROOT={}", folder.display());
    let processes = std::fs::read_dir("/proc").unwrap().flatten();
    let process = |entry: std::fs::DirEntry| {
        let pid = entry.file_name().to_str()?.parse().ok()?;
        let environment = std::fs::read(entry.path().join("environ")).ok()?;
        let variables = || environment.split(|&byte| byte == 0).map(String::from_utf8_lossy);
        variables().find(|variable| variable.starts_with(&root))?;
        let label = variables().find_map(|variable| Some(variable.strip_prefix("PHASECLOUD_NODE=")?.to_owned()))?;
        Some(Process { pid, label })
    };
    processes.filter_map(process).collect()
}

//! A home host and its workers, each in a folder of its own.

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

use crate::common::Bench;
use crate::common::processes::of_runs_below;

/// Far longer than a loaded machine needs; only ends a test that would hang.
pub const WATCHDOG: Duration = Duration::from_secs(180);

/// Cases over three hosts, and one at home.
pub const CASES: &str = r#"
[[propagator]]
label = "mc"
node = "mc"
samples = 6_000
seed = 11
shards = 5
hosts = ["worker-a", "worker-b", "home"]

[[propagator]]
label = "dee"
node = "dee"
samples = 961
hosts = ["worker-b"]

[[propagator]]
label = "gmm-ut"
node = "gmm-ut"
mode = "as-printed"
"#;

/// The same cases without other hosts and without shards.
pub fn alone(cases: &str) -> String {
    let plain = |line: &&str| !line.starts_with("hosts =") && !line.starts_with("shards =");
    cases.lines().filter(plain).collect::<Vec<_>>().join("\n")
}

pub fn free_port() -> u16 {
    std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// A home host, its workers, and the port at which they meet.
pub struct Site {
    pub home: Bench,
    pub workers: Vec<(String, Bench)>,
    pub port: u16,
}

impl Site {
    pub fn new(workers: &[&str]) -> Self {
        let worker = |name: &&str| ((*name).to_owned(), Bench::new());
        Self { home: Bench::new(), workers: workers.iter().map(worker).collect(), port: free_port() }
    }

    /// A launch file with these cases, and a `[hosts]` table with the further lines `more`.
    pub fn launch_file(&self, name: &str, cases: &str, more: &str) -> PathBuf {
        let names: Vec<&str> = self.workers.iter().map(|(name, _)| name.as_str()).collect();
        let hosts = format!("[hosts]\nnames = {names:?}\nlisten = \"tcp/127.0.0.1:{}\"\n{more}\n", self.port);
        self.home.launch_file(name, &format!("{hosts}{cases}"))
    }

    /// Starts `phasecloud run` at home.
    pub fn run(&self, launch: &std::path::Path, more: &[&str]) -> Child {
        let mut command = self.home.phasecloud();
        command.arg("run").arg(launch).arg("--no-report").arg("--out").arg(self.home.path("out")).args(more);
        spawn(command)
    }

    /// Starts `phasecloud join` on worker number `index`; it connects to `port`.
    pub fn join(&self, index: usize, port: u16) -> Child {
        let (name, bench) = &self.workers[index];
        let mut command = bench.phasecloud();
        command.args(["join", "--connect", &format!("tcp/127.0.0.1:{port}"), "--name", name]);
        spawn(command)
    }

    pub fn join_all(&self) -> Vec<Child> {
        (0..self.workers.len()).map(|index| self.join(index, self.port)).collect()
    }

    /// Checks that nothing is left of any host's domain.
    pub fn check_clean(&self) {
        for bench in self.workers.iter().map(|(_, bench)| bench).chain([&self.home]) {
            wait_until("processes end", || of_runs_below(&bench.path("")).is_empty());
            assert_eq!(bench.domains(), [""; 0]);
        }
    }

    /// Waits until a process called `name` runs in `bench`.
    pub fn await_process(bench: &Bench, name: &str) {
        wait_until(name, || of_runs_below(&bench.path("")).iter().any(|process| process.label == name));
    }
}

pub fn spawn(mut command: Command) -> Child {
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

pub fn signal(child: &Child, signal: Signal) {
    kill_process(Pid::from_child(child), signal).unwrap();
}

pub fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < WATCHDOG, "in vain: {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Waits for the end; returns the exit code and standard error.
pub fn end(mut child: Child) -> (Option<i32>, String) {
    let (mut out, mut errors) = (child.stdout.take().unwrap(), child.stderr.take().unwrap());
    let out = std::thread::spawn(move || std::io::read_to_string(&mut out).unwrap_or_default());
    let errors = std::thread::spawn(move || std::io::read_to_string(&mut errors).unwrap_or_default());
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if start.elapsed() > WATCHDOG {
            child.kill().unwrap();
            panic!("it hangs: {}", errors.join().unwrap());
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    (status.code(), out.join().unwrap() + &errors.join().unwrap())
}

pub fn end_well(child: Child) -> String {
    let (code, said) = end(child);
    assert_eq!(code, Some(0), "{said}");
    said
}

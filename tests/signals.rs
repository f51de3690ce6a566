//! Ends that were not planned: signals to the launcher.
#![allow(missing_docs)]

mod common;

use std::process::{Child, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use common::Bench;
use rustix::process::{Pid, Signal, kill_process};

/// A case that computes for as long as a test may need.
const LONG: &str = "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 20_000_000\n";

/// Far longer than a healthy machine needs; only ends a test that would hang.
const WATCHDOG: Duration = Duration::from_secs(180);

fn spawn(bench: &Bench, cases: &str) -> Child {
    let launch = bench.launch_file("long", cases);
    let mut command = bench.phasecloud();
    command.arg("run").arg(launch).arg("--out").arg(bench.path("out"));
    command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// Starts a run and waits until all its processes compute.
fn start(bench: &Bench) -> (Child, String) {
    let known = bench.domains();
    let child = spawn(bench, LONG);
    let started = Instant::now();
    let run_id = loop {
        assert!(started.elapsed() < WATCHDOG, "the run did not start");
        std::thread::sleep(Duration::from_millis(20));
        let Some(run_id) = bench.domains().into_iter().find(|id| !known.contains(id)) else { continue };
        if processes_of(&run_id).len() == 5 {
            break run_id;
        }
    };
    (child, run_id)
}

/// Processes whose environment names the domain, other than the launcher itself.
fn processes_of(run_id: &str) -> Vec<String> {
    let processes = std::fs::read_dir("/proc").unwrap().flatten();
    processes
        .filter(|entry| {
            let environment = std::fs::read(entry.path().join("environ")).unwrap_or_default();
            environment.windows(run_id.len()).any(|window| window == run_id.as_bytes())
        })
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect()
}

fn signal(child: &Child, signal: Signal) {
    kill_process(Pid::from_child(child), signal).unwrap();
}

fn wait(child: &mut Child) -> ExitStatus {
    let started = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status;
        }
        assert!(started.elapsed() < WATCHDOG, "the launcher did not end");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn wait_until_gone(run_id: &str) {
    let started = Instant::now();
    while !processes_of(run_id).is_empty() {
        assert!(started.elapsed() < WATCHDOG, "orphans: {:?}", processes_of(run_id));
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn interrupt_and_terminate_end_every_process_and_remove_the_domain() {
    for request in [Signal::INT, Signal::TERM] {
        let bench = Bench::new();
        let (mut child, run_id) = start(&bench);
        signal(&child, request);
        assert_eq!(wait(&mut child).code(), Some(130));
        assert_eq!(processes_of(&run_id), [""; 0]);
        assert_eq!(common::shared_memory_of(&run_id), [""; 0]);
        assert_eq!(bench.domains(), [""; 0]);
        assert!(!bench.path("out").exists());
    }
}

#[test]
fn processes_end_by_themselves_when_the_launcher_is_killed_and_the_next_run_removes_their_domain() {
    let bench = Bench::new();
    let (mut child, run_id) = start(&bench);
    signal(&child, Signal::KILL);
    wait(&mut child);
    wait_until_gone(&run_id);
    assert_eq!(bench.domains(), std::slice::from_ref(&run_id));
    bench.run_well(&bench.launch_file("next", &LONG.replace("20_000_000", "100")), "next");
    assert_eq!(bench.domains(), [""; 0]);
    assert_eq!(common::shared_memory_of(&run_id), [""; 0]);
}

#[test]
fn clean_removes_a_dead_domain_and_leaves_a_live_one() {
    let bench = Bench::new();
    let (mut live, live_id) = start(&bench);
    let (mut dead, dead_id) = start(&bench);
    signal(&dead, Signal::KILL);
    wait(&mut dead);
    wait_until_gone(&dead_id);
    let cleaned = common::text(&bench.phasecloud().arg("clean").output().unwrap().stdout);
    assert!(cleaned.lines().any(|line| line.starts_with("removed") && line.ends_with(&dead_id)), "{cleaned}");
    assert_eq!(common::shared_memory_of(&dead_id), [""; 0]);
    assert_eq!(bench.domains(), std::slice::from_ref(&live_id));
    assert_ne!(processes_of(&live_id), [""; 0]);
    signal(&live, Signal::TERM);
    wait(&mut live);
}

#[test]
fn a_foreign_program_and_what_it_has_started_end_with_the_launcher() {
    let bench = Bench::new();
    // A shell with a child process that ignores all signals that can be ignored.
    let deaf = "trap '' TERM INT HUP; sleep 600 & sleep 600";
    let cases = format!("{LONG}\n[[propagator]]\nlabel = \"deaf\"\ncommand = [\"sh\", \"-c\", \"{deaf}\"]\n");
    for request in [Signal::KILL, Signal::TERM] {
        let mut child = spawn(&bench, &cases);
        let started = Instant::now();
        let run_id = loop {
            assert!(started.elapsed() < WATCHDOG, "the run did not start");
            std::thread::sleep(Duration::from_millis(20));
            let Some(run_id) = bench.domains().pop() else { continue };
            if processes_of(&run_id).len() == 5 + 4 {
                break run_id;
            }
        };
        signal(&child, request);
        wait(&mut child);
        wait_until_gone(&run_id);
        bench.phasecloud().arg("clean").output().unwrap();
    }
}

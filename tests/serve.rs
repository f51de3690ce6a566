//! A service: the processes stay, scenario after scenario comes.
//!
//! `PHASECLOUD_SERVED` is the number of scenarios over which nothing may grow (default 40).
#![allow(missing_docs)]

mod common;

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use common::processes::{of_runs_below, signal};
use common::{Bench, FOUR_CASES, REPRODUCIBLE, number, text};
use rustix::process::{Pid, Signal, kill_process};

const WATCHDOG: Duration = Duration::from_secs(120);

const SMALL: &str = "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 2_000\n\
     [[propagator]]\nlabel = \"dee\"\nnode = \"dee\"\nsamples = 441\n";

fn sweep(bench: &Bench, vary: &str) -> std::path::PathBuf {
    bench.write("sweep.toml", &format!("scenario = \"scenario-1.toml\"\n[vary]\n{vary}\n"))
}

/// Starts a service for requests and waits until it says that it serves.
fn start(bench: &Bench, launch: &Path) -> Child {
    let mut command = bench.phasecloud();
    command.arg("serve").arg(launch).arg("--out").arg(bench.path("served"));
    let mut service = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(service.stdout.take().unwrap()).read_line(&mut line).unwrap();
    assert!(line.contains("serving as"), "{line}");
    service
}

fn end(mut service: Child) -> Option<i32> {
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

fn submit(bench: &Bench, file: &Path) -> std::process::Output {
    bench.phasecloud().arg("submit").arg(file).output().unwrap()
}

#[test]
fn a_sweep_makes_a_results_folder_a_scenario_and_one_table_of_all() {
    let bench = Bench::new();
    let launch = bench.launch_file("small", SMALL);
    let sweep = sweep(&bench, "\"initial.e\" = [0.1, 0.145]\n\"disposal.critical_e\" = [0.5, 0.6]");
    let mut command = bench.phasecloud();
    let output = command.arg("serve").arg(&launch).arg("--sweep").arg(sweep).args(["--out", "out"]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("4 scenarios in"), "{}", text(&output.stdout));
    assert_eq!(bench.table("out/moments.csv").len(), 4 * 2 * 5);
    // The last combination is scenario 1 itself.
    bench.run_well(&launch, "alone");
    for file in ["densities.npz", "moments.csv", "errors.csv", "first_passage.csv"] {
        let read = |name: &str| text(&bench.read(&format!("{name}/{file}")));
        let same = read("out/000003-scenario-1-3").replace("scenario-1-3", "scenario-1");
        assert!(file.ends_with("npz") || same == read("alone"), "{file}");
    }
    assert!(bench.path("out/000003-scenario-1-3/manifest.json").exists());
    assert_eq!(bench.domains(), [""; 0]);
}

#[test]
fn what_cannot_be_done_is_named_and_the_rest_of_a_sweep_is_done() {
    let bench = Bench::new();
    // Without oblateness and with so much radiation pressure, orbits reach e = 1.
    bench.write("scenario-1.toml", &common::SCENARIO_1.replace("0.40921", "0.0"));
    let launch = bench.launch_file("small", SMALL);
    let sweep = sweep(&bench, "\"orbit.radiation\" = [0.1, 3.0, 0.15]");
    let mut command = bench.phasecloud();
    let output = command.arg("serve").arg(&launch).arg("--sweep").arg(sweep).args(["--out", "out"]).output().unwrap();
    let errors = text(&output.stderr);
    assert!(errors.contains("scenario 1 of the sweep") && errors.contains("left the domain e < 1"), "{errors}");
    assert!(text(&output.stdout).contains("2 scenarios in"), "{}", text(&output.stdout));
}

#[test]
fn a_service_answers_requests_also_after_a_process_was_killed_and_ends_on_request() {
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES);
    bench.run_well(&launch, "alone");
    let service = start(&bench, &launch);
    for position in 0..5 {
        let output = submit(&bench, &bench.path("scenario-1.toml"));
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(text(&output.stdout).contains(&format!("recorded as {position:06}-scenario-1")));
        let victim = ["mc", "estimator", "recorder", "scenario", "comparator"][position];
        let process = of_runs_below(&bench.path("")).into_iter().find(|process| process.label == victim).unwrap();
        signal(&process, Signal::KILL);
    }
    let bad = bench.write(
        "bad.toml",
        &common::SCENARIO_1.replace("radiation = 0.15", "radiation = 3.0").replace("0.40921", "0.0"),
    );
    let output = submit(&bench, &bad);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("left the domain"), "{}", text(&output.stderr));
    assert_eq!(end(service), Some(0));
    for position in 0..5 {
        for file in REPRODUCIBLE {
            let served = bench.read(&format!("served/{position:06}-scenario-1/{file}"));
            assert!(served == bench.read(&format!("alone/{file}")), "{position}: {file}");
        }
    }
    assert_eq!(bench.domains(), [""; 0]);
    let nobody = submit(&bench, &bench.path("scenario-1.toml"));
    assert!(text(&nobody.stderr).contains("no live run"), "{}", text(&nobody.stderr));
}

/// Memory \[kB\] and descriptors of a process.
fn holdings(pid: i32) -> (u64, usize) {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap();
    let resident = status.lines().find_map(|line| line.strip_prefix("RssAnon:")).unwrap();
    let descriptors = std::fs::read_dir(format!("/proc/{pid}/fd")).unwrap().count();
    (resident.trim().trim_end_matches(" kB").parse().unwrap(), descriptors)
}

/// Bytes of shared memory that are in use below a prefix.
fn shared_memory(run_id: &str) -> u64 {
    use std::os::unix::fs::MetadataExt;
    let files = std::fs::read_dir("/dev/shm").unwrap().flatten();
    let ours = files.filter(|file| file.file_name().to_string_lossy().contains(run_id));
    ours.filter_map(|file| file.metadata().ok()).map(|data| data.blocks() * 512).sum()
}

#[test]
fn a_service_does_not_grow() {
    let bench = Bench::new();
    let service = start(&bench, &bench.launch_file("small", SMALL));
    let run_id = bench.domains().pop().unwrap();
    let request = |count: u64| {
        for _ in 0..count {
            assert!(submit(&bench, &bench.path("scenario-1.toml")).status.success());
        }
    };
    let served = number("PHASECLOUD_SERVED", 40);
    // Until every place in the pools of messages has been used once.
    request(10.max(served / 5));
    let processes = of_runs_below(&bench.path(""));
    assert_eq!(processes.len(), 6, "{processes:?}");
    let measure = || {
        std::thread::sleep(Duration::from_secs(1)); // the launcher cleans up after those who asked
        let held: Vec<_> = processes.iter().map(|process| holdings(process.pid)).collect();
        (
            held,
            shared_memory(&run_id),
            std::fs::read_dir("/dev/shm")
                .unwrap()
                .flatten()
                .filter(|f| f.file_name().to_string_lossy().contains(&run_id))
                .count(),
        )
    };
    let (before, shared_before, files_before) = measure();
    request(served);
    let (mut after, mut shared_after, mut files_after) = measure();
    // A connection to who has just asked may still be open, or not yet. What a slow launcher has still to clean up goes; what
    // has leaked stays.
    let is_tidy = |after: &[(u64, usize)], files: usize| {
        files <= files_before + 4 && before.iter().zip(after).all(|(before, after)| after.1 <= before.1 + 4)
    };
    let tidying = Instant::now();
    while !is_tidy(&after, files_after) && tidying.elapsed() < WATCHDOG {
        (after, shared_after, files_after) = measure();
    }
    for ((process, before), after) in processes.iter().zip(&before).zip(&after) {
        println!("{}: {before:?} -> {after:?} (kB, descriptors) over {served} scenarios", process.label);
        assert!(after.1 <= before.1 + 4, "descriptors of {}: {before:?} -> {after:?}", process.label);
        // Allocators keep some; a leak of one small snapshot a scenario would be 32 kB x scenarios.
        assert!(after.0 < before.0 + 4096 + 4 * served, "memory of {}: {before:?} -> {after:?}", process.label);
    }
    println!("shared memory: {shared_before} -> {shared_after} bytes, {files_before} -> {files_after} files");
    // A few connections may not have been used before, however many scenarios come.
    assert!(files_after <= files_before + 4, "{files_before} -> {files_after}");
    assert!(shared_after <= shared_before + shared_before / 4, "{shared_before} -> {shared_after}");
    assert_eq!(end(service), Some(0));
}

//! Nothing depends on when a process starts, or on how long it is stopped.
//!
//! `PHASECLOUD_ORDERS` is the number of random orders (default 20), `PHASECLOUD_SEED` the first seed.
#![allow(missing_docs)]

mod common;

use std::process::Stdio;
use std::time::{Duration, Instant};

use common::processes::{of_runs_below, signal};
use common::{Bench, FOUR_CASES, REPRODUCIBLE, number, text};
use rustix::process::Signal;

#[test]
#[ignore = "long; .ci/long runs it"]
fn any_order_of_starts_gives_the_same_bytes() {
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES);
    bench.run_well(&launch, "whole");
    let first = number("PHASECLOUD_SEED", 1);
    let orders = number("PHASECLOUD_ORDERS", 20);
    for seed in first..first + orders {
        let out = format!("out-{seed}");
        let mut command = bench.phasecloud();
        command.arg("run").arg(&launch).args(["--quiet", "--no-report", "--start-order", &seed.to_string(), "--out"]);
        let output = command.arg(bench.path(&out)).output().unwrap();
        assert!(output.status.success(), "seed {seed}: {}", text(&output.stderr));
        for file in REPRODUCIBLE {
            let same = bench.read(&format!("{out}/{file}")) == bench.read(&format!("whole/{file}"));
            assert!(same, "seed {seed}: {file} differs");
        }
        std::fs::remove_dir_all(bench.path(&out)).unwrap();
    }
    println!("{orders} random orders, seeds from {first}: the same bytes");
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn a_reader_that_stands_still_for_a_while_loses_nothing() {
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES);
    bench.run_well(&launch, "whole");
    for label in ["estimator", "comparator", "recorder", "scenario"] {
        let held_up = (0..20).any(|attempt| stands_still(&bench, &launch, label, attempt));
        assert!(held_up, "the run does without its {label}");
    }
}

/// Runs with one process stopped for a while from its start on, and compares. Returns whether the run waited for the
/// process: on a busy machine it may have done its part before it could be stopped.
fn stands_still(bench: &Bench, launch: &std::path::Path, label: &str, attempt: u32) -> bool {
    let out = format!("out-{label}-{attempt}");
    let mut command = bench.phasecloud();
    command.arg("run").arg(launch).args(["--quiet", "--no-report", "--out"]).arg(bench.path(&out));
    let mut run = command.stderr(Stdio::piped()).spawn().unwrap();
    let begun = Instant::now();
    let sleeper = loop {
        assert!(begun.elapsed() < Duration::from_secs(180), "{label} does not start");
        if let Some(found) = of_runs_below(&bench.path("")).into_iter().find(|process| process.label == label) {
            break found;
        }
    };
    signal(&sleeper, Signal::STOP);
    std::thread::sleep(Duration::from_millis(500));
    let held_up = run.try_wait().unwrap().is_none();
    signal(&sleeper, Signal::CONT);
    let output = run.wait_with_output().unwrap();
    assert!(output.status.success(), "{label}: {}", text(&output.stderr));
    for file in REPRODUCIBLE {
        let same = bench.read(&format!("{out}/{file}")) == bench.read(&format!("whole/{file}"));
        assert!(same, "{label}: {file} differs");
    }
    held_up
}

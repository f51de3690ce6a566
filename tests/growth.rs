//! A service that answers scenario after scenario holds no more memory, descriptors and shared memory with time.
//!
//! `PHASECLOUD_SERVED` is the number of scenarios over which nothing may grow (default 40).
#![allow(missing_docs)]

mod common;

use std::time::{Duration, Instant};

use common::processes::of_runs_below;
use common::service::{SMALL, WATCHDOG, end, start, submit};
use common::{Bench, number};

/// Memory \[kB\] and number of descriptors of a process.
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
#[ignore = "long; .ci/long runs it"]
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
    // First every place in the pools of messages is used once.
    request(10.max(served / 5));
    let processes = of_runs_below(&bench.path(""));
    assert_eq!(processes.len(), 6, "{processes:?}");
    let measure = || {
        std::thread::sleep(Duration::from_secs(1)); // the launcher cleans up after the processes that asked
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
    // An allocator may keep the memory that one scenario needed at its peak, so a growth must be seen in every round; a
    // leak is.
    let mut memory = before.iter().map(|held| held.0).collect::<Vec<_>>();
    let (mut shared, mut round) = (shared_before, 1);
    let (shared_after, files_after) = loop {
        request(served);
        let (mut after, mut shared_after, mut files_after) = measure();
        // A connection to the process that asked last may still be open, or not open yet. The launcher, if it is slow,
        // will still clean up such remains; leaked memory stays.
        let is_tidy = |after: &[(u64, usize)], files: usize| {
            files <= files_before + 4 && before.iter().zip(after).all(|(before, after)| after.1 <= before.1 + 4)
        };
        let tidying = Instant::now();
        while !is_tidy(&after, files_after) && tidying.elapsed() < WATCHDOG {
            (after, shared_after, files_after) = measure();
        }
        let mut grown = vec![];
        for (((process, before), after), memory) in processes.iter().zip(&before).zip(&after).zip(&mut memory) {
            println!("{}: {memory} kB, {before:?} -> {after:?} (kB, descriptors)", process.label);
            assert!(after.1 <= before.1 + 4, "descriptors of {}: {before:?} -> {after:?}", process.label);
            // A leak of one small snapshot per scenario would be 32 kB x scenarios.
            if after.0 >= *memory + 8 * served {
                grown.push(process.label.clone());
            }
            *memory = after.0;
        }
        // Pools of messages touch their pages one by one; a leak of the smallest snapshot would be 8 kB per scenario.
        if shared_after >= shared + 8192 * served {
            grown.push("shared memory".into());
        }
        shared = shared_after;
        if grown.is_empty() {
            break (shared_after, files_after);
        }
        assert!(round < 5, "the memory of {grown:?} has grown in each of {round} rounds of {served} scenarios");
        round += 1;
    };
    println!("shared memory: {shared_before} -> {shared_after} bytes, {files_before} -> {files_after} files");
    // However many scenarios have come, a few connections may not have been used before.
    assert!(files_after <= files_before + 4, "{files_before} -> {files_after}");
    assert_eq!(end(service), Some(0));
}

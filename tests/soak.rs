//! One run after another: none fails, and nothing stays behind.
//!
//! `PHASECLOUD_RUNS` is the number of runs one after another (default 10), `PHASECLOUD_PAIRS` the number of pairs at
//! once (default 5).
#![allow(missing_docs)]

mod common;

use common::{Bench, REPRODUCIBLE, number};

const CASES: &str = "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 1_000\n\
     [[propagator]]\nlabel = \"gmm-ut\"\nnode = \"gmm-ut\"\nmode = \"as-printed\"\n";

fn run_and_check(bench: &Bench, launch: &std::path::Path, out: &str) {
    bench.run_well(launch, out);
    for file in REPRODUCIBLE {
        let (ours, firsts) = (bench.read(&format!("{out}/{file}")), bench.read(&format!("first/{file}")));
        let shown =
            if file.ends_with("csv") { common::text(&ours) + "\n" + &common::text(&firsts) } else { String::new() };
        assert!(ours == firsts, "{out}: {file}\n{shown}");
    }
    let manifest: serde_json::Value = serde_json::from_slice(&bench.read(&format!("{out}/manifest.json"))).unwrap();
    assert_eq!(common::shared_memory_of(manifest["run_id"].as_str().unwrap()), [""; 0]);
    std::fs::remove_dir_all(bench.path(out)).unwrap();
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn run_after_run_and_run_beside_run_nothing_fails_and_nothing_stays_behind() {
    let bench = Bench::new();
    let launch = bench.launch_file("soak", CASES);
    bench.run_well(&launch, "first");
    let runs = number("PHASECLOUD_RUNS", 10);
    for run in 0..runs {
        run_and_check(&bench, &launch, &format!("run-{run}"));
    }
    let pairs = number("PHASECLOUD_PAIRS", 5);
    for pair in 0..pairs {
        std::thread::scope(|scope| {
            scope.spawn(|| run_and_check(&bench, &launch, &format!("left-{pair}")));
            scope.spawn(|| run_and_check(&bench, &launch, &format!("right-{pair}")));
        });
    }
    assert_eq!(bench.domains(), [""; 0]);
    println!("{runs} runs one after another and {pairs} pairs: no failure, nothing left");
}

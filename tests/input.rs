//! Bad input: told before anything starts, with exit code 2.
#![allow(missing_docs)]

mod common;

use common::{Bench, FOUR_CASES, text};

fn refused(bench: &Bench, launch: &std::path::Path, out: &str) -> String {
    let output = bench.run(launch, out);
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert_eq!(bench.domains(), [""; 0], "nothing has been started");
    errors
}

#[test]
fn files_that_cannot_be_right_are_refused_with_file_line_and_key() {
    let bench = Bench::new();
    let missing = refused(&bench, &bench.path("missing.toml"), "out");
    assert!(missing.contains("missing.toml: cannot be read"), "{missing}");

    let unknown = bench.launch_file("unknown", &FOUR_CASES.replace("seed", "sead"));
    let unknown = refused(&bench, &unknown, "out");
    assert!(
        unknown.contains("unknown.toml:9: propagator.sead: unknown field `sead`, expected one of `samples`, `seed`"),
        "{unknown}"
    );

    let good = bench.launch_file("good", FOUR_CASES);
    bench.write("scenario-1.toml", &common::SCENARIO_1.replace("delta_e = 0.05", "delta_e = -1"));
    let negative = refused(&bench, &good, "out");
    assert!(negative.contains("scenario-1.toml") && negative.contains("initial.delta_e"), "{negative}");
    assert!(!bench.path("out").exists());
}

#[test]
fn a_run_that_shared_memory_cannot_hold_is_refused() {
    let bench = Bench::new();
    let launch = bench.launch_file("huge", &FOUR_CASES.replace("4_000", "4_000_000_000_000"));
    let errors = refused(&bench, &launch, "out");
    assert!(errors.contains("MiB of shared memory"), "{errors}");
}

#[test]
fn a_results_folder_that_is_in_use_or_cannot_exist_is_refused() {
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES);
    assert!(refused(&bench, &launch, ".").contains("is not empty"));
    bench.write("file", "");
    assert!(refused(&bench, &launch, "file/out").contains("cannot write results to"));
}

#[test]
fn validate_says_what_is_good_and_what_is_not() {
    let bench = Bench::new();
    let good = bench.launch_file("good", FOUR_CASES);
    let bad = bench.launch_file("bad", &FOUR_CASES.replace("node = \"mc\"", "node = \"md\""));
    let output = bench.phasecloud().arg("validate").arg(&good).arg(&bad).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stdout).contains("good.toml: good, 4 cases on 1 scenarios"));
    assert!(text(&output.stderr).contains("\"md\" is unknown; it must be one of mc, dee"));
}

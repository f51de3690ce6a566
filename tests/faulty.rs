//! A faulty propagator from outside is named, and changes nobody's results.
#![allow(missing_docs)]

mod common;

use common::{Bench, FOUR_CASES, text};

/// Far longer than the pauses of the other processes on a loaded machine; the run waits that long for a silent process,
/// for some of them twice.
const PATIENCE: &str = "patience = 30.0\nrestart = \"on-failure\"\n";

/// The lines of a table that belong to the other cases; those of the faulty case, if there are any, come last in each
/// scenario.
fn of_the_others(bench: &Bench, file: &str) -> Vec<String> {
    let table = text(&bench.read(file));
    table.lines().filter(|line| !line.contains(",faulty,")).map(str::to_owned).collect()
}

/// Runs the four cases beside one with this fault, and checks that the results of the four are the same as without it.
fn run_beside(bench: &Bench, fault: &str) -> (Option<i32>, String) {
    let program = common::examples::example("faulty-propagator");
    let command = format!("command = [\"{}\", \"{fault}\"]", program.display());
    let cases = format!("{PATIENCE}{FOUR_CASES}[[propagator]]\nlabel = \"faulty\"\n{command}\n");
    let output = bench.run(&bench.launch_file(fault, &cases), fault);
    let errors = text(&output.stderr);
    for file in ["moments.csv", "errors.csv", "distances.csv", "first_passage.csv"] {
        let same = of_the_others(bench, &format!("{fault}/{file}")) == of_the_others(bench, &format!("alone/{file}"));
        assert!(same, "{fault}: {file}; {errors}");
    }
    let moments = text(&bench.read(&format!("{fault}/moments.csv")));
    assert_eq!(moments.contains(",faulty,"), output.status.success(), "{fault}: half a case is none; {errors}");
    (output.status.code(), errors)
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn a_faulty_propagator_is_named_and_the_others_stay_the_same_bytes() {
    let bench = Bench::new();
    bench.run_well(&bench.launch_file("alone", FOUR_CASES), "alone");
    let faults = [
        ("nan", "snapshot 1: row 7 of column 0 is NaN"),
        ("order", "it comes out of order"),
        ("times", "snapshot 1: its time is"),
        ("shape", "it has 400 rows of 3 columns"),
        ("eccentricity", "row 7 has e = 1"),
        ("crashes", "also after 3 restarts"),
    ];
    for (fault, words) in faults {
        let (code, errors) = run_beside(&bench, fault);
        assert_eq!(code, Some(1), "{fault}: {errors}");
        assert!(errors.contains("faulty: ") && errors.contains(words), "{fault}: {errors}");
    }
    assert_eq!(run_beside(&bench, "late").0, Some(0));
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn a_propagator_that_does_not_say_all_it_must_is_named_when_patience_ends() {
    let bench = Bench::new();
    bench.run_well(&bench.launch_file("alone", FOUR_CASES), "alone");
    let faults = [
        ("silent", "no sign of life for 30 s"),
        ("counts", "the estimator has waited 30 s for its snapshots"),
        ("no-passage", "the recorder has waited 30 s for its message on phasecloud/passage"),
    ];
    std::thread::scope(|scope| {
        for (fault, words) in faults {
            let bench = &bench;
            scope.spawn(move || {
                let (code, errors) = run_beside(bench, fault);
                assert_eq!(code, Some(1), "{fault}: {errors}");
                assert!(errors.contains("faulty: ") && errors.contains(words), "{fault}: {errors}");
            });
        }
    });
    assert_eq!(bench.domains(), [""; 0]);
}

//! Recordings: kept whole, replayed to the same bytes, refused when damaged.
#![allow(missing_docs)]

mod common;

use std::process::{Command, Output};

use common::{Bench, FOUR_CASES, text};

/// The files of a results folder in which nothing is measured anew; `effort.csv` holds measured CPU time of the
/// estimator.
const REPRODUCIBLE: [&str; 9] = [
    "moments.csv",
    "errors.csv",
    "distances.csv",
    "first_passage.csv",
    "given_re_entry.csv",
    "diagnostics.csv",
    "notes.csv",
    "verdicts.csv",
    "densities.npz",
];

/// A recorded run on two scenarios: `a` and `run.tape`.
fn recorded() -> Bench {
    let bench = Bench::new();
    bench.write("scenario-2.toml", include_str!("../launch/scenarios/scenario-2.toml"));
    let head = "name = \"four\"\nscenarios = [\"scenario-1.toml\", \"scenario-2.toml\"]\nreference = \"mc\"\n";
    bench.write("four.toml", &format!("{head}{FOUR_CASES}"));
    let output = run(&bench, &["run", "four.toml", "--record", "run.tape", "--out", "a"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    bench
}

fn run(bench: &Bench, arguments: &[&str]) -> Output {
    bench.phasecloud().args(arguments).output().unwrap()
}

fn replay_well(bench: &Bench, arguments: &[&str]) {
    let output = run(bench, &[&["replay", "run.tape"], arguments].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
}

fn assert_same(bench: &Bench, folder: &str, files: &[&str]) {
    for file in files {
        assert!(bench.read(&format!("a/{file}")) == bench.read(&format!("{folder}/{file}")), "{folder}/{file}");
    }
}

/// The rows of a table that belong to other methods.
fn without(bench: &Bench, table: &str, method: &str) -> Vec<std::collections::HashMap<String, String>> {
    bench.table(table).into_iter().filter(|row| row["method"] != method).collect()
}

#[test]
fn a_replay_gives_the_same_bytes_whichever_part_is_played() {
    let bench = recorded();
    replay_well(&bench, &["--out", "cases"]);
    assert_same(&bench, "cases", &REPRODUCIBLE);
    let columns = ["scenario", "method", "t_prop_s"];
    let effort = |folder: &str| -> Vec<Vec<String>> {
        let rows = bench.table(&format!("{folder}/effort.csv"));
        rows.iter().map(|row| columns.iter().map(|column| row[*column].clone()).collect()).collect()
    };
    assert_eq!(effort("a"), effort("cases"), "the CPU time of propagation is as recorded");

    replay_well(&bench, &["--live", "dee-961", "--live", "mc", "--out", "two-live"]);
    assert_same(&bench, "two-live", &REPRODUCIBLE);
    replay_well(&bench, &["--recorded", "estimator", "--recorded", "comparator", "--out", "all"]);
    assert_same(&bench, "all", &REPRODUCIBLE);
    assert_same(&bench, "all", &["effort.csv"]);

    let [recorded, replayed] = ["a", "cases"].map(|folder| -> serde_json::Value {
        serde_json::from_slice(&bench.read(&format!("{folder}/manifest.json"))).unwrap()
    });
    assert_eq!(recorded["configuration"], replayed["configuration"]);
    assert_ne!(recorded["run_id"], replayed["run_id"]);
    assert_eq!(replayed["cases"]["mc"]["runs"][0], "recorded");
    assert_eq!(bench.domains(), [""; 0]);
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn one_case_is_replaced_or_left_out_and_the_others_stay_as_recorded() {
    let bench = recorded();
    let mine = common::examples::example("stt-gaussian");
    replay_well(&bench, &["--replace", &format!("gmm-ut={}", mine.display()), "--out", "mine"]);
    for table in ["moments.csv", "errors.csv", "distances.csv"] {
        let [before, after] = ["a", "mine"].map(|folder| without(&bench, &format!("{folder}/{table}"), "gmm-ut"));
        assert_eq!(before, after, "{table}");
    }
    let of_gmm = |folder: &str| -> Vec<_> {
        let rows = bench.table(&format!("{folder}/moments.csv"));
        rows.into_iter().filter(|row| row["method"] == "gmm-ut").collect()
    };
    assert_eq!(of_gmm("a").len(), of_gmm("mine").len());
    assert_ne!(of_gmm("a"), of_gmm("mine"));

    replay_well(&bench, &["--without", "gmm-ut", "--out", "three"]);
    assert_eq!(without(&bench, "a/moments.csv", "gmm-ut"), bench.table("three/moments.csv"));
    // Our own estimator, run as a foreign command.
    let estimator = format!("estimator={} node estimator", env!("CARGO_BIN_EXE_phasecloud"));
    replay_well(&bench, &["--replace", &estimator, "--out", "estimator"]);
    assert_same(&bench, "estimator", &REPRODUCIBLE);
}

#[test]
fn damaged_recordings_are_refused_by_name_with_the_place() {
    let bench = recorded();
    let whole = bench.read("run.tape");
    let middle = whole.len() / 2;
    let mut flipped = whole.clone();
    flipped[middle] ^= 1;
    for (name, bytes, words) in [
        ("short.tape", &whole[..middle], "truncated"),
        ("flipped.tape", &flipped, "damaged"),
        ("other.tape", b"something else entirely".as_slice(), "not a recording of phasecloud"),
    ] {
        std::fs::write(bench.path(name), bytes).unwrap();
        let output = run(&bench, &["replay", name]);
        let errors = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{errors}");
        assert!(errors.contains(&format!("{name}: byte ")) && errors.contains(words), "{errors}");
    }
    assert_eq!(bench.domains(), [""; 0], "nothing has been started");
}

#[test]
fn what_cannot_be_recorded_or_replayed_is_told_before_anything_starts() {
    let bench = recorded();
    for (arguments, words) in [
        (&["run", "four.toml", "--record", "run.tape"][..], "run.tape exists already"),
        (&["run", "four.toml", "--record", "no/such/folder/x.tape"], "cannot record to"),
        (&["replay", "run.tape", "--live", "mine"], "has no \"mine\"; there are mc, dee-961, dee-1e5, gmm-ut"),
        (&["replay", "run.tape", "--without", "mc"], "all cases are compared with it"),
        (&["replay", "run.tape", "--replace", "mc"], "must be NAME=COMMAND"),
        (&["replay", "run.tape", "--recorded", "estimator", "--live", "mc"], "cannot be used with"),
    ] {
        let output = run(&bench, arguments);
        let errors = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{errors}");
        assert!(errors.contains(words), "{errors}");
    }
    assert_eq!(bench.domains(), [""; 0]);
}

#[test]
fn a_run_that_fails_leaves_no_recording() {
    let bench = Bench::new();
    let scenario = common::SCENARIO_1.replace("radiation = 0.15", "radiation = 3.0").replace("0.40921", "0.0");
    bench.write("scenario-1.toml", &scenario);
    let launch = bench.launch_file("four", FOUR_CASES);
    let mut command: Command = bench.phasecloud();
    let output = command.arg("run").arg(launch).args(["--record", "run.tape", "--out", "out"]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let names = std::fs::read_dir(bench.path(".")).unwrap().flatten();
    let tapes: Vec<_> = names.map(|e| e.file_name()).filter(|n| n.to_string_lossy().contains("tape")).collect();
    assert!(tapes.is_empty(), "{tapes:?}");
}

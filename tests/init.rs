//! `phasecloud init`, built-in launch files, completions, manual pages and the version.
#![allow(missing_docs)]

mod common;

use common::{Bench, text};

#[test]
fn what_init_writes_runs_and_answers_as_it_stands() {
    let bench = Bench::new();
    let run = |words: &[&str]| {
        let output = bench.phasecloud().args(words).output().unwrap();
        assert!(output.status.success(), "{words:?}: {}", text(&output.stderr));
        text(&output.stdout)
    };
    let said = run(&["init", "my-satellite"]);
    assert!(said.contains("phasecloud run my-satellite/launch.toml"), "{said}");
    run(&["validate", "my-satellite/scenario.toml", "my-satellite/launch.toml"]);
    let printed = run(&["run", "my-satellite/launch.toml", "--no-report", "--out", "out"]);
    let cases = ["exact", "mc", "dee", "gmm-ut"];
    assert!(cases.iter().all(|case| printed.contains(case)), "{printed}");
    let rows = bench.table("out/first_passage.csv");
    let last = |method: &str| {
        let row = rows.iter().rfind(|row| row["method"] == method).unwrap();
        row["prob_reached_critical_e"].parse::<f64>().unwrap()
    };
    assert!(
        (0.02..0.98).contains(&last("exact")),
        "re-entry that is neither certain nor impossible: {}",
        last("exact")
    );
    assert!((last("mc") - last("exact")).abs() < 0.01);
    let again = bench.phasecloud().args(["init", "my-satellite"]).output().unwrap();
    assert_eq!(again.status.code(), Some(2));
    assert!(text(&again.stderr).contains("my-satellite is there already"));
    let named = bench.phasecloud().args(["init", "a b"]).output().unwrap();
    assert!(
        text(&named.stderr).contains("the last part of the path is the scenario's name"),
        "{}",
        text(&named.stderr)
    );
}

#[test]
fn a_built_in_launch_file_is_found_from_any_folder_by_its_name() {
    let bench = Bench::new();
    let graph = |words: &[&str]| bench.phasecloud().arg("graph").args(words).output().unwrap();
    let paper = graph(&["paper"]);
    assert!(text(&paper.stdout).contains("scenario-1, scenario-2, scenario-3"), "{}", text(&paper.stderr));
    let unknown = graph(&["papre"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(
        text(&unknown.stderr).contains("the launch files that are built in are scenario-1"),
        "{}",
        text(&unknown.stderr)
    );
    let run = bench.phasecloud().args(["run", "sweep", "--no-report", "--out", "out"]).output().unwrap();
    assert!(run.status.success(), "{}", text(&run.stderr));
    assert_eq!(bench.table("out/moments.csv").len(), 5);
}

#[test]
fn completions_and_manual_pages_know_every_command() {
    let bench = Bench::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let output = bench.phasecloud().args(["completions", shell]).output().unwrap();
        let script = text(&output.stdout);
        assert!(output.status.success() && script.contains("validate") && script.contains("most-snapshots"), "{shell}");
    }
    let page = text(&bench.phasecloud().arg("man").output().unwrap().stdout);
    assert!(page.contains(".TH phasecloud 1") && page.contains("phasecloud\\-run(1)"), "{page}");
    let written = bench.phasecloud().args(["man", "man1"]).output().unwrap();
    assert!(written.status.success(), "{}", text(&written.stderr));
    assert!(text(&bench.read("man1/phasecloud-run.1")).contains("results folder"));
    bench.write("file", "");
    let refused = bench.phasecloud().args(["man", "file/man1"]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn the_version_says_revision_and_features() {
    let said = text(&Bench::new().phasecloud().arg("--version").output().unwrap().stdout);
    let version = env!("CARGO_PKG_VERSION");
    assert!(said.starts_with(&format!("phasecloud {version} (revision ")), "{said}");
    assert!(
        said.trim_end().ends_with(if cfg!(feature = "hosts") { "features: hosts)" } else { "features: none)" }),
        "{said}"
    );
}

//! Patience: a silent process is named, and no other; nobody is named for time in which everything stood still.
#![allow(missing_docs)]

mod common;

use std::process::Stdio;
use std::time::Duration;

use common::processes::{Said, end_of, of_runs_below, signal, signal_child, wait_for};
use common::{Bench, FOUR_CASES, text};
use rustix::process::Signal;

/// Far longer than the pauses of healthy processes on a loaded machine \[s\].
const PATIENCE: u64 = 10;

fn head(restart: &str) -> String {
    format!("patience = {PATIENCE}\nrestart = \"{restart}\"\n")
}

const SMALL: &str = "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 2_000\n";

#[test]
#[ignore = "long; .ci/long runs it"]
fn one_silent_case_is_named_and_the_others_are_compared_with_and_without_restarts() {
    let silent = "[[propagator]]\nlabel = \"silent\"\ncommand = [\"sleep\", \"1000\"]\n";
    std::thread::scope(|scope| {
        for restart in ["never", "on-failure"] {
            scope.spawn(move || {
                let bench = Bench::new();
                let cases = format!("{}{FOUR_CASES}{silent}", head(restart));
                let output = bench.run(&bench.launch_file("silent", &cases), "out");
                let errors = text(&output.stderr);
                assert_eq!(output.status.code(), Some(1), "{restart}: {errors}");
                let failures = bench.manifest("out")["failures"].as_object().unwrap().clone();
                assert_eq!(failures.keys().collect::<Vec<_>>(), ["silent"], "{restart}: {errors}");
                assert_eq!(failures["silent"], format!("no sign of life for {PATIENCE} s"));
                assert_eq!(bench.table("out/moments.csv").len(), 20, "{restart}: {errors}");
            });
        }
    });
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn a_run_that_was_stopped_for_longer_than_patience_accuses_nobody_when_it_goes_on() {
    let bench = Bench::new();
    let launch = bench.launch_file("stopped", &format!("{}{FOUR_CASES}", head("never")));
    let mut command = bench.phasecloud();
    command.arg("run").arg(launch).arg("--out").arg(bench.path("out")).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut launcher = command.spawn().unwrap();
    let said = Said::by(launcher.stderr.take().unwrap());
    let nodes = wait_for("the run does not start", || {
        let nodes = of_runs_below(&bench.path(""));
        (nodes.len() == 8).then_some(nodes)
    });
    signal_child(&launcher, Signal::STOP);
    nodes.iter().for_each(|node| signal(node, Signal::STOP));
    std::thread::sleep(Duration::from_secs(PATIENCE + 3));
    signal_child(&launcher, Signal::CONT);
    nodes.iter().for_each(|node| signal(node, Signal::CONT));
    let code = end_of(&mut launcher).code();
    assert_eq!(code, Some(0), "{}", said.rest());
    assert_eq!(bench.table("out/moments.csv").len(), 20);
}

#[test]
fn a_passage_refused_in_the_second_scenario_is_charged_to_that_one_at_once() {
    let bench = Bench::new();
    // The patience is so long that the test's own watchdog would end a run that waits for it.
    let cases = SMALL.to_owned() + &bench.faulty("faulty", "unreadable-passage");
    let launch = bench.two_scenarios("passage", "patience = 100_000.0\nrestart = \"never\"\n", &cases);
    let mut command = bench.phasecloud();
    command.arg("run").arg(launch).arg("--out").arg(bench.path("out")).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut launcher = command.spawn().unwrap();
    let said = Said::by(launcher.stderr.take().unwrap());
    assert_eq!(end_of(&mut launcher).code(), Some(1));
    let failures = bench.manifest("out")["failures"].as_object().unwrap().clone();
    assert_eq!(failures.keys().collect::<Vec<_>>(), ["scenario-2, faulty"], "{}", said.rest());
    let why = failures["scenario-2, faulty"].as_str().unwrap();
    assert!(why.contains("a message on phasecloud/passage") && why.contains("is not a time"), "{why}");
    assert_eq!(bench.table("out/moments.csv").len(), 2 * 5 + 5);
}

#[test]
fn a_sweep_goes_on_after_a_refused_passage_and_the_case_serves_the_next_scenario() {
    let bench = Bench::new();
    let cases = SMALL.to_owned() + &bench.faulty("faulty", "unreadable-passage");
    let launch = bench.launch_file("sweep", &format!("patience = 100_000.0\nrestart = \"never\"\n{cases}"));
    let sweep =
        bench.write("vary.toml", "scenario = \"scenario-1.toml\"\n[vary]\n\"initial.e\" = [0.1, 0.12, 0.145]\n");
    let mut command = bench.phasecloud();
    command.arg("serve").arg(launch).arg("--sweep").arg(sweep).args(["--out", "out"]);
    let mut service = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let said = Said::by(service.stderr.take().unwrap());
    assert_eq!(end_of(&mut service).code(), Some(1));
    let failed = |position: u32| {
        let manifest = bench.manifest(&format!("out/{position:06}-scenario-1-{position}"));
        manifest["failures"].as_object().unwrap().keys().cloned().collect::<Vec<_>>()
    };
    let failed = [0, 1, 2].map(failed);
    assert_eq!(failed, [vec![], vec!["faulty".to_owned()], vec![]], "{}", said.rest());
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn a_case_that_reaches_its_budget_is_named_and_serves_the_next_scenario() {
    let bench = Bench::new();
    // The budget in the second scenario is 30 s for work that takes a second on an idle machine.
    let cases = SMALL.to_owned() + &bench.faulty("slow", "stuck-in-the-first") + "most_seconds = 30\n";
    let launch = bench.two_scenarios("budget", "restart = \"never\"\n", &cases);
    let output = bench.run(&launch, "out");
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    let manifest = bench.manifest("out");
    let failures = manifest["failures"].as_object().unwrap();
    assert_eq!(failures.len(), 1, "{errors}");
    assert_eq!(failures["scenario-1, slow"], "it has used its budget of 30 s (most_seconds)");
    assert_eq!(manifest["cases"]["slow"]["most_seconds"], 30.0);
    let notes = bench.table("out/notes.csv");
    let lost = notes.iter().find(|row| row["method"] == "slow").unwrap();
    assert_eq!(lost["note"], "lost: it has used its budget of 30 s (most_seconds)");
    assert_eq!(manifest["complete"], true);
    let rows = bench.table("out/moments.csv");
    let of = |scenario: &str, method: &str| {
        rows.iter().filter(|row| row["scenario"] == scenario && row["method"] == method).count()
    };
    assert_eq!([of("scenario-1", "mc"), of("scenario-1", "slow")], [5, 0], "{errors}");
    assert_eq!([of("scenario-2", "mc"), of("scenario-2", "slow")], [5, 5], "{errors}");
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn cases_owe_nothing_for_a_scenario_that_its_node_does_not_publish() {
    let bench = Bench::new();
    let launch = bench.two_scenarios("unpublished", &head("on-failure"), SMALL);
    let mut command = bench.phasecloud();
    command.arg("run").arg(launch).args(["--no-report", "--out"]).arg(bench.path("out"));
    let mut launcher = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let said = Said::by(launcher.stderr.take().unwrap());
    // The node is stopped from its start on, until the launcher has lost patience with it and starts it again.
    let node = wait_for("the scenario node does not start", || {
        of_runs_below(&bench.path("")).into_iter().find(|process| process.label == "scenario")
    });
    signal(&node, Signal::STOP);
    let code = end_of(&mut launcher).code();
    let said = said.rest();
    assert_eq!(code, Some(0), "{said}");
    assert!(!said.contains("mc: no sign of life"), "{said}");
    assert_eq!(bench.table("out/moments.csv").len(), 10, "{said}");
}

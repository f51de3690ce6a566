//! A request to stop keeps what is finished, and says that it is not whole; a second one discards everything.
#![allow(missing_docs)]

mod common;

use std::process::{Child, Stdio};

use common::processes::{Said, end_of, of_runs_below, signal, signal_child};
use common::{Bench, text};
use rustix::process::Signal;

const QUICK: &str = "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 2_000\n\
     [[propagator]]\nlabel = \"dee\"\nnode = \"dee\"\nsamples = 441\n";
const ENDLESS: &str = "[[propagator]]\nlabel = \"endless\"\ncommand = [\"sleep\", \"1000\"]\n";

fn start(bench: &Bench, launch: &std::path::Path, options: &[&str]) -> (Child, Said) {
    let mut command = bench.phasecloud();
    command.arg("run").arg(launch).arg("--out").arg(bench.path("out")).args(options);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let said = Said::by(child.stderr.take().unwrap());
    (child, said)
}

/// Waits until the quick cases have delivered everything.
fn wait_for_the_quick(said: &mut Said) {
    // In any order: this is the last line that each of them prints.
    while !["mc", "dee"].iter().all(|name| said.so_far.contains(&format!("{name}: done scenario-1 5/5"))) {
        said.wait_for(": done scenario-1 5/5");
    }
}

fn verify(bench: &Bench) -> (Option<i32>, String) {
    let output = bench.phasecloud().arg("verify").arg(bench.path("out")).output().unwrap();
    (output.status.code(), text(&output.stdout) + &text(&output.stderr))
}

#[test]
fn interrupted_in_the_first_of_two_scenarios_a_run_keeps_the_cases_that_are_finished() {
    for request in [Signal::INT, Signal::TERM] {
        let bench = Bench::new();
        let launch = bench.two_scenarios("cut", "", &format!("{QUICK}{ENDLESS}"));
        let (mut child, mut said) = start(&bench, &launch, &["--record", "run.tape"]);
        wait_for_the_quick(&mut said);
        signal_child(&child, request);
        assert_eq!(end_of(&mut child).code(), Some(130));
        let said = said.rest();
        assert!(said.contains("are not whole") && said.contains("the recording was discarded"), "{said}");
        assert_eq!(bench.table("out/moments.csv").len(), 2 * 5, "{said}");
        assert_eq!(bench.table("out/errors.csv").len(), 2 * 5 * 8);
        let manifest = bench.manifest("out");
        assert_eq!(manifest["complete"], false);
        let why = manifest["incomplete_because"].as_str().unwrap();
        assert!(why.contains("endless of scenario-1") && why.contains("all of scenario-2"), "{why}");
        assert_eq!(manifest["failures"]["scenario-1, endless"], "it had not finished when the run was stopped");
        assert_eq!(manifest["scenarios"].as_object().unwrap().keys().collect::<Vec<_>>(), ["scenario-1"]);
        assert!(text(&bench.read("out/report.html")).contains("These results are not whole"));
        assert_eq!(verify(&bench).0, Some(0), "{}", verify(&bench).1);
        assert!(!bench.path("run.tape").exists());
        assert_eq!(bench.domains(), [""; 0]);
    }
}

#[test]
fn interrupted_in_the_second_scenario_a_run_keeps_the_first_as_it_would_have_been() {
    let bench = Bench::new();
    let launch = bench.two_scenarios("cut", "", &bench.faulty("mc", "stuck-in-the-second"));
    let (mut child, mut said) = start(&bench, &launch, &[]);
    said.wait_for("scenario-1 is recorded");
    signal_child(&child, Signal::INT);
    assert_eq!(end_of(&mut child).code(), Some(130));
    let said = said.rest();
    let manifest = bench.manifest("out");
    assert_eq!(manifest["complete"], false, "{said}");
    assert_eq!(manifest["failures"].as_object().unwrap().len(), 0, "{said}");
    assert_eq!(bench.table("out/moments.csv").len(), 5);
    assert_eq!(verify(&bench).0, Some(0), "{}", verify(&bench).1);
}

#[test]
fn a_second_request_discards_everything_at_once() {
    let bench = Bench::new();
    let launch = bench.launch_file("twice", &format!("{QUICK}{ENDLESS}"));
    let (mut child, mut said) = start(&bench, &launch, &[]);
    wait_for_the_quick(&mut said);
    // A stopped recorder can record nothing any more.
    let recorder = of_runs_below(&bench.path("")).into_iter().find(|process| process.label == "recorder").unwrap();
    signal(&recorder, Signal::STOP);
    signal_child(&child, Signal::INT);
    said.wait_for("another Ctrl-C discards everything");
    signal_child(&child, Signal::INT);
    assert_eq!(end_of(&mut child).code(), Some(130));
    assert!(said.rest().contains("nothing was written"));
    assert!(!bench.path("out").exists());
    assert_eq!(bench.domains(), [""; 0]);
}

//! kill -9 of any process at any time: the run ends, either complete with the same bytes, or with the case named and
//! left out.
//!
//! `PHASECLOUD_KILLS` is the number of kills (default 60), `PHASECLOUD_SEED` the first seed.
#![allow(missing_docs)]

mod common;

use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use common::processes::{Process, of_runs_below, signal};
use common::{Bench, REPRODUCIBLE, number, text};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rustix::process::Signal;

const SERVICES: [&str; 4] = ["scenario", "estimator", "comparator", "recorder"];

/// Far longer than a loaded machine needs; only ends a test that would hang.
const WATCHDOG: Duration = Duration::from_secs(120);

/// Two scenarios, so that there is a time between them; short ones, since nothing here depends on how orbits move.
fn launch_file(bench: &Bench, restart: &str) -> std::path::PathBuf {
    let short = common::SCENARIO_1.replace("end = 2.0", "end = 0.5").replace("step = 0.5", "step = 0.25");
    bench.write("scenario-1.toml", &short);
    bench.write("scenario-2.toml", &short.replace("scenario-1", "scenario-2").replace("0.145", "0.2"));
    let text = format!(
        "name = \"kills\"\nscenarios = [\"scenario-1.toml\", \"scenario-2.toml\"]\nreference = \"mc\"\n\
         restart = \"{restart}\"\nbins = [40, 40]\n\
         [[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 3_000\n\
         [[propagator]]\nlabel = \"dee\"\nnode = \"dee\"\nsamples = 441\n\
         [[propagator]]\nlabel = \"gmm-ut\"\nnode = \"gmm-ut\"\nmode = \"as-printed\"\n"
    );
    bench.write(&format!("{restart}.toml"), &text)
}

fn start(bench: &Bench, launch: &std::path::Path, out: &str) -> Child {
    start_with(bench, launch, out, &[])
}

fn start_with(bench: &Bench, launch: &std::path::Path, out: &str, options: &[&str]) -> Child {
    let mut command = bench.phasecloud();
    command.arg("run").arg(launch).args(["--quiet", "--no-report", "--out"]).arg(bench.path(out));
    command.args(options).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits for the end and returns the exit code and standard error.
fn end(mut child: Child, what: &str) -> (Option<i32>, String) {
    let started = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if started.elapsed() > WATCHDOG {
            child.kill().unwrap();
            panic!("{what}: the run hangs");
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    let output = child.wait_with_output().unwrap();
    (output.status.code(), text(&output.stderr))
}

/// Kills one random process after a random time; returns its name, if it was still there.
fn kill_one(bench: &Bench, random: &mut ChaCha8Rng, longest: Duration) -> Option<String> {
    std::thread::sleep(longest.mul_f64(random.random()));
    let processes = of_runs_below(&bench.path(""));
    let victim = processes.get(random.random_range(0..processes.len().max(1)))?;
    signal(victim, Signal::KILL);
    Some(victim.label.clone())
}

fn rows_of(bench: &Bench, file: &str, method: &str) -> Vec<std::collections::HashMap<String, String>> {
    bench.table(file).into_iter().filter(|row| row["method"] == method).collect()
}

fn kill_randomly(restart: &str, kills: u64, first_seed: u64) {
    let bench = Bench::new();
    let launch = launch_file(&bench, restart);
    let begun = Instant::now();
    assert_eq!(end(start(&bench, &launch, "whole"), "undisturbed").0, Some(0));
    let longest = begun.elapsed();
    let (mut complete, mut partial, mut refused) = (0, 0, 0);
    for seed in first_seed..first_seed + kills {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let out = format!("out-{seed}");
        let child = start(&bench, &launch, &out);
        let victim = kill_one(&bench, &mut random, longest);
        let what = format!("seed {seed}, killed {victim:?}");
        let (code, said) = end(child, &what);
        match code {
            Some(0) => {
                for file in REPRODUCIBLE {
                    let same = bench.read(&format!("{out}/{file}")) == bench.read(&format!("whole/{file}"));
                    assert!(same, "{what}: {file} differs; {said}");
                }
                complete += 1;
            }
            Some(1) => {
                let victim = victim.expect("a run in which nothing was killed succeeds");
                assert!(said.contains(&victim), "{what}: not named in {said}");
                assert_eq!(restart, "never", "{what}: {said}");
                if SERVICES.contains(&victim.as_str()) {
                    assert!(!bench.path(&out).exists(), "{what}: no results are better than half of them");
                    refused += 1;
                } else {
                    for method in ["mc", "dee", "gmm-ut"].into_iter().filter(|method| *method != victim) {
                        let file = |folder: &str| format!("{folder}/moments.csv");
                        let same = rows_of(&bench, &file(&out), method) == rows_of(&bench, &file("whole"), method);
                        assert!(same, "{what}: {method} differs");
                    }
                    partial += 1;
                }
            }
            other => panic!("{what}: exit code {other:?}; {said}"),
        }
        assert_eq!(bench.domains(), [""; 0], "{what}");
        let _ = std::fs::remove_dir_all(bench.path(&out));
    }
    println!(
        "restart = {restart}: {kills} kills, seeds from {first_seed}: {complete} complete, {partial} without the killed case, \
         {refused} refused"
    );
}

/// A line of a run's log: the node, the message, and the scenario.
type Line = (String, String, Option<u64>);

/// The log of the run under way, which keeps it in its unfinished results folder.
fn log_so_far(bench: &Bench) -> Vec<Line> {
    let entries = std::fs::read_dir(bench.path("")).unwrap().flatten();
    let unfinished = entries.map(|entry| entry.path()).find(|path| path.to_string_lossy().ends_with(".partial"));
    let log = unfinished.and_then(|folder| std::fs::read_to_string(folder.join("log.jsonl")).ok()).unwrap_or_default();
    // The last line may be half written.
    let lines = log.lines().filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok());
    let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    lines.map(|line| (text(&line["node"]), text(&line["message"]), line["scenario"].as_u64())).collect()
}

/// Whether `victim`, whose process is there, has reached this phase of its life.
fn has_come_to(phase: &str, victim: &str, log: &[Line]) -> bool {
    let said = |node: &str, words: &str, scenario: Option<u64>| {
        log.iter().filter(|line| line.0 == node && line.1.contains(words) && line.2 == scenario).count()
    };
    // Estimator and scenario node do not report the end of a scenario.
    let worker = if ["estimator", "scenario"].contains(&victim) { "comparator" } else { victim };
    match phase {
        "start-up" => true,
        "ready" => said(victim, "ready", None) > 0,
        "computing" if victim == "scenario" => said(victim, "has published", Some(0)) > 0,
        "publishing" if victim == "scenario" => said(victim, "has published", Some(1)) > 0,
        "computing" => said(victim, " done", Some(0)) > 0,
        "publishing" => said(victim, " done", Some(0)) > 1,
        "idle" => log.iter().any(|line| line.0 == worker && line.1 == "done"),
        _ => log.iter().any(|line| line.0 == "recorder" && line.1 == "done" && line.2 == Some(1)),
    }
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn a_process_killed_in_any_phase_of_its_life_changes_no_byte() {
    let bench = Bench::new();
    let launch = launch_file(&bench, "on-failure");
    assert_eq!(end(start(&bench, &launch, "whole"), "undisturbed").0, Some(0));
    for phase in ["start-up", "ready", "computing", "publishing", "idle", "shutdown"] {
        let mut killed = Vec::new();
        for victim in SERVICES.into_iter().chain(["mc", "dee", "gmm-ut"]) {
            let mut run = start_with(&bench, &launch, "out", &["--log", "debug"]);
            let what = format!("{victim} killed at {phase}");
            while run.try_wait().unwrap().is_none() {
                let process = of_runs_below(&bench.path("")).into_iter().find(|process| process.label == victim);
                if let Some(process) = process.filter(|_| has_come_to(phase, victim, &log_so_far(&bench))) {
                    signal(&process, Signal::KILL);
                    killed.push(victim);
                    break;
                }
            }
            let (code, said) = end(run, &what);
            assert_eq!(code, Some(0), "{what}: {said}");
            for file in REPRODUCIBLE {
                let same = bench.read(&format!("out/{file}")) == bench.read(&format!("whole/{file}"));
                assert!(same, "{what}: {file} differs; {said}");
            }
            assert_eq!(bench.domains(), [""; 0], "{what}");
            std::fs::remove_dir_all(bench.path("out")).unwrap();
        }
        println!("killed at {phase}: {killed:?}");
        assert!(killed.len() > 2, "{phase}: too few came to be killed: {killed:?}");
    }
}

/// Waits until `victim` is there and the log fulfils the condition.
fn await_process(bench: &Bench, run: &mut Child, victim: &str, mut condition: impl FnMut(&[Line]) -> bool) -> Process {
    loop {
        assert!(run.try_wait().unwrap().is_none(), "the run is over before its {victim} is as expected");
        let process = of_runs_below(&bench.path("")).into_iter().find(|process| process.label == victim);
        if let Some(process) = process.filter(|_| condition(&log_so_far(bench))) {
            return process;
        }
    }
}

#[test]
fn first_passages_that_died_with_their_sender_before_the_recorder_came_are_waited_for() {
    let bench = Bench::new();
    let launch = launch_file(&bench, "on-failure");
    assert_eq!(end(start(&bench, &launch, "whole"), "undisturbed").0, Some(0));
    let mut run = start(&bench, &launch, "out");
    let recorder = await_process(&bench, &mut run, "recorder", |_| true);
    signal(&recorder, Signal::STOP);
    let compared = |log: &[Line]| log.iter().any(|line| line.0 == "comparator" && line.1 == "done");
    let dee = await_process(&bench, &mut run, "dee", compared);
    signal(&dee, Signal::KILL);
    // The remains of the dead process have been removed by then.
    await_process(&bench, &mut run, "recorder", |log| {
        log.iter().any(|line| line.1.starts_with("dee has ended, signal"))
    });
    signal(&recorder, Signal::CONT);
    let (code, said) = end(run, "dee killed");
    assert_eq!(code, Some(0), "{said}");
    for file in REPRODUCIBLE {
        assert!(bench.read(&format!("out/{file}")) == bench.read(&format!("whole/{file}")), "{file} differs; {said}");
    }
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn with_restarts_a_killed_process_changes_no_byte() {
    kill_randomly("on-failure", number("PHASECLOUD_KILLS", 60) / 2, number("PHASECLOUD_SEED", 1));
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn without_restarts_a_killed_process_is_named_and_the_others_are_compared() {
    kill_randomly("never", number("PHASECLOUD_KILLS", 60).div_ceil(2), number("PHASECLOUD_SEED", 1) + 1_000_000);
}

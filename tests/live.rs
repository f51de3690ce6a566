//! A run as it is shown: on a terminal, without one, quiet, as JSON, and by `phasecloud watch`.
#![allow(missing_docs)]

mod common;

use std::io::Read;
use std::os::fd::OwnedFd;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use common::{Bench, FOUR_CASES, text};
use rustix::fs::{Mode, OFlags, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};
use serde_json::Value;

/// Far longer than a healthy machine needs; only ends a test that would hang.
const WATCHDOG: Duration = Duration::from_secs(120);

/// The nodes of a run of the four cases.
const NODES: [&str; 8] = ["scenario", "mc", "dee-961", "dee-1e5", "gmm-ut", "estimator", "comparator", "recorder"];

/// Starts a command with standard output and error on a terminal of its own; the other end is what the user would see.
fn on_terminal(command: &mut Command) -> (Child, std::fs::File) {
    on_terminal_of_kind(command, "xterm")
}

fn on_terminal_of_kind(command: &mut Command, kind: &str) -> (Child, std::fs::File) {
    let screen = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&screen).unwrap();
    unlockpt(&screen).unwrap();
    let size = Winsize { ws_row: 40, ws_col: 100, ws_xpixel: 0, ws_ypixel: 0 };
    let name = ptsname(&screen, Vec::new()).unwrap();
    let terminal = || -> OwnedFd { open(name.as_c_str(), OFlags::RDWR | OFlags::NOCTTY, Mode::empty()).unwrap() };
    let first = terminal();
    tcsetwinsize(&first, size).unwrap();
    let child = command.env("TERM", kind).stdout(first).stderr(terminal()).spawn().unwrap();
    (child, screen.into())
}

/// All that appears on a screen until no process has it open any more.
fn read_all(screen: &mut std::fs::File) -> String {
    let mut shown = Vec::new();
    let mut piece = [0; 4096];
    // Reading a terminal that no process has open gives an error instead of an end.
    while let Ok(length @ 1..) = screen.read(&mut piece) {
        shown.extend_from_slice(&piece[..length]);
    }
    text(&shown)
}

fn run(bench: &Bench, arguments: &[&str]) -> Output {
    bench.launch_file("four", FOUR_CASES);
    let output = bench.phasecloud().args(["run", "four.toml", "--out", "out"]).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    output
}

#[test]
fn a_terminal_shows_a_line_a_node_and_at_last_the_results() {
    let bench = Bench::new();
    bench.launch_file("four", FOUR_CASES);
    let mut command = bench.phasecloud();
    command.args(["run", "four.toml", "--out", "out"]);
    let (mut child, mut screen) = on_terminal(&mut command);
    drop(command); // the command holds the terminal open
    let shown = read_all(&mut screen);
    assert!(child.wait().unwrap().success(), "{shown}");
    for node in NODES {
        assert!(shown.contains(&format!("  {node:16} ")), "{node}: {shown}");
    }
    for words in ["starting", "working scenario-1", "done scenario-1 5/5", "/s, ", " left"] {
        assert!(shown.contains(words), "{words}: {shown}");
    }
    assert!(shown.contains('\u{1b}'), "lines are drawn anew in their places");
    let last_line = shown.rfind("recorder  ").unwrap();
    assert!(shown.rfind("Results: ").unwrap() > last_line, "the table comes last");
}

#[test]
fn a_dumb_terminal_shows_progress_in_plain_lines() {
    let bench = Bench::new();
    bench.launch_file("four", FOUR_CASES);
    let mut command = bench.phasecloud();
    command.args(["run", "four.toml", "--out", "out"]);
    let (mut child, mut screen) = on_terminal_of_kind(&mut command, "dumb");
    drop(command); // the command holds the terminal open
    let shown = read_all(&mut screen);
    assert!(child.wait().unwrap().success(), "{shown}");
    assert!(!shown.contains('\u{1b}'), "{shown}");
    for node in &NODES[1..] {
        assert!(shown.contains(&format!("{node}: done scenario-1 ")), "{node}: {shown}");
    }
}

#[test]
fn without_a_terminal_there_are_plain_lines() {
    let bench = Bench::new();
    let output = run(&bench, &[]);
    let (lines, results) = (text(&output.stderr), text(&output.stdout));
    assert!(!lines.contains('\u{1b}') && !results.contains('\u{1b}'), "{lines}");
    for node in &NODES[1..] {
        assert!(lines.contains(&format!("{node}: done scenario-1 ")), "{node}: {lines}");
    }
    assert!(lines.contains("estimator: done scenario-1 20/20"), "{lines}");
    assert!(results.contains("Results: "));
}

#[test]
fn a_quiet_run_prints_nothing() {
    let bench = Bench::new();
    let output = run(&bench, &["--quiet"]);
    assert_eq!((text(&output.stdout), text(&output.stderr)), (String::new(), String::new()));
}

#[test]
fn json_has_an_object_a_line_and_the_tables_in_the_last() {
    let bench = Bench::new();
    let output = run(&bench, &["--json"]);
    let printed = text(&output.stdout);
    let objects: Vec<Value> = printed.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let (result, events) = objects.split_last().unwrap();
    assert!(events.iter().all(|event| event["event"] == "progress"), "{printed}");
    for node in NODES {
        assert!(events.iter().any(|event| event["node"] == node && event["phase"] == "done"), "{node}: {printed}");
    }
    assert_eq!((&result["event"], &result["exit_code"]), (&Value::from("result"), &Value::from(0)));
    let moments = result["tables"]["moments"].as_array().unwrap();
    let written = bench.table("out/moments.csv");
    assert_eq!(moments.len(), written.len());
    assert_eq!(moments[3]["mean_phi_rad"], written[3]["mean_phi_rad"].parse::<f64>().unwrap());
    assert_eq!(moments[3]["method"], "mc");

    let bad = bench.phasecloud().args(["run", "missing.toml", "--json"]).output().unwrap();
    let result: Value = serde_json::from_str(text(&bad.stdout).trim()).unwrap();
    assert_eq!((bad.status.code(), &result["exit_code"]), (Some(2), &Value::from(2)));
    assert!(result["problem"].as_str().unwrap().contains("missing.toml"));
}

#[test]
fn a_watcher_sees_the_run_to_its_end_and_the_same_results() {
    let bench = Bench::new();
    // A case that waits until the watcher is there.
    let late = format!(
        "[[propagator]]\nlabel = \"late\"\ncommand = [\"sh\", \"-c\", \"until test -e go; do sleep 0.02; done; \
         exec {} node gmm-ut --label late\"]\n",
        env!("CARGO_BIN_EXE_phasecloud")
    );
    bench.launch_file("late", &format!("{FOUR_CASES}\n{late}"));
    let mut command = bench.phasecloud();
    command.args(["run", "late.toml", "--out", "out"]).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut run = command.spawn().unwrap();
    let started = Instant::now();
    while bench.domains().is_empty() || !text(&topics(&bench).stdout).contains("phasecloud/roster") {
        assert!(started.elapsed() < WATCHDOG, "the run did not start");
        std::thread::sleep(Duration::from_millis(20));
    }
    let watcher = bench.phasecloud().arg("watch").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    while !text(&topics(&bench).stdout).lines().any(|line| line.contains("/status") && line.ends_with(" 1 |")) {
        assert!(started.elapsed() < WATCHDOG, "the watcher did not attach");
        std::thread::sleep(Duration::from_millis(20));
    }
    bench.write("go", "");
    let watched = watcher.wait_with_output().unwrap();
    let mut results = String::new();
    run.stdout.take().unwrap().read_to_string(&mut results).unwrap();
    assert!(run.wait().unwrap().success());
    assert!(watched.status.success(), "{}", text(&watched.stderr));
    let lines = text(&watched.stderr);
    for node in ["late", "mc", "recorder"] {
        assert!(lines.contains(&format!("{node}: done scenario-1 ")), "{node}: {lines}");
    }
    let tables = |printed: &str| printed.split("Results: ").next().unwrap().to_owned();
    assert_eq!(tables(&text(&watched.stdout)), tables(&results), "both print the same tables");
    assert_eq!(bench.domains(), [""; 0]);
}

fn topics(bench: &Bench) -> Output {
    bench.phasecloud().arg("topics").output().unwrap()
}

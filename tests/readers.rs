//! Readers that go away: if output goes into a closed pipe or onto a full device, no command panics, and no run ends.
#![allow(missing_docs)]

mod common;

use std::fs::File;
use std::process::{Child, Command, Stdio};

use common::processes::{end_of, of_runs_below, signal_child, wait_for};
use common::{Bench, text};
use rustix::fs::{Mode, OFlags, open};
use rustix::process::Signal;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

const SMALL: &str = "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 2_000\n";

/// A pipe that nobody reads.
fn closed_pipe() -> Stdio {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    writer.into()
}

fn full_device() -> Stdio {
    File::options().write(true).open("/dev/full").unwrap().into()
}

/// Sends both outputs of a command to `sink`.
fn into(command: &mut Command, sink: fn() -> Stdio) -> &mut Command {
    command.stdout(sink()).stderr(sink())
}

const SINKS: [fn() -> Stdio; 2] = [closed_pipe, full_device];

#[test]
fn a_run_goes_on_to_its_results_whoever_stops_reading() {
    for (sink, full) in SINKS.into_iter().zip([false, true]) {
        for options in [&[][..], &["--json"], &["--log", "debug"]] {
            let bench = Bench::new();
            let launch = bench.launch_file("small", SMALL);
            let mut command = bench.phasecloud();
            command.arg("run").arg(launch).args(["--out", "out"]).args(options);
            let status = into(&mut command, sink).status().unwrap();
            // JSON is the only result of its command: it is written whole or its loss is reported, but not to a reader
            // that has closed the pipe.
            let is_lost = full && options == ["--json"];
            assert_eq!(status.code(), Some(i32::from(is_lost)), "{options:?}");
            assert_eq!(bench.table("out/moments.csv").len(), 5);
            assert_eq!(bench.domains(), [""; 0]);
        }
    }
}

#[test]
fn commands_that_print_their_result_do_not_panic_and_say_when_it_could_not_be_written() {
    let bench = Bench::new();
    let launch = bench.launch_file("small", SMALL).display().to_string();
    bench.run_well(&bench.path("small.toml"), "out");
    bench.write("bad.toml", "name = 1");
    let commands: [(&[&str], i32, i32); 14] = [
        (&["graph", &launch], 0, 1),
        (&["validate", &launch], 0, 1),
        (&["validate", "bad.toml"], 2, 2),
        (&["verify", "out"], 0, 1),
        (&["verify", "nowhere"], 2, 2),
        (&["topics"], 0, 1),
        (&["report", "out"], 0, 0),
        (&["clean"], 0, 0),
        (&["watch"], 2, 2),
        (&["--help"], 0, 1),
        (&["--version"], 0, 1),
        (&["help", "run"], 0, 1),
        (&["--nonsense"], 2, 2),
        (&["run", "bad.toml"], 2, 2),
    ];
    for (words, when_closed, when_full) in commands {
        for (sink, expected) in SINKS.into_iter().zip([when_closed, when_full]) {
            let status = into(bench.phasecloud().args(words), sink).status().unwrap();
            assert_eq!(status.code(), Some(expected), "{words:?}");
        }
    }
    for words in [&["graph", &launch][..], &["--help"], &["run", "small.toml", "--json", "--out", "json"]] {
        let output = bench.phasecloud().args(words).stdout(full_device()).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{words:?}");
        assert!(text(&output.stderr).contains("standard output cannot be written: No space left"), "{words:?}");
    }
    assert!(bench.path("json/manifest.json").exists());
    let output = bench.phasecloud().arg("--help").stdout(closed_pipe()).output().unwrap();
    assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(0), ""));
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn a_service_and_those_who_look_at_it_outlive_their_readers() {
    for sink in SINKS {
        let bench = Bench::new();
        let launch = bench.launch_file("small", SMALL);
        let mut command = bench.phasecloud();
        command.arg("serve").arg(launch).args(["--out", "served"]);
        let mut service = into(&mut command, sink).spawn().unwrap();
        wait_for("the service does not start", || (of_runs_below(&bench.path("")).len() == 5).then_some(()));
        let mut watch = into(bench.phasecloud().arg("watch"), sink).spawn().unwrap();
        for position in 0..3 {
            let submitted = into(bench.phasecloud().args(["submit", "scenario-1.toml"]), sink).status().unwrap();
            assert_eq!(submitted.code(), Some(0));
            let folder = bench.path(&format!("served/{position:06}-scenario-1/manifest.json"));
            wait_for("the results do not come", || folder.exists().then_some(()));
        }
        for words in [&["topics"][..], &["echo", "status", "--count", "1"], &["hz", "status"]] {
            let code = into(bench.phasecloud().args(words), sink).status().unwrap().code();
            assert!(matches!(code, Some(0 | 1 | 130)), "{words:?}: {code:?}");
        }
        signal_child(&service, Signal::INT);
        assert_eq!(end_of(&mut service).code(), Some(0));
        assert!(end_of(&mut watch).code().is_some_and(|code| code != 101));
        assert_eq!(bench.domains(), [""; 0]);
    }
}

/// Starts a command as the leader of a session with a terminal of its own; the terminal ends when the other end is
/// dropped.
fn on_own_terminal(command: &Command) -> (Child, File) {
    let screen = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap(); // only this process has it
    grantpt(&screen).unwrap();
    unlockpt(&screen).unwrap();
    let name = ptsname(&screen, Vec::new()).unwrap();
    let terminal = || Stdio::from(open(name.as_c_str(), OFlags::RDWR | OFlags::NOCTTY, Mode::empty()).unwrap());
    let mut leader = Command::new("setsid");
    leader.arg("--ctty").arg("--wait").arg(command.get_program()).args(command.get_args());
    leader.current_dir(command.get_current_dir().unwrap()).env("TERM", "xterm");
    leader.envs(command.get_envs().filter_map(|(name, value)| Some((name, value?))));
    let child = leader.stdin(terminal()).stdout(terminal()).stderr(terminal()).spawn().unwrap();
    (child, screen.into())
}

#[test]
fn a_run_goes_on_to_its_results_when_its_terminal_is_closed() {
    let bench = Bench::new();
    // The run has so much to do that the terminal is closed before the run is done, on any machine.
    let slow =
        "[[propagator]]\nlabel = \"slow\"\ncommand = [\"sh\", \"-c\", \"while [ ! -e go ]; do sleep 0.05; done\"]\n";
    let launch = bench.launch_file("small", &format!("{SMALL}{slow}"));
    let mut command = bench.phasecloud();
    command.arg("run").arg(launch).args(["--out", "out"]);
    let (mut child, screen) = on_own_terminal(&command);
    wait_for("the run does not start", || (of_runs_below(&bench.path("")).len() >= 6).then_some(()));
    drop(screen);
    bench.write("go", "");
    wait_for("there are no results", || bench.path("out/manifest.json").exists().then_some(()));
    let _ = end_of(&mut child);
    let manifest = bench.manifest("out");
    assert_eq!(manifest["complete"], true);
    assert_eq!(manifest["failures"]["slow"], "ended before the run did: exit status: 0");
}

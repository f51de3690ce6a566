//! Propagators in Python as processes: one that fails, one that is stopped, one whose recorder dies.

use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use messages::content::kind;
use messages::domain::{HeldDomain, Place};
use messages::layout::{SnapshotHeader, event};
use messages::scenario::{Description, Moment, Parameter, Projection, Range, Variable};
use messages::text::pack;
use messages::topic::{Capacity, Scenario, Snapshot, Status};
use rustix::process::{Pid, Signal, kill_process};

use crate::common::processes::{Said, end_of, of_runs_below, signal, wait_for};
use crate::common::{self, Bench, text};
use crate::environment::{examples, interpreter};
use crate::launch_file;

/// Far longer than a healthy machine needs; only ends a test that would hang.
const WATCHDOG: Duration = Duration::from_secs(180);

#[test]
#[ignore = "long; .ci/long runs it"]
fn an_exception_in_a_python_propagator_is_named() {
    let Some(python) = interpreter() else { return };
    let bench = Bench::new();
    let start = "from phasecloud.kit import *\n";
    for (body, words) in [
        ("raise ValueError('no luck today')", "mc: ValueError: no luck today"),
        ("pass", "mc: ValueError: only 0 of 5 snapshots were sent"),
        ("run.snapshot(SAMPLES, rows=0).__enter__()", "mc: ValueError: 0 rows"),
    ] {
        let script = bench.write("failing.py", &format!("{start}def f(problem, run):\n    {body}\nserve(f)\n"));
        let command = [&python.display().to_string(), "-B", &script.display().to_string()];
        let output = bench.run(&launch_file(&bench, &command), &format!("out-{}", words.len()));
        assert_eq!(output.status.code(), Some(1));
        assert!(text(&output.stderr).contains(words), "{}", text(&output.stderr));
        assert_eq!(bench.table(&format!("out-{}/moments.csv", words.len())).len(), 12, "the exact case is complete");
        assert_eq!(bench.domains(), [""; 0]);
    }
}

/// Ends a process that a failed test would leave behind.
struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Killed {
    fn wait(&mut self) -> ExitStatus {
        let started = Instant::now();
        loop {
            if let Some(status) = self.0.try_wait().unwrap() {
                return status;
            }
            assert!(started.elapsed() < WATCHDOG, "the process did not end");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

/// Removes a domain at the end, also when the test fails.
struct Removed(Place);

impl Drop for Removed {
    fn drop(&mut self) {
        let _ = self.0.remove();
    }
}

/// All files of a domain.
fn files(place: &Place) -> Vec<PathBuf> {
    let mut folders = vec![place.root.clone()];
    let mut files: Vec<_> = common::shared_memory_of(&place.prefix).into_iter().map(PathBuf::from).collect();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            if entry.file_type().unwrap().is_dir() { folders.push(entry.path()) } else { files.push(entry.path()) }
        }
    }
    files.sort();
    files
}

#[test]
fn a_python_propagator_that_is_stopped_leaves_no_files_whether_it_waits_or_computes() {
    let Some(python) = interpreter() else { return };
    for computing in [false, true] {
        let bench = Bench::new();
        let removed =
            Removed(Place { root: bench.path("domain"), prefix: format!("pcpy{}{computing}-", std::process::id()) });
        let place = &removed.0;
        let held = HeldDomain::create(place, &Capacity { propagators: 1, cases: 1, snapshots: 2, hosts: 0 }).unwrap();
        let reports = held.domain.inlet::<Status>().unwrap();
        let scenario = held.domain.outlet::<Scenario>(Description::numbers(2, 2, 2)).unwrap();
        let snapshots = held.domain.inlet::<Snapshot>().unwrap();
        let parameter = |name: &str, value| Parameter { name: name.into(), symbol: "x".into(), value };
        let variable =
            |symbol: &str, range| Variable { name: symbol.into(), symbol: symbol.into(), unit: String::new(), range };
        let at = |time| Moment { time, ends: vec![[0.0, 6.0], [0.0, 1.0]] };
        let said = Description {
            run_id: 7,
            scenario: 0,
            scenarios: 0,
            name: "mine".into(),
            model: "planar".into(),
            parameters: vec![parameter("radiation", 0.15), parameter("oblateness", 0.40921)],
            variables: vec![variable("phi", Range::Circle), variable("e", Range::Interval { low: 0.0, high: 1.0 })],
            reentry: 1,
            critical: 0.6,
            mean: vec![2.2, 0.145],
            covariance: vec![0.04, 0.0, 0.000625],
            projections: vec![Projection { first: (0, 1), second: Some((1, 1)) }],
            // Far more years than it can compute before it is stopped.
            snapshots: vec![at(0.0), at(1e6)],
        };
        let (header, items) = said.encode().unwrap();
        if computing {
            scenario.send_items(header, &items).unwrap();
        }
        let before = files(place);
        let command = Command::new(python)
            .args(["-B", &examples().join("monte_carlo.py").display().to_string(), "--samples", "300"])
            .envs([("PHASECLOUD_LABEL", "mine"), ("PHASECLOUD_RUN_ID", "7"), ("PHASECLOUD_PREFIX", &place.prefix)])
            .env("PHASECLOUD_ROOT", &place.root)
            .env_remove("PHASECLOUD_LAUNCHER")
            .spawn();
        let mut process = Killed(command.unwrap());
        // In a run the launcher wakes a node that joins late; here the test does.
        let signals = messages::wait::Signals::catch(&[]).unwrap();
        let last = if computing { event::PROGRESS } else { event::READY };
        let started = Instant::now();
        let mut heard = 0;
        while heard != last {
            assert!(started.elapsed() < WATCHDOG, "heard {heard}");
            signals.wait(&[&reports, &scenario], Duration::from_millis(100)).unwrap();
            while let Some(report) = reports.receive().unwrap() {
                assert_eq!(report.header().node, pack("mine"));
                heard = report.header().event;
            }
        }
        if computing {
            let first = snapshots.receive().unwrap().expect("it is sent before the status");
            let &SnapshotHeader { run_id, index, count, kind, rows, columns, .. } = first.header();
            assert_eq!((run_id, index, count, kind, rows, columns), (7, 0, 2, kind::SAMPLES, 300, 2));
            assert_eq!(first.items().len(), 600);
            assert!(first.items()[300..].iter().all(|e| (0.0..1.0).contains(e)));
        }
        kill_process(Pid::from_child(&process.0), Signal::TERM).unwrap();
        assert_eq!(process.wait().code(), Some(0));
        drop((reports, scenario, snapshots)); // the other ends of its connections
        let left: Vec<_> = files(place).into_iter().filter(|file| !before.contains(file)).collect();
        assert_eq!(left, [""; 0].map(PathBuf::from));
    }
}

#[test]
fn a_recorder_that_is_killed_after_a_python_case_was_done_misses_nothing_of_it() {
    let Some(python) = interpreter() else { return };
    let bench = Bench::new();
    let command = [&python.display().to_string(), "-B", &examples().join("monte_carlo.py").display().to_string()];
    let words = command.map(|word| format!("\"{word}\"")).join(", ");
    let cases = format!(
        "patience = 60\n[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 2_000\n\
         [[propagator]]\nlabel = \"python\"\ncommand = [{words}]\n\
         [[propagator]]\nlabel = \"late\"\ncommand = [\"sh\", \"-c\", \"until test -e go; do sleep 0.1; done; exec $0 $@\", {words}]\n"
    );
    let mut command = bench.phasecloud();
    command.arg("run").arg(bench.launch_file("killed", &cases)).args(["--no-report", "--out", "out"]);
    let mut launcher = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut said = Said::by(launcher.stderr.take().unwrap());
    said.wait_for("python: done");
    let recorder = wait_for("there is no recorder", || {
        of_runs_below(&bench.path("")).into_iter().find(|process| process.label == "recorder")
    });
    signal(&recorder, Signal::KILL);
    said.wait_for("it is started again");
    bench.write("go", "");
    let code = end_of(&mut launcher).code();
    assert_eq!(code, Some(0), "{}", said.rest());
    let rows = bench.table("out/moments.csv");
    assert_eq!(rows.iter().filter(|row| row["method"] == "python").count(), 5);
}

//! Propagators in Python: the kit in `python/phasecloud/kit` and the examples in `examples/python`, in real runs.
//!
//! Needs python3 with venv, and access to the package index once; without them the tests print why and are skipped,
//! unless `PHASECLOUD_REQUIRE_PYTHON=1`.
#![allow(missing_docs)]

mod common;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use common::processes::{Said, end_of, of_runs_below, signal, wait_for};
use common::{Bench, text};
use messages::content::kind;
use messages::domain::{HeldDomain, Place};
use messages::layout::{SnapshotHeader, event};
use messages::scenario::{Description, Moment, Parameter, Projection, Range, Variable};
use messages::text::pack;
use messages::topic::{Capacity, Scenario, Snapshot, Status};
use rustix::process::{Pid, Signal, kill_process};

/// Far longer than a healthy machine needs; only ends a test that would hang.
const WATCHDOG: Duration = Duration::from_secs(180);

/// The examples.
fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/python")
}

/// An interpreter with the packages that the kit requires; made once, and again when the requirements change.
static INTERPRETER: LazyLock<Result<PathBuf, String>> = LazyLock::new(|| {
    let environment = Path::new(env!("CARGO_TARGET_TMPDIR")).join("python");
    let interpreter = environment.join("bin/python");
    let requirements = examples().join("requirements.txt");
    let wanted = std::fs::read_to_string(&requirements).map_err(|e| format!("{}: {e}", requirements.display()))?;
    let installed = environment.join("installed.txt");
    if std::fs::read_to_string(&installed).ok().as_deref() != Some(&wanted) {
        succeed(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&environment))?;
        let pip = ["-m", "pip", "install", "--quiet", "--retries", "1", "-r"];
        succeed(Command::new(&interpreter).args(pip).arg(&requirements))?;
        std::fs::write(&installed, wanted).map_err(|e| format!("{}: {e}", installed.display()))?;
    }
    lead_to_the_package(&interpreter)?;
    Ok(interpreter)
});

/// Makes `import phasecloud` find the sources of this checkout, as an editable installation does. The kit needs no compiled part of the package.
fn lead_to_the_package(interpreter: &Path) -> Result<(), String> {
    let where_to = "import site; print(site.getsitepackages()[0])";
    let output = Command::new(interpreter).args(["-c", where_to]).output().map_err(|e| e.to_string())?;
    let file = Path::new(text(&output.stdout).trim()).join("phasecloud.pth");
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("python");
    std::fs::write(&file, package.display().to_string()).map_err(|e| format!("{}: {e}", file.display()))
}

fn succeed(command: &mut Command) -> Result<(), String> {
    let output = command.stdin(Stdio::null()).output().map_err(|e| format!("{command:?}: {e}"))?;
    if output.status.success() { Ok(()) } else { Err(format!("{command:?}: {}", text(&output.stderr))) }
}

/// The same with heyoka, which has no package for every machine.
static WITH_HEYOKA: LazyLock<Result<PathBuf, String>> = LazyLock::new(|| {
    let interpreter = INTERPRETER.as_ref()?;
    if succeed(Command::new(interpreter).args(["-c", "import heyoka"])).is_err() {
        let pip = ["-m", "pip", "install", "--quiet", "--retries", "1", "--only-binary", ":all:", "-r"];
        succeed(Command::new(interpreter).args(pip).arg(examples().join("requirements-heyoka.txt")))?;
    }
    Ok(interpreter.clone())
});

/// The interpreter, or `None` after printing why there is none.
fn interpreter() -> Option<&'static Path> {
    required(&INTERPRETER)
}

fn required(interpreter: &'static Result<PathBuf, String>) -> Option<&'static Path> {
    match interpreter.as_ref() {
        Ok(interpreter) => Some(interpreter),
        Err(why) => {
            assert!(std::env::var_os("PHASECLOUD_REQUIRE_PYTHON").is_none_or(|value| value != "1"), "{why}");
            println!("skipped: {why}");
            None
        }
    }
}

/// A launch file on two scenarios: the exact answer, and a program under the label `mc`.
fn launch_file(bench: &Bench, command: &[&str]) -> PathBuf {
    bench.write("scenario-2.toml", include_str!("../launch/scenarios/scenario-2.toml"));
    let head = "name = \"python\"\nscenarios = [\"scenario-1.toml\", \"scenario-2.toml\"]\nreference = \"exact\"\n";
    let cases = "[[propagator]]\nlabel = \"exact\"\nnode = \"exact\"\n[[propagator]]\nlabel = \"mc\"\n";
    bench.write("python.toml", &format!("{head}{cases}command = {command:?}\n"))
}

#[test]
fn monte_carlo_in_python_has_the_exact_moments_within_four_standard_errors() {
    let Some(python) = interpreter() else { return };
    const SAMPLES: usize = 1000;
    let bench = Bench::new();
    let (python, script) = (python.display().to_string(), examples().join("monte_carlo.py").display().to_string());
    let command = [&python, "-B", &script, "--samples", &SAMPLES.to_string()];
    bench.run_well(&launch_file(&bench, &command), "out");

    let rows = bench.table("out/moments.csv");
    let of = |method: &str| rows.iter().filter(|row| row["method"] == method).collect::<Vec<_>>();
    let (exact, sampled) = (of("exact"), of("mc"));
    assert_eq!((exact.len(), sampled.len()), (12, 12));
    for (exact, sampled) in exact.into_iter().zip(sampled) {
        let value = |row: &HashMap<String, String>, column: &str| row[column].parse::<f64>().unwrap();
        for column in ["mean_phi_rad", "std_phi_rad", "mean_e", "std_e", "cov_phi_e"] {
            let error = value(sampled, &format!("se_{column}"));
            assert!(error > 0.0);
            assert!((value(sampled, column) - value(exact, column)).abs() < 4.0 * error, "{column}: {sampled:?}");
        }
        let p = value(exact, "prob_above_critical_e");
        let error = (p * (1.0 - p) / SAMPLES as f64).sqrt();
        assert!((value(sampled, "prob_above_critical_e") - p).abs() <= 4.0 * error + 1e-3, "{sampled:?}");
    }
    let manifest: serde_json::Value = serde_json::from_slice(&bench.read("out/manifest.json")).unwrap();
    assert_eq!(manifest["nodes"]["mc"], "ended on request", "however far its interpreter had come");
    assert_eq!(common::shared_memory_of(manifest["run_id"].as_str().unwrap()), [""; 0]);
    assert_eq!(bench.domains(), [""; 0]);
}

#[test]
fn heyoka_moves_the_same_draws_to_the_same_moments_as_scipy() {
    let Some(python) = required(&WITH_HEYOKA) else { return };
    let bench = Bench::new();
    let case = |label: &str, script: &str| {
        let script = examples().join(script).display().to_string();
        let command = [&python.display().to_string(), "-B", &script, "--samples", "300"];
        format!("[[propagator]]\nlabel = \"{label}\"\ncommand = {command:?}\n")
    };
    let cases = case("mc", "monte_carlo.py") + &case("heyoka", "heyoka_monte_carlo.py");
    bench.run_well(&bench.launch_file("heyoka", &cases), "out");
    let rows = bench.table("out/moments.csv");
    let of = |method: &str| rows.iter().filter(|row| row["method"] == method).collect::<Vec<_>>();
    let (scipy, heyoka) = (of("mc"), of("heyoka"));
    assert_eq!((scipy.len(), heyoka.len()), (5, 5));
    for (scipy, heyoka) in scipy.into_iter().zip(heyoka) {
        for column in ["mean_phi_rad", "std_phi_rad", "mean_e", "std_e", "cov_phi_e"] {
            let [a, b] = [scipy, heyoka].map(|row| row[column].parse::<f64>().unwrap());
            assert!((a - b).abs() < 1e-8, "{column}: {a} {b}"); // SciPy's tolerance, grown over two years
        }
    }
}

#[test]
fn shards_in_python_have_the_moments_of_the_whole() {
    let Some(python) = interpreter() else { return };
    let bench = Bench::new();
    let case = |label: &str, shards: u32, script: &str| {
        let command = [&python.display().to_string(), "-B", script, "--samples", "301"];
        format!("[[propagator]]\nlabel = \"{label}\"\nshards = {shards}\ncommand = {command:?}\n")
    };
    let script = examples().join("monte_carlo.py").display().to_string();
    let whole =
        "from phasecloud.kit import SAMPLES, serve\nserve(lambda problem, run: run.snapshot(SAMPLES, 9).__enter__())\n";
    let unsplit = bench.write("unsplit.py", whole).display().to_string();
    let cases = case("mc", 1, &script) + &case("split", 3, &script) + &case("unsplit", 2, &unsplit);
    let mut command = bench.phasecloud();
    command.arg("run").arg(bench.launch_file("shards", &cases)).arg("--out").arg(bench.path("out"));
    let output = command.output().unwrap();
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("this propagator cannot be split into shards"), "{said}");
    let rows = bench.table("out/moments.csv");
    let of = |method: &str| rows.iter().filter(|row| row["method"] == method).collect::<Vec<_>>();
    assert_eq!((of("mc").len(), of("split").len(), of("unsplit").len()), (5, 5, 0), "{said}");
    for (whole, split) in of("mc").into_iter().zip(of("split")) {
        for column in ["mean_phi_rad", "std_phi_rad", "mean_e", "std_e", "cov_phi_e"] {
            let [a, b] = [whole, split].map(|row| row[column].parse::<f64>().unwrap());
            assert!((a - b).abs() < 1e-8, "{column}: {a} {b}"); // blocks share step sizes
        }
    }
}

#[test]
fn without_heyoka_its_example_says_what_is_missing() {
    let Some(python) = interpreter() else { return };
    let bench = Bench::new();
    bench.write("heyoka.py", "raise ImportError");
    let script = examples().join("heyoka_monte_carlo.py");
    let output = Command::new(python).arg("-B").arg(script).env("PYTHONPATH", bench.path(".")).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("pip install -r examples/python/requirements-heyoka.txt"));
}

#[test]
fn the_python_examples_keep_all_rules() {
    let (plane, space) = ("17 rules kept, 1 not judged", "16 rules kept, 2 not judged");
    for (interpreter, script, model, kept) in [
        (&INTERPRETER, "monte_carlo.py", "planar", plane),
        (&WITH_HEYOKA, "heyoka_monte_carlo.py", "planar", plane),
        (&WITH_HEYOKA, "heyoka_vectorial.py", "vectorial", space), // whose Hamiltonian depends on time
    ] {
        let Some(python) = required(interpreter) else { return };
        let bench = Bench::new();
        let mut check = bench.phasecloud();
        check
            .args(["check", "--model", model, "--grace", "30", "--"])
            .arg(python)
            .arg("-B")
            .arg(examples().join(script));
        let output = check.args(["--samples", "300"]).output().unwrap();
        assert!(output.status.success(), "{}{}", text(&output.stdout), text(&output.stderr));
        assert!(text(&output.stdout).contains(&format!("passed: {kept}")), "{}", text(&output.stdout));
    }
}

#[test]
fn a_new_propagator_keeps_all_rules_beside_its_own_copy_of_the_kit() {
    let Some(python) = interpreter() else { return };
    let bench = Bench::new();
    let written = bench.phasecloud().args(["new", "--python", "mine"]).output().unwrap();
    assert!(written.status.success(), "{}", text(&written.stderr));
    // This start refuses to import the package.
    let start = "import sys, runpy\nsys.meta_path.insert(0, type('', (), {'find_spec': staticmethod(lambda name, *_: sys.exit(name) if name == 'phasecloud' else None)})())\n\
                 sys.path.insert(0, 'mine')\nrunpy.run_path('mine/propagator.py', run_name='__main__')\n";
    bench.write("start.py", start);
    let mut check = bench.phasecloud();
    check.args(["check", "--grace", "30", "--"]).arg(python).args(["-B", "start.py", "--samples", "300"]);
    let output = check.output().unwrap();
    assert!(output.status.success(), "{}{}", text(&output.stdout), text(&output.stderr));
}

#[test]
fn the_notebook_redraws_a_figure_from_a_results_folder() {
    let Some(python) = interpreter() else { return };
    let bench = Bench::new();
    bench.run_well(&bench.launch_file("four", common::FOUR_CASES), "out");
    let notebook = |method: &str, picture: &str| {
        let mut command = Command::new(python);
        command
            .arg("-B")
            .arg(examples().join("results.py"))
            .arg(bench.path("out"))
            .arg(method)
            .arg(bench.path(picture));
        command.env("MPLCONFIGDIR", bench.path("matplotlib")).output().unwrap()
    };
    let output = notebook("dee-961", "picture.png");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let printed = text(&output.stdout);
    let rows: Vec<_> = bench.table("out/moments.csv").into_iter().filter(|row| row["method"] == "dee-961").collect();
    assert_eq!(rows.len(), 5);
    for row in rows {
        let mean = format!("{:.5}", row["mean_e"].parse::<f64>().unwrap());
        assert!(printed.contains(&mean), "{mean} in {printed}");
        let mass = format!("{:.4} of the probability", row["mass_on_grid"].parse::<f64>().unwrap());
        assert!(printed.contains(&mass), "{mass} in {printed}");
    }
    let (width, height, colours) = common::picture(&bench.read("picture.png"));
    assert!(width > 1000 && height > 200 && colours.len() > 200, "{width} x {height}, {} colours", colours.len());

    // Without a name for the picture it is written beside the results, not into them.
    let mut command = Command::new(python);
    command.arg("-B").arg(examples().join("results.py")).arg(bench.path("out")).current_dir(bench.path("."));
    let output = command.env("MPLCONFIGDIR", bench.path("matplotlib")).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(bench.path("out-mc.png").is_file(), "{}", text(&output.stdout));
    let verified = bench.phasecloud().arg("verify").arg(bench.path("out")).output().unwrap();
    assert!(verified.status.success(), "{}", text(&verified.stderr));

    let unknown = notebook("no-such-case", "other.png");
    assert!(!unknown.status.success() && text(&unknown.stderr).contains("there are"), "{}", text(&unknown.stderr));
}

#[test]
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

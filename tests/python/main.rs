//! Propagators in Python: the kit in `python/phasecloud/kit` and the examples in `examples/python`, in real runs.
//!
//! Needs python3 with venv, and access to the package index once; without them the tests print why and are skipped,
//! unless `PHASECLOUD_REQUIRE_PYTHON=1`.
#![allow(missing_docs)]

#[path = "../common/mod.rs"]
mod common;
mod environment;
mod processes;

use std::collections::HashMap;
use std::path::PathBuf;
use std::process::Command;

use common::{Bench, text};
use environment::{INTERPRETER, WITH_HEYOKA, examples, interpreter, required};

/// A launch file on two scenarios: the exact answer, and a program under the label `mc`.
fn launch_file(bench: &Bench, command: &[&str]) -> PathBuf {
    bench.write("scenario-2.toml", include_str!("../../launch/scenarios/scenario-2.toml"));
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
#[ignore = "long; .ci/long runs it"]
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

//! A model that is not phasecloud's, with three variables and no Hamiltonian, goes through two propagators of its own
//! and through phasecloud's estimator, comparator, recorder and report: all of them know its space by the scenario
//! message alone.
#![allow(missing_docs)]

mod common;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use common::examples::example;
use common::{Bench, text};
use messages::domain::{HeldDomain, Place};
use messages::layout::{RosterEntry, RosterHeader};
use messages::report::{Event, Report};
use messages::scenario::{Description, Moment, Parameter, Projection, Range, Variable};
use messages::service::Service;
use messages::text::pack;
use messages::topic::{Capacity, Roster, Scenario, Status};
use messages::wait::Signals;
use results::Manifest;
use results::files::{SCENARIO, SCENARIOS};
use results::manifest::CaseRecord;

/// Long past anything that a healthy machine takes; only to end a test that would hang.
const WATCHDOG: Duration = Duration::from_secs(120);
const RUN: u64 = 7;
const TURNS: f64 = 4.0;
const MEAN: [f64; 3] = [1.0, 5.0, -2.0];
/// Upper triangle, row by row.
const COVARIANCE: [f64; 6] = [0.04, 0.05, -0.02, 0.25, 0.03, 0.09];
const TIMES: [f64; 3] = [0.0, 0.7, 2.0];

struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Removes a domain at the end, also of a test that fails.
struct Removed(Place);

impl Drop for Removed {
    fn drop(&mut self) {
        let _ = self.0.remove();
    }
}

/// Points that turn about the `z` axis: their angles grow, all else stays.
fn scenario() -> Description {
    let variable = |name: &str, symbol: &str, unit: &str, range| {
        let [name, symbol, unit] = [name, symbol, unit].map(str::to_owned);
        Variable { name, symbol, unit, range }
    };
    let parameter = |name: &str, value| Parameter { name: name.into(), symbol: name.into(), value };
    let reach = |k: usize, variance: f64| [MEAN[k] - 5.0 * variance.sqrt(), MEAN[k] + 5.0 * variance.sqrt()];
    let at = |time: f64| {
        let [low, high] = reach(0, COVARIANCE[0]);
        let (psi, r, z) = ([low + TURNS * time, high + TURNS * time], reach(1, COVARIANCE[3]), reach(2, COVARIANCE[5]));
        Moment { time, ends: vec![r, z, psi, psi, r, z] }
    };
    let pair = |a: usize, b: usize| Projection { first: (a, 30), second: Some((b, 30)) };
    let one = |k: usize| Projection { first: (k, 30), second: None };
    Description {
        run_id: RUN,
        scenario: 0,
        scenarios: 1,
        name: "turning".into(),
        model: "rigid-rotation".into(),
        parameters: vec![parameter("z", 1.0), parameter("turns", TURNS)],
        variables: vec![
            variable("angle", "psi", "rad", Range::Circle),
            variable("distance", "r", "m", Range::Interval { low: 0.0, high: 100.0 }),
            variable("height", "z", "m", Range::Interval { low: -100.0, high: 100.0 }),
        ],
        reentry: 2,
        critical: -1.7,
        mean: MEAN.to_vec(),
        covariance: COVARIANCE.to_vec(),
        projections: vec![pair(1, 2), Projection { first: (0, 30), second: None }, pair_with_angle(), one(2)],
        snapshots: TIMES.map(at).to_vec(),
    }
}

/// Angle and distance.
fn pair_with_angle() -> Projection {
    Projection { first: (0, 30), second: Some((1, 30)) }
}

fn node(bench: &Bench, place: &Place, mut command: Command) -> Killed {
    command
        .envs([("PHASECLOUD_RUN_ID", "7"), ("PHASECLOUD_PREFIX", &place.prefix)])
        .env("PHASECLOUD_ROOT", &place.root)
        .env_remove("PHASECLOUD_LAUNCHER");
    Killed(command.current_dir(bench.path(".")).stdin(Stdio::null()).spawn().unwrap())
}

/// Runs the scenario through real processes and returns the folder of its results.
fn run(bench: &Bench) -> PathBuf {
    let removed = Removed(Place { root: bench.path("domain"), prefix: format!("pcam{}-", std::process::id()) });
    let place = &removed.0;
    let capacity = Capacity { propagators: 2, cases: 2, snapshots: TIMES.len(), hosts: 0 };
    let held = HeldDomain::create(place, &capacity).unwrap();
    let reports = held.domain.inlet::<Status>().unwrap();
    let roster = held.domain.outlet::<Roster>(2).unwrap();
    let (header, items) = scenario().encode().unwrap();
    let scenarios = held.domain.outlet::<Scenario>(items.len()).unwrap();
    let entry =
        |label: &str, reference| RosterEntry { label: pack(label), shards: 1, reference, ..RosterEntry::default() };
    let header_of_roster = RosterHeader { run_id: RUN, ..RosterHeader::default() };
    roster.send_items(header_of_roster, &[entry("mc", 1), entry("ut", 0)]).unwrap();
    scenarios.send_items(header, &items).unwrap();
    let out = bench.path("results");
    std::fs::create_dir(&out).unwrap();
    let mut nodes = Vec::new();
    for kind in ["estimator", "comparator", "recorder"] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_phasecloud"));
        command.args(["node", kind]);
        if kind == "recorder" {
            command.arg("--out").arg(&out);
        }
        nodes.push(node(bench, place, command));
    }
    for label in ["mc", "ut"] {
        let mut command = Command::new(example("rigid-rotation"));
        command.arg(label).env("PHASECLOUD_LABEL", label);
        nodes.push(node(bench, place, command));
    }
    let signals = Signals::catch(&[]).unwrap();
    let started = Instant::now();
    let mut heard = Vec::new();
    'done: loop {
        assert!(started.elapsed() < WATCHDOG, "heard {heard:?}");
        signals.wait(&[&reports, &roster, &scenarios], Duration::from_millis(100)).unwrap();
        while let Some(report) = reports.receive().unwrap() {
            let report = Report::from_parts(report.header(), report.items()).unwrap();
            assert!(!matches!(report.event, Event::Failed { .. }), "{report:?}");
            if report.from.is(Service::Recorder) && report.event == Event::Done {
                break 'done;
            }
            heard.push(report);
        }
    }
    out.join("part-000000")
}

/// A number of a table.
fn number(row: &std::collections::HashMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap()
}

#[test]
fn a_model_of_another_space_is_estimated_compared_recorded_and_reported_by_its_description() {
    let bench = Bench::new();
    let folder = run(&bench);
    let at = |name: &str| format!("results/part-000000/{name}");
    let moments = bench.table(&at("moments.csv"));
    assert_eq!(moments.len(), 2 * TIMES.len());
    for (row, time) in moments.iter().zip(TIMES.iter().cycle()) {
        let is_sampled = row["method"] == "mc";
        let off = |column: &str, right: f64, deviation: f64| {
            let error = if is_sampled { 5.0 * number(row, &format!("se_{column}")) } else { 1e-6 * deviation };
            let difference = number(row, column) - right;
            let difference =
                if column == "mean_psi_rad" { density::angle::nearest(difference, 0.0) } else { difference };
            assert!(difference.abs() <= error, "{column} at {time}: {} instead of {right}", row[column]);
        };
        let deviation = |variance: f64| variance.sqrt();
        off("mean_psi_rad", MEAN[0] + TURNS * time, deviation(COVARIANCE[0]));
        off("mean_r_m", MEAN[1], deviation(COVARIANCE[3]));
        off("mean_z_m", MEAN[2], deviation(COVARIANCE[5]));
        off("std_r_m", deviation(COVARIANCE[3]), deviation(COVARIANCE[3]));
        off("std_z_m", deviation(COVARIANCE[5]), deviation(COVARIANCE[5]));
        off("cov_psi_r", COVARIANCE[1], deviation(COVARIANCE[0] * COVARIANCE[3]));
        off("cov_psi_z", COVARIANCE[2], deviation(COVARIANCE[0] * COVARIANCE[5]));
        off("cov_r_z", COVARIANCE[4], deviation(COVARIANCE[3] * COVARIANCE[5]));
        // One deviation above the mean.
        off("prob_above_critical_z", 0.158_655_253_931_457, 1.0);
        assert!((number(row, "mass_on_grid") - 1.0).abs() < 1e-3, "{row:?}");
    }
    let errors = bench.table(&at("errors.csv"));
    assert!(
        errors.iter().any(|row| row["quantity"] == "cov_psi_z" && row["method"] == "ut" && row["reference"] == "mc")
    );
    let distances = bench.table(&at("distances.csv"));
    for density in ["marginal_r_z", "marginal_psi", "marginal_psi_r", "marginal_z"] {
        let of = distances.iter().filter(|row| row["density"] == density && row["method"] == "ut");
        let variations: Vec<f64> =
            of.filter(|row| row["measure"] == "total_variation").map(|row| number(row, "value")).collect();
        assert_eq!(variations.len(), TIMES.len(), "{density}");
        assert!(variations.iter().all(|v| (1e-4..0.1).contains(v)), "{density}: {variations:?}");
    }
    let effort = bench.table(&at("effort.csv"));
    let trajectories: Vec<f64> = effort.iter().map(|row| number(row, "trajectories")).collect();
    assert_eq!(trajectories, [40_000.0, 7.0], "as the propagators count them");
    let verdicts = bench.table(&at("verdicts.csv"));
    assert_eq!(verdicts.len(), 2, "{verdicts:?}");
    assert!(String::from_utf8(bench.read(&at("scenario.toml"))).unwrap().contains("name = \"rigid-rotation\""));
    let table = launch::report::moments_at(&folder.join("moments.csv"), "turning").to_string();
    assert!(table.contains("μ_psi, rad") && table.contains("σ_z, m") && table.contains("5.00000"), "{table}");
    report(&bench, &folder);
}

/// Makes a results folder of what the recorder has written, as a launcher would, and its report.
fn report(bench: &Bench, part: &Path) {
    std::fs::create_dir(part.join(SCENARIOS)).unwrap();
    std::fs::rename(part.join(SCENARIO), part.join(SCENARIOS).join("turning.toml")).unwrap();
    let case = |label: &str| (label.to_owned(), CaseRecord { runs: vec![label.into()], ..CaseRecord::default() });
    let manifest = Manifest {
        started: "2026-01-01T00:00:00Z".into(),
        reference: "mc".into(),
        cases: ["mc", "ut"].map(case).into(),
        ..Manifest::default()
    };
    results::manifest::write(part, &manifest).unwrap();
    let output = bench.phasecloud().arg("report").arg(part).output().unwrap();
    assert!(output.status.success() && text(&output.stderr).is_empty(), "{}", text(&output.stderr));
    let page = std::fs::read_to_string(part.join("report.html")).unwrap();
    for words in [
        "densities of angle ψ, distance r and height z",
        "initial correlation of angle and height",
        "Critical height",
        "Probability that z exceeds -1.7",
        "total variation, r, z",
        "Kolmogorov, ψ",
    ] {
        assert!(page.contains(words), "{words}");
    }
    // Every projection on two variables has its figures, with the names and units of its variables on the axes.
    for (figure, words) in [
        ("r-z-joint-density-mc-all", ["distance r [m]", "height z [m]", "joint density [1/m²]"]),
        ("psi-r-joint-density-ut-all", ["angle ψ [rad]", "distance r [m]", "joint density [1/(rad·m)]"]),
        ("r-z-joint-density-mc-1", ["r [m]", "z [m]", "density [1/m²]"]),
        ("psi-r-difference-ut-2", ["ψ [rad]", "r [m]", "difference [1/(rad·m)]"]),
        ("psi-r-marginals-ut", ["angle ψ [rad]", "density [1/rad]", "density [1/m]"]),
        ("moment-errors", ["relative error of μψ", "relative error of σr", "relative error of μz"]),
    ] {
        let file = std::fs::read_to_string(part.join(format!("figures/{figure}.svg"))).unwrap();
        let document = roxmltree::Document::parse(&file).unwrap();
        let said = |node: roxmltree::Node<'_, '_>| {
            node.descendants().filter(roxmltree::Node::is_text).filter_map(|n| n.text()).collect::<String>()
        };
        let all: Vec<String> = document.descendants().filter(|node| node.has_tag_name("text")).map(said).collect();
        for words in words {
            assert!(all.iter().any(|text| text == words), "{figure}: {words} is not among {all:?}");
        }
        assert!(!file.contains("eccentricity") && !file.contains('φ'), "{figure}");
    }
    assert!(!part.join("figures/phase-portrait.svg").exists(), "there is no Hamiltonian to draw");
}

#[test]
fn a_built_in_propagator_refuses_a_model_that_it_does_not_know() {
    let (header, items) = scenario().encode().unwrap();
    let assignment = kit::assignment::Assignment::from_parts(&header, &items).unwrap();
    let why = assignment.plane().unwrap_err().to_string();
    assert!(why.contains("model is \"rigid-rotation\", this is for models in the plane alone"), "{why}");
}

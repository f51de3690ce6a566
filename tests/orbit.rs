//! `phasecloud orbit`: its numbers are those of other programs, and it says what it cannot do.
#![allow(missing_docs)]

mod common;

use common::{Bench, text};

/// A table of numbers by column; texts are NaN.
struct Table {
    head: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    fn read(text: &str) -> Self {
        let mut lines = text.lines().map(|line| line.trim_end().split(',').map(str::to_owned));
        let head = lines.next().unwrap().collect();
        let number = |field: String| field.parse().unwrap_or(f64::NAN);
        Self { head, rows: lines.map(|line| line.map(number).collect()).collect() }
    }

    fn column(&self, name: &str) -> Vec<f64> {
        let k = self.head.iter().position(|known| known == name).unwrap_or_else(|| panic!("{name}: {:?}", self.head));
        self.rows.iter().map(|row| row[k]).collect()
    }
}

fn orbit(bench: &Bench, scenario: &str, more: &[&str]) -> std::process::Output {
    bench.write("mine.toml", scenario);
    bench.phasecloud().arg("orbit").arg("mine.toml").args(more).output().unwrap()
}

fn table(bench: &Bench, scenario: &str, more: &[&str]) -> Table {
    let output = orbit(bench, scenario, more);
    assert!(output.status.success(), "{}", text(&output.stderr));
    Table::read(&text(&output.stdout))
}

const FORCES: &str = "forces = [\"srp\", \"j2\", \"sun\", \"moon\"]\n";
const VECTORS: [&str; 6] = ["e1", "e2", "e3", "h1", "h2", "h3"];

/// Runs of rows of a reference table, each of which is one orbit, as scenario files, and how far the command's vectors
/// are from theirs.
fn compare(reference: &str, model: &str, more: &[&str], tolerance: f64) {
    let bench = Bench::new();
    let all = Table::read(reference);
    let lines: Vec<&str> = reference.lines().skip(1).collect();
    let column = |name: &str| all.column(name);
    let times = column("t_yr");
    let mut first = 0;
    while first < times.len() {
        let after = (first + 1..times.len()).find(|&k| times[k] <= times[k - 1]).unwrap_or(times.len());
        let of = |name: &str| column(name)[first];
        let third_bodies = lines[first].contains("sun+moon");
        let mut scenario =
            format!("name = \"orbit\"\n[model]\nname = \"{model}\"\nobliquity = \"{} deg\"\n", of("obliquity_deg"));
        if third_bodies {
            scenario += FORCES;
        }
        scenario += &format!("[epoch]\nsun_longitude = \"{} deg\"\n", of("lambda_sun0_deg"));
        if third_bodies && model == "osculating" {
            scenario += &format!("moon_longitude = \"{} deg\"\n", of("lambda_moon0_deg"));
        }
        scenario += &format!(
            "[orbit]\nsemi_major_axis = {:?}\nradiation = {:?}\n[initial]\ne = {:?}\ninclination = \"{} deg\"\nnode = \"{} deg\"\n\
             argument_of_pericentre = \"{} deg\"\n",
            of("a_earth_radii"),
            of("C"),
            of("e0"),
            of("inclination0_deg"),
            of("node0_deg"),
            of("argument_of_pericentre0_deg")
        );
        if model == "osculating" {
            scenario += &format!("mean_anomaly = \"{} deg\"\n", of("mean_anomaly0_deg"));
        }
        scenario += &format!("[times]\nat = {:?}\n", [&[0.0], &times[first..after]].concat());
        let found = table(&bench, &scenario, more);
        assert_eq!(found.rows.len(), after - first + 1);
        for name in VECTORS {
            for (found, expected) in found.column(name)[1..].iter().zip(&column(name)[first..after]) {
                assert!((found - expected).abs() < tolerance, "{name}, row {first}: {found} {expected}");
            }
        }
        first = after;
    }
}

#[test]
fn averaged_orbits_in_space_are_those_of_the_reference_to_1e_10() {
    compare(include_str!("../density/tests/reference/vectorial-states.csv"), "vectorial", &[], 1e-10);
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn unaveraged_orbits_are_those_of_the_reference_to_1e_6() {
    let reference = include_str!("../density/tests/reference/osculating-states.csv");
    // The first three orbits: each takes seconds.
    let few: Vec<&str> = reference.lines().take(1 + 9).collect();
    compare(&few.join("\n"), "osculating", &["--osculating"], 1e-6);
}

const VECTORIAL: &str = include_str!("../launch/models/vectorial.toml");
const OSCULATING: &str = include_str!("../launch/models/osculating.toml");
const PLANAR: &str = include_str!("../launch/models/planar.toml");

#[test]
fn in_the_plane_without_obliquity_the_models_print_the_same_orbit() {
    let bench = Bench::new();
    let planar = table(&bench, &PLANAR.replace("[orbit]", &format!("[model]\n{FORCES}[orbit]")), &["--step", "0.25"]);
    let flat = VECTORIAL.replace("name = \"vectorial\"\nforces", "name = \"vectorial\"\nobliquity = 0.0\nforces");
    assert_ne!(flat, VECTORIAL);
    let in_space = table(&bench, &flat, &["--step", "0.25"]);
    assert_eq!(planar.rows.len(), 9);
    for name in [&VECTORS[..], &["t_yr", "phi_rad", "e", "a_earth_radii"]].concat() {
        for (planar, in_space) in planar.column(name).iter().zip(in_space.column(name)) {
            assert!((planar - in_space).abs() < 1e-10, "{name}: {planar} {in_space}");
        }
    }
}

#[test]
fn the_mean_of_an_unaveraged_orbit_follows_the_averaged_one() {
    let bench = Bench::new();
    let short = |scenario: &str| scenario.replace("end = 2.0\nstep = 0.5", "end = 0.2\nstep = 0.1");
    let (mean, averaged) = (table(&bench, &short(OSCULATING), &[]), table(&bench, &short(VECTORIAL), &[]));
    let osculating = table(&bench, &short(OSCULATING), &["--osculating"]);
    assert_eq!(osculating.head[1..6], ["phi_rad", "e", "i_rad", "node_rad", "M_rad"].map(str::to_owned));
    for name in VECTORS {
        for (mean, averaged) in mean.column(name).iter().zip(averaged.column(name)) {
            assert!((mean - averaged).abs() < 3e-3, "{name}: {mean} {averaged}");
        }
    }
    assert!(mean.column("a_earth_radii").iter().all(|a| (a - 2.5).abs() < 1e-3));
}

/// The elements of a position and a velocity follow from its energy and its eccentricity vector.
#[test]
fn an_ephemeris_has_the_positions_of_the_osculating_elements() {
    const MU: f64 = 398_600.441_8; // km³/s²
    const RADIUS: f64 = 6378.137; // km
    let bench = Bench::new();
    let dated = OSCULATING.replace("[epoch]\n", "[epoch]\ndate = 2027-03-01\n");
    let step = ["--step", "0.03125"]; // a thirty-second of a sidereal year: 11 d 9 h 56 min 32.1801 s
    let elements = table(&bench, &dated, &["--osculating", step[0], step[1]]);
    let output = orbit(&bench, &dated, &["--oem", step[0], step[1]]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let printed = text(&output.stdout);
    assert!(printed.starts_with("CCSDS_OEM_VERS = 3.0\n"), "{printed}");
    assert!(printed.contains("\nSTART_TIME = 2027-03-01T00:00:00.000000\n"), "{printed}");
    let states: Vec<Vec<&str>> =
        printed.lines().filter(|line| line.starts_with("202")).map(|line| line.split(' ').collect()).collect();
    let (axis, vectors) = (elements.column("a_earth_radii"), ["e1", "e2", "e3"].map(|name| elements.column(name)));
    assert_eq!((states.len(), states[1][0]), (axis.len(), "2027-03-12T09:56:32.180100"));
    let mut eccentric = 0.0_f64;
    for (k, state) in states.iter().enumerate() {
        let numbers: Vec<f64> = state[1..].iter().map(|number| number.parse().unwrap()).collect();
        let (r, v): ([f64; 3], [f64; 3]) = (numbers[..3].try_into().unwrap(), numbers[3..].try_into().unwrap());
        let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (distance, square) = (dot(r, r).sqrt(), dot(v, v));
        let found = 1.0 / (2.0 / distance - square / MU) / RADIUS;
        assert!((found - axis[k]).abs() < 1e-9, "{found} {}", axis[k]);
        for (i, expected) in vectors.iter().enumerate() {
            let e = ((square - MU / distance) * r[i] - dot(r, v) * v[i]) / MU;
            assert!((e - expected[k]).abs() < 1e-9, "{e} {}", expected[k]);
            eccentric = eccentric.max(e.abs());
        }
    }
    assert!(eccentric > 0.1);
}

#[test]
fn what_cannot_be_done_is_refused_in_words() {
    let bench = Bench::new();
    let refused = |scenario: &str, more: &[&str], words: &str| {
        let output = orbit(&bench, scenario, more);
        assert_eq!(output.status.code(), Some(2), "{}", text(&output.stdout));
        assert!(text(&output.stderr).contains(words), "{words}: {}", text(&output.stderr));
    };
    refused(VECTORIAL, &["--osculating"], "only the model \"osculating\" has osculating elements");
    refused(VECTORIAL, &["--oem"], "only the model \"osculating\" says where on its orbit the satellite is");
    refused(OSCULATING, &["--oem"], "mine.toml: epoch: --oem needs the date at t = 0");
    refused(VECTORIAL, &["--step", "0"], "--step: 0 is not allowed");
    refused(VECTORIAL, &["--step", "3"], "--step: 3 is not allowed, it must be between");
    refused(&VECTORIAL.replace("e = 0.145", "e = 1.5"), &[], "initial.e: 1.5 is not allowed");
    for command in ["ask", "validate"] {
        bench.write("mine.toml", VECTORIAL);
        let output = bench.phasecloud().args([command, "mine.toml"]).output().unwrap();
        let said = text(&output.stdout) + &text(&output.stderr);
        match command {
            "ask" => assert!(said.contains("disposal: must have critical_e or altitude"), "{said}"),
            _ => assert!(output.status.success() && said.contains("model vectorial: C = 0.15"), "{said}"),
        }
    }
    let launch = "name = \"l\"\nscenarios = [\"mine.toml\"]\nreference = \"exact\"\n[[propagator]]\nlabel = \"exact\"\nnode = \"exact\"\n";
    bench.write("launch.toml", launch);
    let output = bench.phasecloud().args(["run", "launch.toml"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("disposal: must have critical_e or altitude"), "{}", text(&output.stderr));
}

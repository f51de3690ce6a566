//! The Earth's shadow through real processes: it is sampled, compared and printed, and refused by name where a
//! Hamiltonian is needed.
#![allow(missing_docs)]

mod common;

use common::{Bench, text};

const PLANAR: &str = "name = \"mine\"\n[model]\nforces = [\"srp\", \"j2\", \"shadow\"]\n[orbit]\nsemi_major_axis = 2.5\nradiation = 0.15\n\
    [initial]\nphi = 2.2069\ne = 0.145\nsigma_phi = 0.1\nsigma_e = 0.02\n[times]\nat = [0.0, 0.2, 0.4]\n[disposal]\naltitude = 1500\n";

fn launch(cases: &[(&str, &str)]) -> String {
    let case = |(label, settings): &(&str, &str)| format!("[[propagator]]\nlabel = \"{label}\"\n{settings}\n");
    let head = "name = \"l\"\nscenarios = [\"mine.toml\"]\nreference = \"qmc\"\nbins = [20, 16]\naccuracy = 1e-9\n";
    head.to_owned() + &cases.iter().map(case).collect::<String>()
}

#[test]
fn a_cloud_that_passes_the_shadow_is_sampled_in_two_ways_that_agree_and_without_the_shadow_is_another() {
    let bench = Bench::new();
    bench.write("mine.toml", PLANAR);
    let cases = [
        ("qmc", "node = \"qmc\"\nsamples = 512\nreplicates = 8"),
        ("mc", "node = \"mc\"\nsamples = 800\nseed = 3"),
        ("lit", "node = \"qmc\"\nsamples = 512\nreplicates = 8\nforces = [\"srp\", \"j2\"]"),
        ("plane", "node = \"qmc\"\nsamples = 512\nreplicates = 8\nmodel = \"planar\""),
    ];
    bench.run_well(&bench.write("launch.toml", &launch(&cases)), "out");
    let rows = bench.table("out/moments.csv");
    let value = |method: &str, key: &str| -> f64 {
        let row = rows.iter().find(|row| row["method"] == method && row["t_yr"] == "0.4").unwrap();
        row[key].parse().unwrap_or(f64::NAN)
    };
    for key in ["mean_phi_rad", "mean_e", "std_e"] {
        let error = value("mc", &format!("se_{key}")).hypot(value("qmc", &format!("se_{key}")));
        assert!((value("mc", key) - value("qmc", key)).abs() < 5.0 * error, "{key}");
        // The plane is the plane in either model, and the orbits are the same.
        assert!((value("plane", key) - value("qmc", key)).abs() < 1e-8, "{key}");
    }
    assert_eq!(value("qmc", "mean_i_rad"), 0.0);
    assert!((value("lit", "mean_e") - value("qmc", "mean_e")).abs() > 1e-3, "the shadow is worth more than that");
    let passages = bench.table("out/first_passage.csv");
    let reached = |time: &str| -> Vec<f64> {
        let rows = passages.iter().filter(|row| row["method"] == "qmc" && row["t_yr"] == time);
        rows.map(|row| row["prob_reached_critical_e"].parse().unwrap()).collect()
    };
    assert_eq!(reached("0.0"), [0.0], "no orbit re-enters at once");
    assert!(reached("0.4").iter().all(|reached| *reached < 0.5), "{:?}", reached("0.4"));
    // What was run can be run again from its folder.
    let output = bench.phasecloud().args(["validate", "out/scenarios/mine.toml"]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&bench.read("out/scenarios/mine.toml")).contains("\"shadow\""));
}

#[test]
fn what_cannot_follow_the_shadow_refuses_it_by_name() {
    let bench = Bench::new();
    bench.write("mine.toml", PLANAR);
    let cases = [
        ("qmc", "node = \"qmc\"\nsamples = 64\nreplicates = 4"),
        ("exact", "node = \"exact\""),
        ("map", "node = \"mc\"\nsamples = 100\nthrough = \"flow-map\""),
        ("none", "node = \"mc\"\nsamples = 100\nforces = [\"srp\", \"sun\"]"),
    ];
    let output = bench.run(&bench.write("launch.toml", &launch(&cases)), "out");
    assert_eq!(output.status.code(), Some(1));
    let told = text(&output.stderr) + &text(&output.stdout);
    for words in [
        "exact: the scenario's model is \"planar\" with the Earth's shadow",
        "map: model.forces: \"shadow\" makes the semi-major axis a variable",
        "none: forces: \"sun\" does not act in the scenario",
    ] {
        assert!(told.contains(words), "{words}: {told}");
    }
    let output = bench.phasecloud().args(["ask", "mine.toml"]).output().unwrap();
    assert!(
        text(&output.stderr).contains("mine.toml: model.forces: \"shadow\" makes the semi-major axis a variable"),
        "{}",
        text(&output.stderr)
    );
}

#[test]
fn the_semi_major_axis_of_averaged_and_unaveraged_orbits_changes_alike() {
    let bench = Bench::new();
    let axis = |model: &str| -> Vec<f64> {
        let scenario = match model {
            "vectorial" => include_str!("../launch/models/vectorial-shadow.toml"),
            _ => include_str!("../launch/models/osculating-shadow.toml"),
        };
        bench.write("orbit.toml", &scenario.replace("end = 2.0\nstep = 0.5", "end = 0.3\nstep = 0.15"));
        let output = bench.phasecloud().args(["orbit", "orbit.toml"]).output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        let text = text(&output.stdout);
        text.lines().skip(1).map(|line| line.rsplit(',').next().unwrap().trim().parse().unwrap()).collect()
    };
    let (averaged, mean) = (axis("vectorial"), axis("osculating"));
    assert!(averaged.iter().zip(&mean).all(|(a, b)| (a - b).abs() < 2e-3), "{averaged:?} {mean:?}");
    assert!(averaged.last().is_some_and(|last| (last - 2.5).abs() > 1e-2), "{averaged:?}");
}

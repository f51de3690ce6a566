//! A scenario in space goes through real processes: its cloud is sampled in its own model and in simpler ones,
//! estimated, compared and recorded.
#![allow(missing_docs)]

mod common;

use std::collections::HashMap;

use common::service::{end, start, submit};
use common::{Bench, REPRODUCIBLE, text};

const VECTORIAL: &str = "name = \"mine\"\n[model]\nname = \"vectorial\"\nforces = [\"srp\", \"j2\", \"sun\", \"moon\"]\n\
    [epoch]\nsun_longitude = \"57 deg\"\n[orbit]\nsemi_major_axis = 2.5\nradiation = 0.15\n\
    [initial]\nphi = 2.2069\ne = 0.145\ninclination = \"1 deg\"\nnode = \"50 deg\"\nsigma_phi = 0.1\nsigma_e = 0.02\n\
    sigma_inclination = \"1 deg\"\nsigma_node = 0.2\nsigma_radiation = 0.05\n[initial.correlation]\nphi_node = 0.5\ne_inclination = -0.3\n\
    [times]\nat = [0.0, 0.3, 0.5]\n[disposal]\ncritical_e = 0.53\n";

fn case(label: &str, settings: &str) -> String {
    format!("[[propagator]]\nlabel = \"{label}\"\n{settings}\n")
}

fn launch(reference: &str, cases: &[String]) -> String {
    let head = format!("name = \"l\"\nscenarios = [\"mine.toml\"]\nreference = \"{reference}\"\nbins = [20, 16]\n");
    head + &cases.concat()
}

type Row = HashMap<String, String>;

fn row<'a>(rows: &'a [Row], method: &str, time: &str) -> &'a Row {
    rows.iter().find(|row| row["method"] == method && row["t_yr"] == time).unwrap()
}

fn number(row: &Row, key: &str) -> f64 {
    row[key].parse().unwrap_or(f64::NAN)
}

const VARIABLES: [&str; 5] = ["phi_rad", "e", "i_rad", "node_rad", "C"];

#[test]
fn a_cloud_in_space_is_sampled_in_two_ways_that_agree_and_in_the_plane_which_says_nothing_of_inclination() {
    let bench = Bench::new();
    bench.write("mine.toml", VECTORIAL);
    let cases = [
        case("qmc", "node = \"qmc\"\nsamples = 8_192"),
        case("mc", "node = \"mc\"\nsamples = 20_000\nseed = 5"),
        case("planar", "node = \"qmc\"\nsamples = 8_192\nmodel = \"planar\""),
    ];
    bench.run_well(&bench.write("launch.toml", &launch("qmc", &cases)), "out");
    let rows = bench.table("out/moments.csv");
    for time in ["0.0", "0.3", "0.5"] {
        let [qmc, mc, planar] = ["qmc", "mc", "planar"].map(|method| row(&rows, method, time));
        for variable in VARIABLES {
            for key in [format!("mean_{variable}"), format!("std_{variable}")] {
                let (a, b) = (number(qmc, &key), number(mc, &key));
                let error = number(qmc, &format!("se_{key}")).hypot(number(mc, &format!("se_{key}")));
                let apart = if key.contains("_rad") { density::angle::nearest(a - b, 0.0) } else { a - b };
                assert!(apart.abs() < 5.0 * error, "{key} at {time}: {a} {b} ± {error}");
                // Nodes on both sides of the circle make their moments depend on where it is cut.
                let is_smooth = variable == "phi_rad" || variable == "e";
                let [ours, theirs] = [qmc, mc].map(|row| number(row, &format!("se_{key}")));
                assert!(!is_smooth || ours < 0.5 * theirs, "{key} at {time}: {ours} {theirs}");
                let is_in_plane = !variable.starts_with('i') && !variable.starts_with("node");
                assert_eq!(number(planar, &key).is_finite(), is_in_plane, "{key} of the planar model");
            }
        }
        assert!(number(mc, "mass_on_grid") > 0.99 && number(planar, "mean_i_rad").is_nan());
    }
    let last = row(&rows, "qmc", "0.5");
    let above = number(last, "prob_above_critical_e");
    assert!((0.05..0.95).contains(&above), "{above}");
    let passages = bench.table("out/first_passage.csv");
    let of = |method: &str| passages.iter().rfind(|row| row["method"] == method).unwrap();
    let (qmc, mc) = (of("qmc"), of("mc"));
    assert_eq!((qmc["interval"].as_str(), mc["interval"].as_str()), ("95 %", "95 %"));
    let width = |row: &Row| number(row, "high") - number(row, "low");
    assert!(width(qmc) < width(mc) && width(qmc) > 0.0);
    assert!((number(qmc, "prob_reached_critical_e") - number(mc, "prob_reached_critical_e")).abs() < width(mc));
    let distances = bench.table("out/distances.csv");
    let densities = |method: &str| {
        let own = distances.iter().filter(|row| row["method"] == method && row["t_yr"] == "0.5");
        own.filter(|row| row["measure"] == "total_variation").map(|row| row["density"].clone()).collect::<Vec<_>>()
    };
    let all = ["marginal_phi_e", "marginal_phi", "marginal_e", "marginal_e_i", "marginal_i", "marginal_node"];
    assert_eq!(
        (densities("mc"), densities("planar")),
        (all.map(String::from).into(), all[..3].iter().copied().map(String::from).collect())
    );
    let verdicts = bench.table("out/verdicts.csv");
    assert!(verdicts.iter().all(|row| !row["moments_judged_by"].contains("withheld")), "{verdicts:?}");
    assert!(
        bench.path("out/figures/e-i-marginals-mc.svg").exists()
            && bench.path("out/figures/phi-e-difference-planar-2.svg").exists()
    );
    assert!(!bench.path("out/figures/e-i-difference-planar-2.svg").exists(), "the planar model has no inclination");
    // What was run can be run again from its folder.
    let output = bench.phasecloud().args(["validate", "out/scenarios/mine.toml"]).output().unwrap();
    assert!(text(&output.stdout).contains("a cloud over phi, e, i, node, C"), "{}", text(&output.stdout));
}

#[test]
fn results_in_space_are_the_same_bytes_in_shards() {
    let bench = Bench::new();
    bench.write("mine.toml", VECTORIAL);
    let cases = |split: &str| {
        [
            case("mc", &format!("node = \"mc\"\nsamples = 3_001\n{split}")),
            case("sobol", &format!("node = \"mc\"\nsamples = 4_096\ndraws = \"sobol\"\nreplicates = 8\n{split}")),
        ]
    };
    bench.run_well(&bench.write("whole.toml", &launch("mc", &cases(""))), "whole");
    bench.run_well(&bench.write("parts.toml", &launch("mc", &cases("shards = 3"))), "parts");
    for file in REPRODUCIBLE {
        assert!(bench.read(&format!("whole/{file}")) == bench.read(&format!("parts/{file}")), "{file} differs");
    }
}

#[test]
fn unaveraged_orbits_are_read_out_as_averages_and_stay_near_the_averaged_model() {
    let bench = Bench::new();
    let scenario = VECTORIAL
        .replace("\"vectorial\"", "\"osculating\"")
        .replace("\"57 deg\"", "\"57 deg\"\nmoon_longitude = 1.0")
        .replace("[0.0, 0.3, 0.5]", "[0.0, 0.1]");
    bench.write("mine.toml", &scenario);
    let cases = [
        case("osculating", "node = \"qmc\"\nsamples = 32\nreplicates = 4\naccuracy = 1e-9"),
        case("vectorial", "node = \"qmc\"\nsamples = 32\nreplicates = 4\nmodel = \"vectorial\""),
    ];
    bench.run_well(&bench.write("launch.toml", &launch("osculating", &cases)), "out");
    let rows = bench.table("out/moments.csv");
    for time in ["0.0", "0.1"] {
        let (full, averaged) = (row(&rows, "osculating", time), row(&rows, "vectorial", time));
        for (variable, near) in [("phi_rad", 1e-2), ("e", 2e-3), ("i_rad", 1e-3)] {
            let key = format!("mean_{variable}");
            assert!((number(full, &key) - number(averaged, &key)).abs() < near, "{key} at {time}");
        }
        assert_ne!(full["mean_e"], averaged["mean_e"], "they are two models");
    }
}

#[test]
fn what_a_method_cannot_do_in_space_it_refuses_by_name() {
    let bench = Bench::new();
    bench.write("mine.toml", VECTORIAL);
    let cases = [
        case("mc", "node = \"mc\"\nsamples = 1_000"),
        case("exact", "node = \"exact\""),
        case("dee", "node = \"dee\"\nplacement = \"random\""),
        case("gmm", "node = \"gmm-ut\"\nsplit = \"solar-angle\""),
        case("full", "node = \"mc\"\nsamples = 1_000\nmodel = \"osculating\""),
    ];
    let output = bench.run(&bench.write("launch.toml", &launch("mc", &cases)), "out");
    assert_eq!(output.status.code(), Some(1));
    let told = text(&output.stderr) + &text(&output.stdout);
    for words in [
        "exact: the scenario's model is \"vectorial\"",
        "placement: in space dee reads out the flow",
        "in space, gmm-ut takes split = \"adaptive\"",
        "does not say where the Moon is",
    ] {
        assert!(told.contains(words), "{words}: {told}");
    }
    let planar = launch("mc", &[case("mc", "node = \"mc\"\nsamples = 100\nmodel = \"vectorial\"")]);
    let path = bench.write("planar.toml", &planar.replace("mine.toml", "scenario-1.toml"));
    let told = text(&bench.run(&path, "none").stderr);
    assert!(told.contains("a case may have a simpler one, which \"vectorial\" is not"), "{told}");
}

#[test]
fn a_scenario_file_in_space_is_refused_at_the_key_that_makes_a_cloud_impossible() {
    let bench = Bench::new();
    let launch = bench.write("launch.toml", &launch("mc", &[case("mc", "node = \"mc\"\nsamples = 100")]));
    let refused = |from: &str, to: &str, words: &str| {
        assert!(VECTORIAL.contains(from), "{from}");
        bench.write("mine.toml", &VECTORIAL.replacen(from, to, 1));
        let output = bench.run(&launch, "none");
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains(words), "{words}: {}", text(&output.stderr));
    };
    refused("sigma_phi = 0.1\n", "", "mine.toml:10: initial: must have sigma_phi");
    refused("[disposal]\ncritical_e = 0.53\n", "", "disposal: must have critical_e or altitude");
    refused("sigma_e = 0.02", "sigma_e = 0.7", "initial.sigma_e: 0.7 is not allowed");
    refused("e_inclination = -0.3", "e_inclination = -1.3", "initial.correlation.e_inclination: -1.3 is not allowed");
    refused("sigma_node = 0.2\n", "", "initial.correlation.phi_node: is a correlation with a variable that is certain");
    refused(
        "phi_node = 0.5",
        "phi_e = 0.9\nphi_inclination = 0.9",
        "initial.correlation: no Gaussian has all these correlations",
    );
    refused("inclination = \"1 deg\"", "inclination = \"176 deg\"", "the solar angle is singular");
}

#[test]
fn a_service_takes_a_scenario_in_space_and_writes_the_same_results_as_a_run() {
    let bench = Bench::new();
    let file = bench.write("mine.toml", VECTORIAL);
    let launch = bench.write("launch.toml", &launch("mc", &[case("mc", "node = \"mc\"\nsamples = 500")]));
    bench.run_well(&launch, "run");
    let service = start(&bench, &launch);
    let output = submit(&bench, &file);
    assert_eq!(end(service), Some(0));
    assert!(output.status.success(), "{}", text(&output.stderr));
    // A correlation travels as a covariance, which rounds it.
    let (ran, served) = (bench.table("run/moments.csv"), bench.table("served/000000-mine/moments.csv"));
    assert_eq!((ran.len(), served.len()), (3, 3));
    for (ran, served) in ran.iter().zip(&served) {
        for variable in VARIABLES {
            let key = format!("mean_{variable}");
            assert!((number(ran, &key) - number(served, &key)).abs() < 1e-9, "{key}");
        }
    }
    // The text that the recorder wrote from the message is a scenario file again.
    let output = bench.phasecloud().args(["validate", "served/000000-mine/scenarios/mine.toml"]).output().unwrap();
    assert!(text(&output.stdout).contains("a cloud over phi, e, i, node, C"), "{}", text(&output.stderr));
}

#[test]
fn fidelity_prints_how_far_every_simpler_model_and_every_force_moves_the_figures() {
    let bench = Bench::new();
    bench.write("mine.toml", VECTORIAL);
    let output = bench.phasecloud().args(["fidelity", "--orbits", "64", "--csv", "mine.toml"]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    let shift = |start: &str| {
        let line = said.lines().find(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{start}: {said}"));
        let numbers: Vec<f64> = line.rsplit(',').take(2).map(|field| field.parse().unwrap()).collect();
        (numbers[1], numbers[0])
    };
    let (planar, error) = shift("planar,vectorial,0.5,mean_e,");
    assert!(planar.abs() > 10.0 * error && planar.abs() < 0.1, "{planar} ± {error}");
    for force in ["srp", "j2", "sun", "moon"] {
        assert!(shift(&format!("vectorial without {force},vectorial,0.5,mean_phi,")).0 != 0.0);
        assert_eq!(
            shift(&format!("vectorial without {force},vectorial,0,mean_e,")),
            (0.0, 0.0),
            "nothing has acted yet"
        );
    }
    assert!(!said.contains("planar,vectorial,0.5,mean_i,"), "the planar model has no inclination");
    bench.write("flat.toml", common::SCENARIO_1);
    let output = bench.phasecloud().args(["fidelity", "flat.toml"]).output().unwrap();
    assert!(output.status.code() == Some(2) && text(&output.stderr).contains("the simplest model"));
}

#[test]
fn a_mixture_and_characteristics_in_space_have_the_moments_of_quasi_monte_carlo() {
    let bench = Bench::new();
    bench.write("mine.toml", &VECTORIAL.replace("inclination = \"1 deg\"\nnode", "inclination = \"10 deg\"\nnode"));
    let cases = [
        case("qmc", "node = \"qmc\"\nsamples = 16_384"),
        case("gmm", "node = \"gmm-ut\"\nsigma_points = 600"),
        case("dee", "node = \"dee\"\nsamples = 100_000\naccuracy = 1e-9"),
    ];
    bench.run_well(&bench.write("launch.toml", &launch("qmc", &cases)), "out");
    let rows = bench.table("out/moments.csv");
    for (method, allowed) in [("gmm", 0.005), ("dee", 0.001)] {
        for time in ["0.0", "0.3", "0.5"] {
            let [found, right] = [method, "qmc"].map(|method| row(&rows, method, time));
            for variable in VARIABLES {
                let deviation = number(right, &format!("std_{variable}"));
                for key in [format!("mean_{variable}"), format!("std_{variable}")] {
                    let apart = number(found, &key) - number(right, &key);
                    let apart = if key.contains("_rad") { density::angle::nearest(apart, 0.0) } else { apart };
                    let of = |row: &Row| number(row, &format!("se_{key}"));
                    let error = of(right).hypot(if method == "dee" { of(found) } else { 0.0 });
                    let beyond = apart.abs() - 3.0 * error;
                    assert!(beyond < allowed * deviation, "{method}: {key} at {time}: {apart} {error} {deviation}");
                }
            }
            let distances = bench.table("out/distances.csv");
            let is_here =
                |row: &&Row| row["method"] == method && row["t_yr"] == time && row["measure"] == "total_variation";
            for row in distances.iter().filter(is_here) {
                let distance: f64 = row["value"].parse().unwrap();
                assert!(distance < 0.05, "{method}: {row:?}");
            }
        }
    }
}

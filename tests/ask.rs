//! `phasecloud ask`: its numbers are those of a run, and it says what it cannot say.
#![allow(missing_docs)]

mod common;

use common::{Bench, text};
use serde_json::Value;

const SATELLITE: &str = "name = \"mine\"\n[orbit]\naltitude = 9567.2055\narea_to_mass = 12.0\nreflectivity = 1.3\n\
    [initial]\nphi = \"126 deg\"\ne = 0.145\nsigma_phi = \"11 deg\"\nsigma_e = 0.025\n[times]\nend = 4.0\nstep = 1.0\n\
    [disposal]\naltitude = \"120 km\"\n";

fn ask(bench: &Bench, scenario: &str, more: &[&str]) -> std::process::Output {
    bench.write("mine.toml", scenario);
    bench.phasecloud().arg("ask").arg("mine.toml").args(more).output().unwrap()
}

fn answer(bench: &Bench, scenario: &str) -> Value {
    let output = ask(bench, scenario, &["--json"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_str(&text(&output.stdout)).unwrap()
}

#[test]
fn the_probabilities_are_those_of_a_run_and_the_times_and_factors_fit_to_them() {
    let bench = Bench::new();
    let answer = answer(&bench, SATELLITE);
    let launch = "name = \"l\"\nscenarios = [\"mine.toml\"]\nreference = \"exact\"\n[[propagator]]\nlabel = \"exact\"\nnode = \"exact\"\n";
    bench.run_well(&bench.write("launch.toml", launch), "out");
    let curve = answer["curve"].as_array().unwrap();
    for row in bench.table("out/first_passage.csv").iter().filter(|row| row["t_yr"] == "2.0" || row["t_yr"] == "4.0") {
        let (time, probability): (f64, f64) =
            (row["t_yr"].parse().unwrap(), row["prob_reached_critical_e"].parse().unwrap());
        let asked = curve.iter().find(|point| point["t_yr"] == time).unwrap()["probability"].as_f64().unwrap();
        assert!((asked - probability).abs() < 1e-7, "{time}: {asked} {probability}");
    }
    let derived = &answer["derived"];
    assert!((derived["critical_e"].as_f64().unwrap() - 0.592_474).abs() < 1e-6, "{derived}");
    assert!((derived["parameters"]["oblateness"].as_f64().unwrap() - 0.409_204).abs() < 1e-6, "{derived}");
    for reached in answer["reached"].as_array().unwrap() {
        let (wanted, time) = (reached["probability"].as_f64().unwrap(), reached["t_yr"].as_f64());
        let reached_by_end = curve.last().unwrap()["probability"].as_f64().unwrap() >= wanted;
        assert_eq!(time.is_some(), reached_by_end, "{reached}");
        let factor = reached["radiation_factor"].as_f64();
        assert!(
            factor.is_none_or(|factor| (factor > 1.0) != reached_by_end || (factor - 1.0).abs() < 1e-3),
            "{reached}"
        );
    }
}

#[test]
fn it_prints_tables_that_name_the_method_and_the_model() {
    let bench = Bench::new();
    let output = ask(&bench, SATELLITE, &[]);
    let said = text(&output.stdout);
    for words in [
        "probability of re-entry",
        "90 %",
        "effect on the probability by 4 yr",
        "exact first-passage curve",
        "without Earth's shadow",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn a_model_that_the_exact_method_cannot_do_and_a_bad_file_are_refused_in_words() {
    let bench = Bench::new();
    let forces = "[model]\nforces = [\"srp\", \"j2\", \"sun\"]\n[orbit]\nradiation = 0.001\noblateness = 0.4\nsun = 0.01\n[initial]";
    let start = SATELLITE.find("[orbit]").unwrap();
    let end = SATELLITE.find("[initial]").unwrap();
    let weak = format!("{}{forces}{}", &SATELLITE[..start], &SATELLITE[end + 9..])
        .replace("altitude = \"120 km\"", "critical_e = 0.6");
    let output = ask(&bench, &weak, &[]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stdout));
    assert!(text(&output.stderr).contains("mine.toml"), "{}", text(&output.stderr));
    let output = ask(&bench, &SATELLITE.replace("126 deg", "126 grad"), &[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text(&output.stderr).contains("mine.toml:7: initial.phi: \"126 grad\" is not allowed"),
        "{}",
        text(&output.stderr)
    );
}

#[test]
fn validate_prints_what_follows_from_a_scenario() {
    let bench = Bench::new();
    bench.write("mine.toml", SATELLITE);
    let output = bench.phasecloud().args(["validate", "mine.toml"]).output().unwrap();
    let said = text(&output.stdout);
    for words in [
        "good, scenario mine with 5 snapshots to 4 yr",
        "W = 0.409204",
        "critical eccentricity 0.592474",
        "a circular orbit reaches it from C = ",
        "sub-domain",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

/// The paper's scenario 3: e reaches 0.6 with a probability of 4.6e-7 within two years.
const RARE: &str = "name = \"rare\"\n[orbit]\nradiation = 0.15\noblateness = 0.40921\n[initial]\nphi = 0.3004\ne = 0.23\n\
    delta_phi = 0.09817477042468103\ndelta_e = 0.02\n[times]\nend = 2.0\nstep = 0.5\n[disposal]\ncritical_e = 0.6\n";

#[test]
fn a_rare_event_is_estimated_with_an_interval_and_the_exact_probability_stands_beside_it() {
    let bench = Bench::new();
    let output = ask(&bench, RARE, &["--rare", "--json"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let answer: Value = serde_json::from_str(&text(&output.stdout)).unwrap();
    for event in answer["rare"].as_array().unwrap() {
        let exact = event["exact"]["probability"].as_f64().unwrap();
        assert!((exact / 4.59e-7 - 1.0).abs() < 0.01, "{event}");
        for (method, widest) in [("importance_sampling", 0.1), ("subset_simulation", 1.0)] {
            let of = |key: &str| event[method][key].as_f64().unwrap();
            let off = (of("probability") / exact).ln().abs() * of("probability") / of("standard_error");
            assert!(off < 4.0 && of("standard_error") < widest * of("probability"), "{method}: {event}");
            assert!(of("low") < of("probability") && of("probability") < of("high"), "{event}");
        }
    }
}

#[test]
fn a_number_of_orbits_that_cannot_be_taken_and_a_seed_without_effect_are_bad_input() {
    let bench = Bench::new();
    let range = "it must be a whole number from 1000 to 10000000";
    for (arguments, why) in [
        (&["--rare", "100"][..], range),
        (&["--rare=99999999999"], range),
        (&["--rare", "1e4"], range),
        (&["--rare", "scenario.toml"], "write --rare after the scenario file"),
        (&["--seed", "3"], "--seed has no effect without --rare"),
    ] {
        let output = ask(&bench, RARE, arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(text(&output.stderr).contains(why), "{arguments:?}: {}", text(&output.stderr));
    }
}

#[test]
fn a_small_probability_is_printed_with_its_digits() {
    let bench = Bench::new();
    let output = ask(&bench, RARE, &[]);
    assert!(text(&output.stdout).contains("4.591e-7 ± "), "{}", text(&output.stdout));
}

const IN_SPACE: &str = "name = \"mine\"\n[model]\nname = \"vectorial\"\nforces = [\"srp\", \"j2\", \"sun\", \"moon\"]\n\
    [epoch]\nsun_longitude = 0.0\n[orbit]\nsemi_major_axis = 2.5\nradiation = 0.105\n\
    [initial]\nphi = 2.2069\ne = 0.145\ninclination = \"5 deg\"\nnode = \"40 deg\"\nsigma_phi = 0.1\nsigma_e = 0.0125\n\
    sigma_inclination = \"0.5 deg\"\nsigma_node = \"5 deg\"\nsigma_radiation = 0.03\n[initial.correlation]\nphi_node = 0.5\n\
    [times]\nend = 2.0\nstep = 1.0\n[disposal]\naltitude = 120\n";

#[test]
fn in_space_every_figure_has_an_interval_and_the_probabilities_are_those_of_a_run() {
    let bench = Bench::new();
    let answer = answer(&bench, IN_SPACE);
    assert_eq!((answer["method"].as_str(), answer["derived"]["model"].as_str()), (Some("qmc"), Some("vectorial")));
    let launch = "name = \"l\"\nscenarios = [\"mine.toml\"]\nreference = \"qmc\"\n[[propagator]]\nlabel = \"qmc\"\nnode = \"qmc\"\nsamples = 16_384\nseed = 3\n";
    bench.run_well(&bench.write("launch.toml", launch), "out");
    let rows = bench.table("out/first_passage.csv");
    let number = |row: &std::collections::HashMap<String, String>, key: &str| row[key].parse::<f64>().unwrap();
    for point in answer["curve"].as_array().unwrap().iter().filter(|point| point["t_yr"] == 1.0 || point["t_yr"] == 2.0)
    {
        let of = |key: &str| point[key].as_f64().unwrap();
        let row = rows.iter().find(|row| number(row, "t_yr") == of("t_yr")).unwrap();
        // Both intervals hold the truth with 95 %.
        let widths = (of("high") - of("low")).hypot(number(row, "high") - number(row, "low"));
        assert!((of("probability") - number(row, "prob_reached_critical_e")).abs() < widths, "{point} {row:?}");
        assert!(of("low") <= of("probability") && of("probability") <= of("high"));
    }
    let at_end = answer["curve"].as_array().unwrap().last().unwrap()["probability"].as_f64().unwrap();
    for reached in answer["reached"].as_array().unwrap() {
        let (wanted, factor) =
            (reached["probability"].as_f64().unwrap(), reached["radiation_factor"].as_f64().unwrap());
        assert!((factor > 1.0) == (wanted > at_end), "{reached} {at_end}");
        let interval = &reached["radiation_factor_interval"];
        assert!(interval["low"].as_f64().unwrap() < factor && factor < interval["high"].as_f64().unwrap(), "{reached}");
        assert_eq!(reached["t_yr"].is_null(), wanted > at_end, "{reached}");
    }
    let largest = &answer["sensitivities"][0];
    assert!(
        largest["low"].as_f64().unwrap() * largest["high"].as_f64().unwrap() > 0.0,
        "it is seen through the noise: {largest}"
    );
}

#[test]
fn in_space_rare_events_are_estimated_without_an_exact_probability_and_unaveraged_orbits_are_refused() {
    let bench = Bench::new();
    let output =
        ask(&bench, &IN_SPACE.replace("radiation = 0.105", "radiation = 0.095"), &["--rare", "2000", "--json"]);
    let answer: Value = serde_json::from_str(&text(&output.stdout)).unwrap();
    let ever = &answer["rare"][0];
    assert!(ever["importance_sampling"]["probability"].is_number() && ever["exact"].is_null(), "{answer}");
    let unaveraged = IN_SPACE
        .replace("vectorial", "osculating")
        .replace("sun_longitude = 0.0", "sun_longitude = 0.0\nmoon_longitude = 0.0");
    let output = ask(&bench, &unaveraged, &[]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("\"osculating\" is not averaged"), "{}", text(&output.stderr));
}

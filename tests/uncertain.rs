//! A scenario whose start is correlated and whose radiation parameter is uncertain goes through a run: the parameter is
//! a third variable, and a method that does not take it into account fails by name.
#![allow(missing_docs)]

mod common;

use common::{Bench, text};

const SCENARIO: &str = "name = \"mine\"\n[orbit]\nradiation = 0.15\noblateness = 0.40921\n\
    [initial]\nphi = 2.2069\ne = 0.145\nsigma_phi = 0.2\nsigma_e = 0.025\ncorrelation = -0.7\nsigma_radiation = 0.1\n\
    [times]\nat = [0.0, 0.2]\n[disposal]\ncritical_e = 0.3\n";

/// The share of a standard error that an estimate from samples may be off.
const SIGMAS: f64 = 5.0;

fn launch(cases: &[&str]) -> String {
    let case = |node: &&str| format!("[[propagator]]\nlabel = \"{node}\"\nnode = \"{node}\"\n");
    let cases: String = cases.iter().map(case).collect();
    format!(
        "name = \"l\"\nscenarios = [\"mine.toml\"]\nreference = \"exact\"\nbins = [12, 10]\n{cases}samples = 20_000\n"
    )
}

#[test]
fn samples_and_the_exact_answer_agree_in_all_three_variables() {
    let bench = Bench::new();
    bench.write("mine.toml", SCENARIO);
    let output = bench.run_well(&bench.write("launch.toml", &launch(&["exact", "mc"])), "out");
    let told = text(&output.stdout);
    assert!(told.contains("the radiation parameter C given re-entry by 0.2 yr, and given none"), "{told}");
    let rows = bench.table("out/moments.csv");
    let row =
        |method: &str, time: &str| rows.iter().find(|row| row["method"] == method && row["t_yr"] == time).unwrap();
    for time in ["0.0", "0.2"] {
        let (exact, sampled) = (row("exact", time), row("mc", time));
        let number = |row: &std::collections::HashMap<String, String>, key: &str| row[key].parse::<f64>().unwrap();
        for key in
            ["mean_phi_rad", "std_phi_rad", "mean_e", "std_e", "mean_C", "std_C", "cov_phi_e", "cov_phi_C", "cov_e_C"]
        {
            let (right, found, error) =
                (number(exact, key), number(sampled, key), number(sampled, &format!("se_{key}")));
            assert!((found - right).abs() < SIGMAS * error, "{key} at {time}: {found} instead of {right} ± {error}");
        }
        assert!((number(exact, "mean_C") - 0.15).abs() < 1e-9);
    }
    let given = bench.table("out/given_re_entry.csv");
    let last = |method: &str, event: &str| {
        given.iter().rfind(|row| row["method"] == method && row["given"] == event && row["t_yr"] == "0.2").unwrap()
    };
    for event in ["re-entry", "none"] {
        let (exact, sampled) = (last("exact", event), last("mc", event));
        assert_eq!((&*exact["errors"], &*sampled["errors"]), ("error estimates", "standard errors"));
        let number = |row: &std::collections::HashMap<String, String>, key: &str| row[key].parse::<f64>().unwrap();
        for key in ["mean_C", "std_C"] {
            let error = format!("error_{key}");
            let (right, found) = (number(exact, key), number(sampled, key));
            let allowed = SIGMAS * number(sampled, &error) + number(exact, &error);
            assert!((found - right).abs() < allowed, "{key} given {event}: {found} instead of {right} ± {allowed}");
            assert!(number(exact, &error) < 1e-5 && number(sampled, &error) < 1e-3, "{key} given {event}");
        }
    }
    let mean = |event: &str| last("exact", event)["mean_C"].parse::<f64>().unwrap();
    assert!(mean("re-entry") > mean("none"), "who re-enters has a stronger pull");
    assert!(bench.table("out/distances.csv").iter().any(|row| row["method"] == "mc" && row["t_yr"] == "0.2"));
    // What was run can be run again from its folder.
    let copy = text(&bench.read("out/scenarios/mine.toml"));
    assert!(copy.contains("sigma_radiation = 0.1") && copy.contains("correlation = -0.7"), "{copy}");
}

#[test]
fn the_mixture_has_the_exact_moments_to_a_two_thousandth() {
    let bench = Bench::new();
    bench.write("mine.toml", SCENARIO);
    let cases = launch(&["gmm-ut", "exact"]).replace("samples = 20_000\n", "");
    bench.run_well(&bench.write("launch.toml", &cases), "out");
    let rows = bench.table("out/moments.csv");
    let number = |method: &str, key: &str| -> f64 {
        let row = rows.iter().find(|row| row["method"] == method && row["t_yr"] == "0.2").unwrap();
        row[key].parse().unwrap()
    };
    for key in ["mean_phi_rad", "std_phi_rad", "mean_e", "std_e", "mean_C", "std_C", "cov_phi_e", "cov_e_C"] {
        let (found, right) = (number("gmm-ut", key), number("exact", key));
        assert!((found / right - 1.0).abs() < 5e-4, "{key}: {found} instead of {right}");
    }
    let distances = bench.table("out/distances.csv");
    let is_wanted = |row: &&std::collections::HashMap<String, String>| {
        row["method"] == "gmm-ut"
            && row["t_yr"] == "0.2"
            && row["density"] == "marginal_phi_e"
            && row["measure"] == "total_variation"
    };
    let row = distances.iter().find(is_wanted).unwrap();
    assert!(row["value"].parse::<f64>().unwrap() < 0.005, "{row:?}");
    // The exact density is accurate to far less than anybody would care for here, so no note warns of it.
    let notes = text(&bench.read("out/notes.csv"));
    assert!(!notes.contains("reached an error estimate"), "{notes}");
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn layers_of_characteristics_have_the_exact_moments_whatever_the_shards() {
    let bench = Bench::new();
    bench.write("mine.toml", SCENARIO);
    let dee = "[[propagator]]\nlabel = \"layers\"\nnode = \"dee\"\nsamples = 8_000\n[[propagator]]\nlabel = \"parts\"\nnode = \"dee\"\n\
               samples = 8_000\nshards = 3\n";
    let cases = launch(&["exact"]).replace("samples = 20_000\n", dee);
    bench.run_well(&bench.write("launch.toml", &cases), "out");
    let rows = bench.table("out/moments.csv");
    let row = |method: &str| rows.iter().find(|row| row["method"] == method && row["t_yr"] == "0.2").unwrap();
    let number = |method: &str, key: &str| -> f64 { row(method)[key].parse().unwrap() };
    for key in
        ["mean_phi_rad", "std_phi_rad", "mean_e", "std_e", "mean_C", "std_C", "cov_phi_e", "cov_phi_C", "cov_e_C"]
    {
        let (found, right) = (number("layers", key), number("exact", key));
        assert!((found / right - 1.0).abs() < 5e-4, "{key}: {found} instead of {right}");
        assert_eq!(row("layers")[key], row("parts")[key], "{key}");
    }
    let passages = bench.table("out/first_passage.csv");
    let last = |method: &str| passages.iter().rfind(|row| row["method"] == method).unwrap();
    let of = |method: &str, key: &str| -> f64 { last(method)[key].parse().unwrap() };
    let right = of("exact", "prob_reached_critical_e");
    assert!((of("layers", "low")..=of("layers", "high")).contains(&right), "{right}: {:?}", last("layers"));
}

#[test]
fn a_method_that_does_not_take_it_into_account_fails_by_name() {
    let bench = Bench::new();
    bench.write("mine.toml", SCENARIO);
    let scattered = "node = \"dee\"\nplacement = \"random\"\n";
    let launch = launch(&["dee", "mc"]).replace("reference = \"exact\"", "reference = \"mc\"");
    let launch = launch.replace("node = \"dee\"\n", scattered);
    let output = bench.run(&bench.write("launch.toml", &launch), "out");
    assert_eq!(output.status.code(), Some(1));
    let told = text(&output.stderr) + &text(&output.stdout);
    assert!(told.contains("dee") && told.contains("radiation parameter is uncertain"), "{told}");
    assert!(bench.table("out/moments.csv").iter().all(|row| row["method"] == "mc"));
}

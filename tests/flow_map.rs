//! Samples that move by a flow map: the same results as by orbits, within the error of the map.
#![allow(missing_docs)]

mod common;

use common::{Bench, REPRODUCIBLE, text};

fn mc(label: &str, more: &str) -> String {
    format!("[[propagator]]\nlabel = \"{label}\"\nnode = \"mc\"\nsamples = 40_003\nseed = 11\n{more}\n")
}

fn launch_file(bench: &Bench, name: &str, cases: &str) -> std::path::PathBuf {
    let head = "scenarios = [\"scenario-1.toml\"]\nreference = \"mc\"\nbins = [40, 40]\n";
    bench.write(&format!("{name}.toml"), &format!("name = \"{name}\"\n{head}{cases}"))
}

const MAPPED: &str = "through = \"flow-map\"";

#[test]
fn samples_that_move_by_a_flow_map_are_those_that_move_by_orbits_within_its_error() {
    let bench = Bench::new();
    bench.run_well(&launch_file(&bench, "both", &(mc("mc", "") + &mc("mapped", MAPPED))), "both");
    let rows = bench.table("both/moments.csv");
    let of = |method: &str| rows.iter().filter(|row| row["method"] == method).collect::<Vec<_>>();
    assert_eq!(of("mc").len(), 5);
    for (direct, mapped) in of("mc").into_iter().zip(of("mapped")) {
        let figures = direct.keys().filter(|key| !["scenario", "method", "t_yr"].contains(&key.as_str()));
        assert!(figures.clone().count() > 6);
        for key in figures {
            let value = |row: &std::collections::HashMap<String, String>| row[key].parse::<f64>().unwrap();
            let (direct, mapped) = (value(direct), value(mapped));
            assert!((direct - mapped).abs() < 1e-8, "{key}: {direct} {mapped}");
        }
    }
    let passages = bench.table("both/first_passage.csv");
    let curve = |method: &str| {
        let rows = passages.iter().filter(|row| row["method"] == method);
        rows.map(|row| row["prob_reached_critical_e"].clone()).collect::<Vec<_>>()
    };
    assert!(curve("mc").len() > 60);
    assert_eq!(curve("mc"), curve("mapped"));
}

#[test]
fn shards_and_reduction_of_mapped_samples_give_the_same_bytes() {
    let bench = Bench::new();
    bench.run_well(&launch_file(&bench, "whole", &mc("mc", MAPPED)), "whole");
    for (out, more) in [("shards", "shards = 3"), ("reduced", "reduce = true"), ("both", "shards = 2\nreduce = true")] {
        let said =
            text(&bench.run_well(&launch_file(&bench, out, &mc("mc", &format!("{MAPPED}\n{more}"))), out).stderr);
        for file in REPRODUCIBLE {
            let same = bench.read(&format!("{out}/{file}")) == bench.read(&format!("whole/{file}"));
            assert!(same, "{out}: {file} differs; {said}");
        }
    }
}

//! What a case refuses of a scenario is told by `phasecloud validate` before anything is started, and by a run in whole
//! sentences.
#![allow(missing_docs)]

mod common;

use common::{Bench, text};

const PLANAR: &str = "name = \"plane\"\n[orbit]\nsemi_major_axis = 2.5\narea_to_mass = 15.35\nreflectivity = 1.0\n[initial]\nphi = 2.2069\ne = 0.145\nsigma_phi = 0.1\n\
    sigma_e = 0.0125\n[times]\nat = [0.0, 0.1]\n[disposal]\ncritical_e = 0.3\n";

/// Scenarios by the name of their file.
fn scenarios() -> [(&'static str, String); 5] {
    let uncertain = PLANAR.replace("\"plane\"", "\"uncertain\"").replace("[times]", "sigma_radiation = 0.1\n[times]");
    let shadow = format!("{PLANAR}[model]\nforces = [\"srp\", \"j2\", \"shadow\"]\n").replace("\"plane\"", "\"dark\"");
    let space = include_str!("../launch/scenarios/three-dimensional.toml").to_owned();
    let long = PLANAR.replace("\"plane\"", "\"long\"").replace("0.1]\n[disposal]", "100.0]\n[disposal]");
    [
        ("plane", PLANAR.to_owned()),
        ("uncertain", uncertain),
        ("dark", shadow),
        ("long", long),
        ("three-dimensional", space),
    ]
}

fn launch(scenario: &str, case: &str) -> String {
    let head = format!("name = \"l\"\nscenarios = [\"{scenario}.toml\"]\nreference = \"case\"\nbins = [12, 10]\n");
    format!("{head}[[propagator]]\nlabel = \"case\"\n{case}\n")
}

#[test]
fn validate_tells_what_a_case_cannot_do() {
    let bench = Bench::new();
    scenarios().iter().for_each(|(name, text)| drop(bench.write(&format!("{name}.toml"), text)));
    for (scenario, case, words) in [
        (
            "plane",
            "node = \"mc\"\nforces = [\"srp\"]",
            "forces: a case may have forces of its own where the scenario's model",
        ),
        (
            "plane",
            "node = \"qmc\"\nmodel = \"vectorial\"",
            "the scenario's model is \"planar\"; a case may have a simpler one",
        ),
        (
            "dark",
            "node = \"exact\"",
            "the scenario's model is \"planar\" with the Earth's shadow, this is for models in the plane alone, without the shadow",
        ),
        (
            "uncertain",
            "node = \"dee\"\nplacement = \"random\"",
            "dee takes placement = \"lattice\" and mesh = \"carried\" alone",
        ),
        ("uncertain", "node = \"mc\"\nreduce = true", "samples can be reduced in the plane alone"),
        ("uncertain", "node = \"gmm-ut\"\nsplit = \"solar-angle\"", "gmm-ut takes split = \"adaptive\""),
        (
            "three-dimensional",
            "node = \"mc\"\nforces = [\"j2\"]",
            "without \"srp\" the radiation parameter, a variable of the cloud",
        ),
        (
            "three-dimensional",
            "node = \"exact\"",
            "the scenario's model is \"vectorial\", this is for models in the plane alone",
        ),
        (
            "long",
            "node = \"flow-map\"\nmap_error = 1e-11",
            "map_error: a flow map cannot have an error of 1e-11: orbits themselves are known to 5e-11 after 100 yr; it can have 5e-10 or more",
        ),
        (
            "long",
            "node = \"flow-map\"\nsends = \"characteristics\"\nmap_error = 1e-10",
            "map_error: a flow map cannot have an error of 1e-10",
        ),
        ("long", "node = \"mc\"\nthrough = \"flow-map\"\nmap_error = 1e-10", "map_error: a flow map cannot have"),
        ("three-dimensional", "node = \"dee\"\nplacement = \"random\"", "placement: in space dee reads out the flow"),
    ] {
        bench.write("launch.toml", &launch(scenario, case));
        let output = bench.phasecloud().args(["validate", "launch.toml"]).output().unwrap();
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{case}: {told}");
        let place = format!("launch.toml:6: propagator.label: the case case cannot do the scenario {scenario}: ");
        assert!(told.contains(&place) && told.contains(words), "{case}: {told}");
    }
    for scenario in ["plane", "uncertain", "dark", "three-dimensional"] {
        for node in ["mc", "qmc", "dee", "gmm-ut"] {
            bench.write("launch.toml", &launch(scenario, &format!("node = \"{node}\"")));
            let output = bench.phasecloud().args(["validate", "launch.toml"]).output().unwrap();
            assert!(output.status.success(), "{node} on {scenario}: {}", text(&output.stderr));
        }
    }
}

#[test]
fn a_run_tells_a_long_refusal_to_its_end() {
    let bench = Bench::new();
    let [.., (name, content)] = scenarios();
    bench.write(&format!("{name}.toml"), &content);
    let launch = launch(name, "node = \"dee\"\nplacement = \"random\"");
    let output = bench.run(&bench.write("launch.toml", &launch), "out");
    let told = text(&output.stderr) + &text(&output.stdout);
    assert!(told.contains("accuracy alone; degree has no effect") && !told.contains('…'), "{told}");
}

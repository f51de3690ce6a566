//! A propagator that publishes random headers on every topic changes nobody's results.
#![allow(missing_docs)]

mod common;

use common::{Bench, FOUR_CASES, text};

#[test]
fn a_babbling_propagator_is_blamed_and_the_others_results_stay_the_same_bytes() {
    let bench = Bench::new();
    bench.run_well(&bench.launch_file("quiet", FOUR_CASES), "quiet");
    let program = common::examples::example("babbler");
    for seed in [1, 2, 3] {
        let babbler = format!(
            "[[propagator]]\nlabel = \"babbler\"\ncommand = [\"{}\", \"{seed}\"]\n{FOUR_CASES}",
            program.display()
        );
        let out = format!("babbled-{seed}");
        let output = bench.run(&bench.launch_file("babbled", &babbler), &out);
        let errors = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "seed {seed}: {errors}");
        assert!(errors.contains("babbler: a message on phasecloud/"), "{errors}");
        let manifest: serde_json::Value = serde_json::from_slice(&bench.read(&format!("{out}/manifest.json"))).unwrap();
        let blamed: Vec<_> = manifest["failures"].as_object().unwrap().keys().cloned().collect();
        assert_eq!(blamed, ["babbler"], "seed {seed}: {errors}");
        for file in ["moments.csv", "errors.csv", "densities.npz"] {
            assert!(
                bench.read(&format!("quiet/{file}")) == bench.read(&format!("{out}/{file}")),
                "seed {seed}: {file}"
            );
        }
    }
    assert_eq!(bench.domains(), [""; 0]);
}

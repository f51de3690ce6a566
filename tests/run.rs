//! Whole runs: real processes, real shared memory.
#![allow(missing_docs)]

mod common;

use std::os::unix::fs::PermissionsExt;

use common::{Bench, FOUR_CASES, REPRODUCIBLE, text};

#[test]
fn a_run_compares_all_cases_and_leaves_nothing_behind() {
    let bench = Bench::new();
    let output = bench.run_well(&bench.launch_file("four", FOUR_CASES), "out");

    let moments = bench.table("out/moments.csv");
    assert_eq!(moments.len(), 4 * 5);
    for row in &moments {
        let value = |column: &str| row[column].parse::<f64>().unwrap();
        assert!(value("std_phi_rad") > 0.0 && value("std_e") > 0.0);
        assert!((0.0..=1.0).contains(&value("prob_above_critical_e")));
    }
    assert_eq!(bench.table("out/errors.csv").len(), 4 * 5 * 8);
    assert_eq!(bench.table("out/effort.csv").len(), 4);
    let manifest: serde_json::Value = serde_json::from_slice(&bench.read("out/manifest.json")).unwrap();
    assert_eq!(manifest["nodes"].as_object().unwrap().len(), 8);
    assert_eq!(manifest["scenarios"]["scenario-1"], common::SCENARIO_1);

    let printed = text(&output.stdout);
    assert!(printed.contains("(3.57337)"), "the paper's Table 3 is beside ours: {printed}");
    assert!(printed.contains("(4370.77)"), "the paper's Table 4 is beside ours: {printed}");
    let run_id = manifest["run_id"].as_str().unwrap();
    assert_eq!(common::shared_memory_of(run_id), [""; 0]);
    assert_eq!(bench.domains(), [""; 0]);
}

#[test]
fn monte_carlo_has_the_papers_moments_within_its_sampling_error() {
    let bench = Bench::new();
    bench.run_well(&bench.launch_file("four", FOUR_CASES), "out");
    let exact = [2.2069, 0.952094, 3.573033, 5.266951, 3.326947];
    for (row, exact) in bench.table("out/moments.csv").iter().zip(exact) {
        let error = row["std_phi_rad"].parse::<f64>().unwrap() / 4000f64.sqrt();
        assert!((row["mean_phi_rad"].parse::<f64>().unwrap() - exact).abs() < 4.0 * error, "{row:?}");
    }
}

#[test]
fn the_same_seeds_give_the_same_bytes_also_beside_another_run() {
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES);
    let other = bench.launch_file("other", &FOUR_CASES.replace("seed = 11", "seed = 12"));
    bench.run_well(&launch, "alone");
    std::thread::scope(|scope| {
        scope.spawn(|| bench.run_well(&launch, "beside"));
        scope.spawn(|| bench.run_well(&other, "other"));
    });
    for file in REPRODUCIBLE {
        assert!(bench.read(&format!("alone/{file}")) == bench.read(&format!("beside/{file}")), "{file}");
        assert!(bench.read(&format!("alone/{file}")) != bench.read(&format!("other/{file}")), "{file}");
    }
}

#[test]
fn a_swapped_propagator_leaves_the_other_cases_unchanged() {
    let bench = Bench::new();
    let mine = common::examples::example("stt-gaussian");
    // The program runs in a shell that stays alive, as in scripts.
    let command = format!("command = [\"sh\", \"-c\", \"{}; true\"]", mine.display());
    let swapped = FOUR_CASES.replace("node = \"gmm-ut\"", &command);
    bench.run_well(&bench.launch_file("four", FOUR_CASES), "before");
    bench.run_well(&bench.launch_file("swapped", &swapped), "after");

    let (before, after) = (bench.table("before/moments.csv"), bench.table("after/moments.csv"));
    assert_eq!(before[..15], after[..15]);
    let of = |row: &std::collections::HashMap<String, String>, name: &str| row[name].parse::<f64>().unwrap();
    // At the start a single Gaussian is exact; later it is not.
    assert!(after[15..].iter().all(|row| row["method"] == "gmm-ut"));
    // Exact except for the part of the Gaussian below e = 0, which is cut: 3e-9 of it.
    assert!((of(&after[15], "mean_e") - 0.145).abs() < 1e-8 && (of(&after[15], "std_e") - 0.025).abs() < 1e-8);
    assert_ne!(before[19]["std_phi_rad"], after[19]["std_phi_rad"]);
}

#[test]
fn a_propagator_that_fails_is_named_and_the_others_are_compared() {
    let bench = Bench::new();
    let script = bench.write("script", "#!/no-such-interpreter\n");
    std::fs::set_permissions(&script, std::fs::Permissions::from_mode(0o755)).unwrap();
    let script = format!("[\"{}\"]", script.display());
    for (program, words) in [
        (r#"["sh", "-c", "exit 3"]"#, "exit status: 3"),
        (&script, "script cannot be started"),
        (r#"["true"]"#, "ended before the run did: exit status: 0"),
    ] {
        let cases = FOUR_CASES.replace("node = \"gmm-ut\"", &format!("command = {program}"));
        let out = format!("out-{}", words.len());
        let output = bench.run(&bench.launch_file("failing", &cases), &out);
        assert_eq!(output.status.code(), Some(1));
        let errors = text(&output.stderr);
        assert!(errors.contains("gmm-ut") && errors.contains(words), "{errors}");
        let moments = bench.table(&format!("{out}/moments.csv"));
        assert_eq!(moments.len(), 15);
        assert!(moments.iter().all(|row| row["method"] != "gmm-ut"));
        let manifest = text(&bench.read(&format!("{out}/manifest.json")));
        assert!(manifest.contains(words), "{manifest}");
    }
    assert_eq!(bench.domains(), [""; 0]);
}

#[test]
fn a_trajectory_that_leaves_the_domain_is_named_with_where_it_started() {
    let bench = Bench::new();
    let scenario = common::SCENARIO_1.replace("radiation = 0.15", "radiation = 3.0").replace("0.40921", "0.0");
    bench.write("scenario-1.toml", &scenario);
    let output = bench.run(&bench.launch_file("four", FOUR_CASES), "out");
    assert_eq!(output.status.code(), Some(1));
    let errors = text(&output.stderr);
    assert!(errors.contains("which started at phi =") && errors.contains("left the domain e < 1"), "{errors}");
    assert!(!bench.path("out").exists(), "no results are better than half of them");
    assert_eq!(bench.domains(), [""; 0]);
}

#[test]
fn as_printed_reproduces_table_3_and_the_corrected_methods_agree_with_exact() {
    let bench = Bench::new();
    let launch = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("launch/as-printed.toml");
    let output = bench.run_well(&launch, "out");
    let moments = bench.table("out/moments.csv");
    let columns = ["mean_phi_rad", "std_phi_rad", "mean_e", "std_e"];
    let values = |row: &std::collections::HashMap<String, String>| columns.map(|c| row[c].parse::<f64>().unwrap());
    let of =
        |method: &str| -> Vec<[f64; 4]> { moments.iter().filter(|row| row["method"] == method).map(values).collect() };
    let paper: Vec<_> = csv::Reader::from_path(concat!(env!("CARGO_MANIFEST_DIR"), "/launch/paper/table-3.csv"))
        .unwrap()
        .deserialize::<std::collections::HashMap<String, String>>()
        .map(Result::unwrap)
        .collect();
    let printed =
        |method: &str| -> Vec<[f64; 4]> { paper.iter().filter(|row| row["method"] == method).map(values).collect() };
    let relative = |a: f64, b: f64| (a - b).abs() / b.abs();

    for (ours, paper) in of("gmm-ut").iter().zip(&printed("gmm-ut")).skip(1) {
        for k in 0..4 {
            assert!(relative(ours[k], paper[k]) < 1.5e-4, "{ours:?} {paper:?}");
        }
    }
    for index in [1, 3] {
        for k in 0..4 {
            let (ours, paper) = (of("dee-1e5")[index][k], printed("dee-1e5")[index][k]);
            assert!(relative(ours, paper) < 5e-3, "{ours} {paper}");
        }
    }
    // Standard errors of 1e5 samples; the variance is doubled, since ours and the paper's values are both from samples.
    let errors: Vec<_> = moments.iter().filter(|row| row["method"] == "mc").collect();
    for ((ours, paper), row) in of("mc").iter().zip(&printed("mc")).zip(errors) {
        for k in 0..4 {
            let error = row[&format!("se_{}", columns[k])].parse::<f64>().unwrap() * 2f64.sqrt();
            let rounding = 5e-6; // Table 3 prints five digits
            assert!((ours[k] - paper[k]).abs() < 4.0 * error + rounding, "{ours:?} {paper:?}");
        }
    }
    for method in ["dee-961-corrected", "dee-1e5-corrected", "gmm-ut-corrected"] {
        for (ours, exact) in of(method).iter().zip(&of("exact")) {
            assert!((0..4).all(|k| relative(ours[k], exact[k]) < 1e-3), "{method}: {ours:?} {exact:?}");
        }
    }
    assert!((of("gmm-ut-text")[4][3] - 0.0584).abs() < 5e-5, "the text's split gives another deviation");

    let printed = text(&output.stdout);
    assert!(printed.contains("lacks the Jacobian") && printed.contains("as printed splits along e"), "{printed}");
    let notes = text(&bench.read("out/notes.csv"));
    assert!(notes.contains("gmm-ut,1.0,\"warning: components are too wide"), "{notes}");
    let passages = bench.table("out/first_passage.csv");
    for method in ["exact", "mc", "dee-1e5-corrected"] {
        let curve: Vec<f64> = passages
            .iter()
            .filter(|row| row["method"] == method)
            .map(|row| row["prob_reached_critical_e"].parse().unwrap())
            .collect();
        assert!(curve.len() >= 50 && curve.is_sorted(), "{method}");
    }
    for measure in ["total_variation", "l2", "hellinger", "kullback_leibler", "mass_outside_grid"] {
        assert!(bench.table("out/distances.csv").iter().any(|row| row["measure"] == measure), "{measure}");
    }
}

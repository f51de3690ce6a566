//! The report and the figures of a run.
#![allow(missing_docs)]

mod common;

use std::collections::BTreeSet;

use common::{Bench, FOUR_CASES, text};

/// The files in a folder with their contents.
fn files(bench: &Bench, folder: &str) -> Vec<(String, String)> {
    let entries = std::fs::read_dir(bench.path(folder)).unwrap();
    let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names.into_iter().map(|name| (name.clone(), text(&bench.read(&format!("{folder}/{name}"))))).collect()
}

fn report(bench: &Bench, arguments: &[&str], threads: &str) -> std::process::Output {
    bench.phasecloud().arg("report").args(arguments).env("RAYON_NUM_THREADS", threads).output().unwrap()
}

#[test]
fn a_run_has_every_figure_as_svg_and_a_page_with_every_moment() {
    let bench = Bench::new();
    bench.run_well(&bench.launch_file("four", FOUR_CASES), "out");
    let figures = files(&bench, "out/figures");

    let mut expected: BTreeSet<String> = [
        "phase-portrait",
        "cloud-evolution",
        "first-passage",
        "probability-above",
        "moment-errors",
        "accuracy-against-effort",
        "effort-shares",
        "effort-normalised",
    ]
    .map(|name| format!("{name}.svg"))
    .into();
    for method in ["mc", "dee-961", "dee-1e5", "gmm-ut"] {
        expected.insert(format!("joint-density-{method}-all.svg"));
        expected.extend((0..5).map(|index| format!("joint-density-{method}-{index}.svg")));
        if method != "mc" {
            expected.insert(format!("marginals-{method}.svg"));
            expected.extend((0..5).map(|index| format!("difference-{method}-{index}.svg")));
        }
    }
    assert_eq!(figures.iter().map(|(name, _)| name.clone()).collect::<BTreeSet<_>>(), expected);

    for (name, svg) in &figures {
        let document = roxmltree::Document::parse(svg).unwrap_or_else(|e| panic!("{name}: {e}"));
        let has = |tag: &str| document.descendants().any(|node| node.has_tag_name(("http://www.w3.org/2000/svg", tag)));
        assert!(has("title") && has("desc") && has("text") && has("path"), "{name}");
        assert_eq!(has("image"), name.starts_with("joint") || name.starts_with("difference"), "{name}");
        assert_eq!(svg.matches("http").count(), 1, "{name} refers to nothing outside");
    }
    let page = text(&bench.read("out/report.html"));
    assert_eq!(page.matches("http").count(), page.matches("xmlns=\"http://www.w3.org/2000/svg\"").count());
    for words in ["src=", "@import", "<link", "fetch(", "import("] {
        assert!(!page.contains(words), "nothing is loaded, but the page has {words}");
    }
    assert_eq!(page.matches("<figure").count(), figures.len());
    for row in bench.table("out/moments.csv") {
        for column in ["mean_phi_rad", "std_phi_rad", "mean_e", "std_e"] {
            let number = format!("<td>{:.5}", row[column].parse::<f64>().unwrap());
            assert!(page.contains(&number), "{number} of {row:?}");
        }
    }
    assert!(page.contains("a mixture says where orbits are at a time"), "notes are in the page");
}

#[test]
fn trajectories_are_counted_by_kind() {
    let bench = Bench::new();
    bench.run_well(&bench.launch_file("four", FOUR_CASES), "out");
    let rows = bench.table("out/effort.csv");
    let count =
        |method: &str| rows.iter().find(|row| row["method"] == method).unwrap()["trajectories"].parse::<f64>().unwrap();
    assert_eq!([count("mc"), count("dee-961"), count("dee-1e5")], [4000.0, 961.0, 2500.0]);
    assert!(count("gmm-ut") > 5.0 && count("gmm-ut") % 5.0 == 0.0, "five sigma points a component");
}

#[test]
fn a_report_made_anew_has_the_same_bytes_on_any_number_of_threads() {
    let bench = Bench::new();
    bench.run_well(&bench.launch_file("four", FOUR_CASES), "out");
    let made = |threads: &str| {
        let output = report(&bench, &["out"], threads);
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(text(&output.stdout).contains("out/report.html"));
        (bench.read("out/report.html"), files(&bench, "out/figures"))
    };
    let first = (bench.read("out/report.html"), files(&bench, "out/figures"));
    assert!(first == made("1") && first == made("3"));
}

#[test]
fn words_of_users_are_escaped_and_failures_are_told() {
    let bench = Bench::new();
    let command = "command = [\"sh\", \"-c\", \"exit 3 # <b>&</b>\"]";
    let output = bench.run(&bench.launch_file("four", &FOUR_CASES.replace("node = \"gmm-ut\"", command)), "out");
    assert_eq!(output.status.code(), Some(1));
    let page = text(&bench.read("out/report.html"));
    assert!(page.contains("exit 3 # &lt;b&gt;&amp;&lt;/b&gt;") && !page.contains("<b>&</b>"));
    assert!(page.contains("The case <b>gmm-ut</b> failed and was left out: ended before the run did: exit status: 3"));
}

#[test]
fn without_a_report_there_are_tables_only_and_it_can_be_made_later() {
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES);
    let output = bench.phasecloud().arg("run").arg(launch).args(["--out", "out", "--no-report"]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(!bench.path("out/report.html").exists() && !bench.path("out/figures").exists());
    assert!(report(&bench, &["out"], "2").status.success());
    assert!(bench.path("out/report.html").exists() && bench.path("out/figures/phase-portrait.svg").exists());
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn several_runs_are_laid_side_by_side() {
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES);
    bench.run_well(&launch, "before");
    bench.run_well(&bench.launch_file("swapped", &FOUR_CASES.replace("seed = 11", "seed = 12")), "after");
    let output = report(&bench, &["before", "after", "--out", "compared.html"], "2");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let page = text(&bench.read("compared.html"));
    for (run, seed) in [("before", "seed = 11"), ("after", "seed = 12")] {
        assert!(page.contains(seed));
        for row in bench.table(&format!("{run}/moments.csv")).iter().filter(|row| row["method"] == "mc") {
            let number = format!("<td>{:.5}", row["mean_phi_rad"].parse::<f64>().unwrap());
            assert!(page.contains(&number), "{run}: {number}");
        }
    }
    let ids: Vec<&str> = page.split(" id=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    assert_eq!(ids.iter().collect::<BTreeSet<_>>().len(), ids.len(), "every id is unique");
}

#[test]
fn a_folder_without_results_is_refused_with_the_file_that_is_wrong() {
    let bench = Bench::new();
    let refused = |folder: &str| {
        let output = report(&bench, &[folder], "1");
        assert_eq!(output.status.code(), Some(2));
        text(&output.stderr)
    };
    assert!(refused("missing").contains("name a folder that `phasecloud run` wrote"));
    bench.run_well(&bench.launch_file("four", FOUR_CASES), "out");
    let densities = bench.read("out/densities.npz");
    std::fs::write(bench.path("out/densities.npz"), &densities[..densities.len() / 2]).unwrap();
    assert!(refused("out").contains("densities.npz"));
    std::fs::write(bench.path("out/densities.npz"), &densities).unwrap();
    bench.write("out/effort.csv", "scenario,method\nscenario-1,mc\n");
    assert!(refused("out").contains("effort.csv"));
}

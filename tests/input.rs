//! Bad input is reported before anything starts, with exit code 2.
#![allow(missing_docs)]

mod common;

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

use common::{Bench, FOUR_CASES, text};
use launch::plan::cases::KEYS;
use launch::plan::launch_file::Launch;
use nodes::files::input::InputFile;
use nodes::methods::BuiltIn;

fn refused(bench: &Bench, launch: &std::path::Path, out: &str) -> String {
    let output = bench.run(launch, out);
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert_eq!(bench.domains(), [""; 0], "nothing has been started");
    errors
}

#[test]
fn files_that_cannot_be_right_are_refused_with_file_line_and_key() {
    let bench = Bench::new();
    let missing = refused(&bench, &bench.path("missing.toml"), "out");
    assert!(missing.contains("missing.toml: cannot be read"), "{missing}");

    let unknown = bench.launch_file("unknown", &FOUR_CASES.replace("seed", "sead"));
    let unknown = refused(&bench, &unknown, "out");
    assert!(
        unknown.contains(
            "unknown.toml:9: propagator.sead: is unknown, did you mean `seed`? There may be `samples`, `seed`"
        ),
        "{unknown}"
    );

    let good = bench.launch_file("good", FOUR_CASES);
    bench.write("scenario-1.toml", &common::SCENARIO_1.replace("delta_e = 0.05", "delta_e = -1"));
    let negative = refused(&bench, &good, "out");
    assert!(negative.contains("scenario-1.toml") && negative.contains("initial.delta_e"), "{negative}");
    assert!(!bench.path("out").exists());
}

#[test]
fn a_file_that_cannot_be_read_as_what_it_is_draws_one_error_that_says_why() {
    let bench = Bench::new();
    let good = "name = \"x\"\nscenarios = [\"scenario-1.toml\"]\nreference = \"mc\"\n[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\n";
    for (content, words) in [
        (&b"\x7fELF\x02\x01\x01\x00\xff\xfe\x00"[..], "file.toml:1: is not UTF-8 text from here on"),
        (b"\x00\x01\x02\n", "file.toml:1: is not TOML: "),
        (b"This is no TOML.\nNor is this.\n", "file.toml:1: is not TOML: "),
        (b"", "file.toml: has no key that says whether it is a launch, a scenario, a sweep or a map file"),
        (good.replace("name = \"x\"\n", "").as_bytes(), "file.toml:1: name: the launch file lacks the key `name`"),
        (
            good.replace("reference", "name = \"y\"\nreference").as_bytes(),
            "file.toml:3: name: stands in its table for the second time",
        ),
        (
            format!("{good}label = \"m\"\n").as_bytes(),
            "file.toml:7: propagator.label: stands in its table for the second time",
        ),
        (
            format!("{good}[[propagator]]\nlabel = \"gmm\"\nnode = \"gmm-ut\"\nmerge_to = 5000\n").as_bytes(),
            "file.toml:10: propagator.merge_to: has no effect where the mixture has at most 5000 components",
        ),
    ] {
        std::fs::write(bench.path("file.toml"), content).unwrap();
        let (code, _, errors) = validate(&bench, &["file.toml"]);
        assert_eq!((code, errors.lines().count()), (Some(2), 1), "{errors}");
        assert!(errors.contains(words), "{errors}");
    }
}

#[test]
fn sweeps_that_would_do_a_scenario_twice_or_have_values_without_effect_are_refused() {
    let bench = Bench::new();
    let satellite = "semi_major_axis = 2.5\narea_to_mass = 10.0\nreflectivity = 1.2";
    let orbit = |line: &&str| line.starts_with("radiation") || line.starts_with("oblateness");
    let orbit: Vec<&str> = common::SCENARIO_1.lines().filter(orbit).collect();
    bench.write("satellite.toml", &common::SCENARIO_1.replace(orbit[0], satellite).replace(orbit[1], ""));
    assert_eq!(validate(&bench, &["satellite.toml"]).0, Some(0));
    for (scenario, vary, words) in [
        ("scenario-1", "\"initial.e\" = { from = 0.1, to = 0.2, count = 1 }", "to = 0.2 has no effect"),
        ("scenario-1", "\"initial.e\" = { from = 0.1, to = 0.1, count = 2 }", "takes the value 0.1 twice"),
        ("scenario-1", "\"initial.e\" = [0.1, 0.2, 0.1]", "takes the value 0.1 twice"),
        ("satellite", "\"orbit.radiation\" = [0.1]", "which gives its orbit by the satellite; what can be varied is "),
    ] {
        bench.write("sweep.toml", &format!("scenario = \"{scenario}.toml\"\n[vary]\n{vary}\n"));
        let (code, _, errors) = validate(&bench, &["sweep.toml"]);
        assert_eq!((code, errors.lines().count()), (Some(2), 1), "{errors}");
        assert!(errors.contains("sweep.toml:3: vary.") && errors.contains(words), "{errors}");
    }
}

#[test]
fn who_submits_without_a_service_is_told_how_to_start_one() {
    let bench = Bench::new();
    let output = bench.phasecloud().args(["submit", "scenario-1.toml"]).output().unwrap();
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(errors.contains("start one with `phasecloud serve LAUNCH_FILE`"), "{errors}");
}

#[test]
fn a_run_that_shared_memory_cannot_hold_is_refused() {
    let bench = Bench::new();
    let launch = bench.launch_file("huge", &FOUR_CASES.replace("4_000", "4_000_000_000_000"));
    let errors = refused(&bench, &launch, "out");
    assert!(errors.contains("MiB of shared memory"), "{errors}");
}

#[test]
fn a_results_folder_that_is_in_use_or_cannot_exist_is_refused() {
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES);
    assert!(refused(&bench, &launch, ".").contains("is not empty"));
    bench.write("file", "");
    assert!(refused(&bench, &launch, "file/out").contains("cannot write results to"));
}

fn validate(bench: &Bench, files: &[&str]) -> (Option<i32>, String, String) {
    let output = bench.phasecloud().arg("validate").args(files).output().unwrap();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

#[test]
fn validate_says_what_is_good_and_what_is_not() {
    let bench = Bench::new();
    bench.launch_file("good", FOUR_CASES);
    bench.launch_file("bad", &FOUR_CASES.replace("node = \"mc\"", "node = \"md\""));
    bench.write("sweep.toml", "scenario = \"scenario-1.toml\"\n[vary]\n\"initial.e\" = [0.1, 0.2]\n");
    bench.write("impossible.toml", "scenario = \"scenario-1.toml\"\n[vary]\n\"initial.e\" = [0.1, 1.2, 0.2, 1.4]\n");
    bench.write("neither.toml", "name = \"x\"\n");
    let (code, good, bad) = validate(
        &bench,
        &["good.toml", "scenario-1.toml", "sweep.toml", "bad.toml", "impossible.toml", "neither.toml"],
    );
    assert_eq!(code, Some(2));
    for words in [
        "good.toml: good, 4 cases on 1 scenario",
        "scenario-1.toml: good, scenario scenario-1 with 5 snapshots to 2 yr",
        "sweep.toml: good, sweep of 2 scenarios over initial.e",
    ] {
        assert!(good.contains(words), "{words}: {good}");
    }
    for words in [
        "\"md\" is unknown; it must be one of mc, qmc, dee",
        "impossible.toml:3: vary.initial.e: 1.2 is not allowed, it must be between 0 and 1, both excluded, in scenario-1-1 (initial.e = 1.2)",
        "impossible.toml: 2 of 4 combinations are impossible",
        "neither.toml: has no key that says whether it is a launch, a scenario, a sweep or a map file",
    ] {
        assert!(bad.contains(words), "{words}: {bad}");
    }
    assert_eq!(validate(&bench, &["good.toml", "sweep.toml"]).0, Some(0));
}

#[test]
fn a_range_that_is_not_finite_or_not_whole_is_told_as_what_it_is() {
    let bench = Bench::new();
    for (vary, words) in [
        (
            "\"initial.e\" = { from = 0.1, to = inf, count = 3 }",
            "initial.e: to = inf is not allowed, it must be a finite",
        ),
        ("\"initial.e\" = { from = 0.1, to = 0.2 }", "initial.e: count is missing; a range has from, to and count"),
        ("initial.e = [0.1, 0.2]", "initial: the whole key needs quotation marks under [vary]: \"initial.e\" = "),
    ] {
        bench.write("sweep.toml", &format!("scenario = \"scenario-1.toml\"\n[vary]\n{vary}\n"));
        let (code, _, errors) = validate(&bench, &["sweep.toml"]);
        assert_eq!((code, errors.lines().count()), (Some(2), 1), "{errors}");
        assert!(errors.contains("sweep.toml:3: vary.") && errors.contains(words), "{errors}");
    }
}

#[test]
fn names_that_are_no_text_are_refused_with_the_option_that_gives_them() {
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES);
    let name = OsStr::from_bytes(b"bad\xffname");
    let output = bench.phasecloud().arg("run").arg(&launch).arg("--out").arg(name).output().unwrap();
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(errors.contains("error: --out: the path ") && errors.contains("is not UTF-8 text"), "{errors}");
    std::fs::write(bench.path(".").join(name), "scenario = \"scenario-1.toml\"\n[vary]\n\"initial.e\" = [0.1]\n")
        .unwrap();
    let output = bench.phasecloud().arg("serve").arg(&launch).arg("--sweep").arg(name).output().unwrap();
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(errors.contains("error: --sweep: the path "), "{errors}");
    assert_eq!(bench.domains(), [""; 0], "nothing has been started");
}

#[test]
fn a_folder_for_temporary_files_that_cannot_be_one_is_refused_by_the_name_of_its_variable() {
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES).display().to_string();
    bench.write("file", "");
    let no_text = Path::new(OsStr::from_bytes(b"/tmp/\xff"));
    for folder in [Path::new("/proc"), &bench.path("file"), Path::new(""), &bench.path("absent"), no_text] {
        for words in [&["run", &launch, "--out", "out"][..], &["serve", &launch, "--out", "out"], &["check", "mc"]] {
            let output = bench.phasecloud().args(words).env("TMPDIR", folder).output().unwrap();
            let errors = text(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{words:?}: {errors}");
            assert!(errors.contains("TMPDIR"), "{words:?}: {errors}");
            assert!(!bench.path("out").exists());
        }
    }
}

#[test]
fn a_value_of_the_environment_that_is_refused_is_told_by_the_name_of_its_variable() {
    let bench = Bench::new();
    let told = |words: &[&str]| {
        let output = bench.phasecloud().args(words).env("PHASECLOUD_LOG", "nonsense").output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        text(&output.stderr).contains("environment variable PHASECLOUD_LOG.")
    };
    assert!(told(&["run"]) && told(&[]) && told(&["serve"]));
    assert!(!told(&["run", "--log", "nonsense"]) && !told(&["run", "--log=nonsense"]));
}

#[test]
fn validate_looks_whether_programs_are_there_and_executable() {
    let bench = Bench::new();
    bench.write("not-executable", "#!/bin/sh\n");
    for (program, words) in [
        ("./missing", "of the case program: there is no program ./missing, looked up from "),
        ("./not-executable", "of the case program: ./not-executable is not executable (chmod +x ./not-executable)"),
        ("/", "is not a program but a folder"),
        (
            "no-such-program-anywhere",
            "of the case program: there is no program \"no-such-program-anywhere\" in the folders of PATH",
        ),
    ] {
        let case = format!("{FOUR_CASES}[[propagator]]\nlabel = \"program\"\ncommand = [\"{program}\"]\n");
        bench.launch_file("foreign", &case);
        let (code, _, errors) = validate(&bench, &["foreign.toml"]);
        assert!(code == Some(2) && errors.contains(words), "{errors}");
        let text = std::fs::read_to_string(bench.path("foreign.toml")).unwrap();
        let line = text.lines().position(|line| line.starts_with("command")).unwrap() + 1;
        assert!(errors.contains(&format!("foreign.toml:{line}: propagator.command: of the case ")), "{errors}");
        // A program in PATH, with arguments.
        bench.launch_file("foreign", &case.replace(&format!("[\"{program}\"]"), "[\"sh\", \"-c\", \"true\"]"));
        assert_eq!(validate(&bench, &["foreign.toml"]).0, Some(0));
    }
}

#[test]
fn a_file_of_another_kind_is_recognised_with_what_to_do() {
    let bench = Bench::new();
    bench.launch_file("launch", FOUR_CASES);
    bench.write("sweep.toml", "scenario = \"scenario-1.toml\"\n[vary]\n\"initial.e\" = [0.1, 0.2]\n");
    for (arguments, words) in [
        (&["run", "scenario-1.toml"][..], "`phasecloud run --scenario scenario-1.toml` runs the default cases on it"),
        (&["run", "sweep.toml"], "`phasecloud serve LAUNCH_FILE --sweep sweep.toml`"),
        (&["run", "--scenario", "launch.toml"], "`phasecloud run launch.toml` runs it on the scenarios that it names"),
        (&["run", "--scenario", "sweep.toml"], "this is a sweep file, but a scenario file belongs here"),
        (&["serve", "scenario-1.toml"], "`phasecloud submit` gives it to a running service"),
        (&["serve", "sweep.toml"], "`phasecloud serve LAUNCH_FILE --sweep sweep.toml`"),
        (&["serve", "--sweep", "scenario-1.toml"], "a sweep file names it as scenario"),
        (&["serve", "--sweep", "launch.toml"], "`phasecloud serve launch.toml --sweep SWEEP_FILE`"),
        (&["submit", "launch.toml"], "this is a launch file, but a scenario file belongs here"),
        (&["graph", "scenario-1.toml"], "this is a scenario file, but a launch file belongs here"),
    ] {
        let output = bench.phasecloud().args(arguments).output().unwrap();
        let errors = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {errors}");
        assert!(errors.contains(words), "{arguments:?}: {errors}");
    }
    assert_eq!(bench.domains(), [""; 0], "nothing has been started");
}

#[test]
fn the_manifest_has_the_settings_that_have_an_effect_and_no_other() {
    let bench = Bench::new();
    bench.run_well(&bench.launch_file("four", FOUR_CASES), "out");
    let manifest: serde_json::Value = serde_json::from_slice(&bench.read("out/manifest.json")).unwrap();
    let settings = manifest["cases"]["gmm-ut"]["settings"].as_array().unwrap();
    let has = |start: &str| settings.iter().any(|line| line.as_str().unwrap().starts_with(start));
    assert!(has("split = \"adaptive\"") && has("sigma_points = ") && !has("components"), "{settings:?}");
}

const PAGE: &str = include_str!("../docs/launch-files.md");

/// The rows of the page's table below this heading, as lists of cells.
fn rows(heading: &str) -> Vec<Vec<&'static str>> {
    let (_, rest) = PAGE.split_once(&format!("\n## {heading}\n")).unwrap_or_else(|| panic!("no heading {heading}"));
    let section = rest.split("\n## ").next().unwrap();
    let rows = section.lines().filter(|line| line.starts_with("| `"));
    rows.map(|line| line.trim_matches('|').split(" | ").map(str::trim).collect()).collect()
}

/// The keys that the message about an unknown key names.
fn known_to(launch: &str) -> Vec<String> {
    let file = InputFile::from_text(Path::new("launch.toml"), launch);
    let error = Launch::check(&file, None, None).unwrap_err().to_string();
    let (_, keys) = error.split_once("here may be ").unwrap_or_else(|| panic!("{error}"));
    let (settings, _) = keys.split_once(" (").unwrap_or((keys, ""));
    settings.split(", ").map(|key| key.trim_matches('`').to_owned()).collect()
}

#[test]
fn the_page_about_launch_files_lists_every_key_and_no_other() {
    let head = "name = \"l\"\nscenarios = [\"s.toml\"]\nreference = \"a\"\n";
    let node = |name: &str| format!("{head}[[propagator]]\nlabel = \"a\"\nnode = \"{name}\"\nunknown = 1\n");
    let mut tables = vec![
        ("Top level".to_owned(), known_to(&format!("{head}unknown = 1\n"))),
        ("`[hosts]`".to_owned(), known_to(&format!("{head}[hosts]\nunknown = 1\n"))),
        ("`[[propagator]]`: every case".to_owned(), KEYS.map(str::to_owned).into()),
    ];
    tables.extend(BuiltIn::NAMES.iter().map(|name| (format!("`node = \"{name}\"`"), known_to(&node(name)))));
    for (heading, mut known) in tables {
        let rows = rows(&heading);
        let mut listed: Vec<String> = rows.iter().map(|row| row[0].trim_matches('`').to_owned()).collect();
        assert!(rows.iter().all(|row| row.len() == 6), "{heading}");
        known.sort();
        listed.sort();
        assert_eq!(listed, known, "{heading}");
    }
}

#[test]
fn the_page_about_launch_files_has_the_defaults_of_the_program() {
    for &name in BuiltIn::NAMES {
        let rows = rows(&format!("`node = \"{name}\"`"));
        let defaults = BuiltIn::from_settings(name, toml::Table::new()).unwrap().unwrap().to_lines().unwrap();
        assert!(!defaults.is_empty());
        for line in defaults {
            let default: toml::Table = toml::from_str(&line).unwrap();
            let (key, value) = default.iter().next().unwrap();
            let row = rows.iter().find(|row| row[0] == format!("`{key}`")).unwrap_or_else(|| panic!("{key}"));
            let told = row[3].split('`').nth(1).unwrap_or_else(|| panic!("{key}: {}", row[3]));
            let told: toml::Table = toml::from_str(&format!("{key} = {told}")).unwrap();
            assert_eq!(told[key], *value, "{name}: {key}");
        }
    }
}

#[test]
fn the_examples_of_the_page_about_launch_files_are_good() {
    let example = PAGE.split("```").nth(1).and_then(|block| block.strip_prefix("toml\n")).unwrap();
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("launch/scenarios/scenario-1.toml");
    let check = |text: &str| {
        let file = InputFile::from_text(Path::new("launch.toml"), text);
        Launch::check(&file, None, Some(&scenario)).unwrap_or_else(|error| panic!("{error}: {text}"))
    };
    assert_eq!(check(example).cases.len(), 3);
    // Every example of a setting, together with the settings that it needs.
    for &name in BuiltIn::NAMES {
        for row in rows(&format!("`node = \"{name}\"`")) {
            let (key, example) = (row[0].trim_matches('`'), row[5].trim_matches('`'));
            let more = match (name, key) {
                ("mc", "draws") => "replicates = 2\n",
                ("mc", "map_error") => "through = \"flow-map\"\n",
                ("flow-map", "degree") => "sends = \"characteristics\"\n",
                ("dee", "seed") => "placement = \"random\"\n",
                ("dee", "resolution") => "mesh = \"hull\"\n",
                ("gmm-ut", "components" | "across" | "keep_variance") => "split = \"solar-angle\"\n",
                _ => "",
            };
            check(&format!(
                "name = \"l\"\nscenarios = []\nreference = \"a\"\n[[propagator]]\nlabel = \"a\"\nnode = \"{name}\"\n{key} = \
                 {example}\n{more}"
            ));
        }
    }
}

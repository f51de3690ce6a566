//! The results folder proves itself: checksums of every file, and the log of the run.
#![allow(missing_docs)]

mod common;

use common::{Bench, FOUR_CASES, text};

#[test]
fn every_file_has_its_checksum_and_a_change_is_found() {
    let bench = Bench::new();
    bench.run_well(&bench.launch_file("four", FOUR_CASES), "out");
    let manifest: serde_json::Value = serde_json::from_slice(&bench.read("out/manifest.json")).unwrap();
    let files = manifest["files"].as_object().unwrap();
    for name in ["moments.csv", "densities.npz", "log.jsonl", "scenarios/scenario-1.toml"] {
        assert_eq!(files[name]["bytes"], bench.read(&format!("out/{name}")).len(), "{name}");
    }
    let verify = || {
        let output = bench.phasecloud().arg("verify").arg(bench.path("out")).output().unwrap();
        (output.status.code(), text(&output.stdout) + &text(&output.stderr))
    };
    assert_eq!(verify().0, Some(0), "{}", verify().1);
    // Known from the standard: the SHA-256 of an empty text.
    bench.write("out/extra", "");
    let digest = std::process::Command::new("sha256sum").arg(bench.path("out/moments.csv")).output().unwrap();
    assert!(text(&digest.stdout).starts_with(files["moments.csv"]["sha256"].as_str().unwrap()));
    let mut moments = bench.read("out/moments.csv");
    moments[40] ^= 1;
    std::fs::write(bench.path("out/moments.csv"), moments).unwrap();
    std::fs::remove_file(bench.path("out/effort.csv")).unwrap();
    let (code, said) = verify();
    assert_eq!(code, Some(1));
    for words in ["moments.csv has been changed", "effort.csv is missing", "extra does not belong"] {
        assert!(said.contains(words), "{said}");
    }
    std::fs::remove_file(bench.path("out/manifest.json")).unwrap();
    assert_eq!(verify().0, Some(2));
}

#[test]
fn the_log_has_lines_of_every_process_and_of_foreign_programs_under_their_labels() {
    let bench = Bench::new();
    let talker =
        "[[propagator]]\nlabel = \"talker\"\ncommand = [\"sh\", \"-c\", \"echo hello; echo world >&2; exit 3\"]\n";
    let output = bench.run(&bench.launch_file("four", &format!("{FOUR_CASES}{talker}")), "out");
    assert_eq!(output.status.code(), Some(1));
    let log = text(&bench.read("out/log.jsonl"));
    let lines: Vec<serde_json::Value> = log.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let manifest: serde_json::Value = serde_json::from_slice(&bench.read("out/manifest.json")).unwrap();
    assert!(lines.iter().all(|line| line["run"] == manifest["run_id"]));
    let says = |node: &str, message: &str| lines.iter().any(|line| line["node"] == node && line["message"] == message);
    for node in ["mc", "dee-961", "gmm-ut", "scenario", "estimator", "comparator", "recorder"] {
        assert!(says(node, "ready"), "{node}: {log}");
    }
    assert!(says("talker", "hello") && says("talker", "world"), "{log}");
    assert!(log.contains("\"node\":\"launcher\"") && log.contains("talker has ended: exit status: 3"), "{log}");
}

#[test]
fn the_terminal_shows_what_was_asked_for() {
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES);
    let run = |arguments: &[&str], out: &str| {
        let mut command = bench.phasecloud();
        command.arg("run").arg(&launch).arg("--out").arg(bench.path(out)).args(arguments);
        let output = command.output().unwrap();
        assert!(output.status.success());
        text(&output.stderr)
    };
    let plain = run(&[], "plain");
    assert!(plain.contains("8 processes are ready") && plain.contains("scenario-1 is recorded"), "{plain}");
    assert!(["ERROR", "WARN", "INFO", "DEBUG"].iter().all(|level| !plain.contains(level)), "{plain}");
    assert_eq!(run(&["--quiet"], "quiet"), "");
    let debug = run(&["--log", "debug"], "debug");
    assert!(debug.contains("INFO ") && debug.contains("mc: ready") && debug.contains("DEBUG "), "{debug}");
    let json = run(&["--log", "info", "--log-format", "json", "--quiet"], "json");
    assert!(json.lines().count() > 10, "{json}");
    for line in json.lines() {
        assert!(serde_json::from_str::<serde_json::Value>(line).unwrap()["node"].is_string());
    }
}

#[test]
fn the_default_folder_is_named_after_the_scenario_or_after_the_launch_file_if_there_are_several() {
    let bench = Bench::new();
    let scenario = |name: &str| common::SCENARIO_1.replace("scenario-1\"", &format!("{name}\""));
    bench.write("mine.toml", &scenario("my-satellite"));
    bench.write("two.toml", &scenario("second"));
    bench.launch_file("four", FOUR_CASES);
    let several =
        format!("name = \"several\"\nscenarios = [\"mine.toml\", \"two.toml\"]\nreference = \"mc\"\n{FOUR_CASES}");
    bench.write("several.toml", &several);
    for (arguments, start) in
        [(&["four.toml", "--scenario", "mine.toml"][..], "my-satellite-2"), (&["several.toml"], "several-2")]
    {
        let output = bench.phasecloud().arg("run").args(arguments).arg("--no-report").output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        let folders = std::fs::read_dir(bench.path("results")).unwrap().flatten();
        let names: Vec<_> = folders.map(|folder| folder.file_name().to_string_lossy().into_owned()).collect();
        assert!(names.iter().any(|name| name.starts_with(start)), "{names:?}");
    }
}

#[test]
fn an_empty_folder_is_filled_and_its_owner_and_number_stay_the_same() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES);
    std::fs::create_dir_all(bench.path("out/lost+found")).unwrap();
    std::fs::set_permissions(bench.path("out"), std::fs::Permissions::from_mode(0o750)).unwrap();
    let number = || std::fs::metadata(bench.path("out")).unwrap().ino();
    let before = number();
    bench.run_well(&launch, "out");
    assert_eq!(number(), before, "it is the folder that was given, not another in its place");
    let verified = bench.phasecloud().arg("verify").arg(bench.path("out")).output().unwrap();
    assert!(verified.status.success(), "{}", text(&verified.stderr));
    let names: Vec<_> =
        std::fs::read_dir(bench.path("out")).unwrap().flatten().map(|entry| entry.file_name()).collect();
    assert!(!names.iter().any(|name| name.to_string_lossy().contains("partial")), "{names:?}");

    std::fs::create_dir_all(bench.path("left/.phasecloud-000000000001.partial")).unwrap();
    let output = bench.run(&launch, "left");
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("of a run that is under way or was killed"), "{}", text(&output.stderr));
    std::os::unix::fs::symlink("nowhere", bench.path("link")).unwrap();
    let output = bench.run(&launch, "link");
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("it is a link to nothing"), "{}", text(&output.stderr));
}

#[test]
fn no_other_page_is_put_into_a_results_folder() {
    let bench = Bench::new();
    bench.run_well(&bench.launch_file("four", FOUR_CASES), "out");
    for page in ["out/other.html", "out/figures/other.html"] {
        std::fs::create_dir_all(bench.path("out/figures")).unwrap();
        let output = bench.phasecloud().arg("report").arg(bench.path("out")).args(["--out", page]).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{page}");
        assert!(text(&output.stderr).contains("whose files are sealed"), "{}", text(&output.stderr));
    }
    let output =
        bench.phasecloud().arg("report").arg(bench.path("out")).args(["--out", "other.html"]).output().unwrap();
    assert!(output.status.success() && bench.path("other.html").is_file(), "{}", text(&output.stderr));
    let verified = bench.phasecloud().arg("verify").arg(bench.path("out")).output().unwrap();
    assert!(verified.status.success(), "{}", text(&verified.stderr));
}

//! A service: the processes stay while scenario after scenario comes.
#![allow(missing_docs)]

mod common;

use std::process::Stdio;
use std::time::{Duration, Instant};

use common::processes::{of_runs_below, signal};
use common::service::{SMALL, WATCHDOG, end, start, submit};
use common::{Bench, FOUR_CASES, REPRODUCIBLE, text};
use rustix::process::{Pid, Signal, kill_process};

fn sweep(bench: &Bench, vary: &str) -> std::path::PathBuf {
    bench.write("sweep.toml", &format!("scenario = \"scenario-1.toml\"\n[vary]\n{vary}\n"))
}

/// Whoever reads JSON gets nothing else on standard output, and who wants silence gets silence.
#[test]
fn a_sweep_prints_json_alone_or_nothing_where_that_is_asked_for() {
    let bench = Bench::new();
    let launch = bench.launch_file("small", SMALL);
    let sweep = sweep(&bench, "\"initial.e\" = [0.1, 0.145]");
    let printed = |how: &str| {
        let mut command = bench.phasecloud();
        command.arg("serve").arg(&launch).arg("--sweep").arg(&sweep).args(["--out", how.trim_start_matches('-'), how]);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    assert_eq!(printed("--quiet"), "");
    let objects: Vec<serde_json::Value> =
        printed("--json").lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let last = objects.last().unwrap();
    assert_eq!((last["event"].as_str(), last["scenarios"].as_u64()), (Some("served"), Some(2)), "{last}");
}

#[test]
fn a_sweep_makes_a_results_folder_a_scenario_and_one_table_of_all() {
    let bench = Bench::new();
    let launch = bench.launch_file("small", SMALL);
    let sweep = sweep(&bench, "\"initial.e\" = [0.1, 0.145]\n\"disposal.critical_e\" = [0.5, 0.6]");
    let mut command = bench.phasecloud();
    let output = command.arg("serve").arg(&launch).arg("--sweep").arg(sweep).args(["--out", "out"]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("4 scenarios in"), "{}", text(&output.stdout));
    assert_eq!(bench.table("out/moments.csv").len(), 4 * 2 * 5);
    // The last combination is scenario 1 itself.
    bench.run_well(&launch, "alone");
    for file in ["densities.npz", "moments.csv", "errors.csv", "first_passage.csv"] {
        let read = |name: &str| text(&bench.read(&format!("{name}/{file}")));
        let same = read("out/000003-scenario-1-3").replace("scenario-1-3", "scenario-1");
        assert!(file.ends_with("npz") || same == read("alone"), "{file}");
    }
    assert!(bench.path("out/000003-scenario-1-3/manifest.json").exists());
    let varied = text(&bench.read("out/000001-scenario-1-1/varied.csv"));
    assert_eq!(
        varied, "scenario,parameter,value\nscenario-1-1,disposal.critical_e,0.5\nscenario-1-1,initial.e,0.145\n",
        "the keys are in the order of the alphabet"
    );
    let verified = bench.phasecloud().arg("verify").arg(bench.path("out/000001-scenario-1-1")).output().unwrap();
    assert!(verified.status.success(), "{}", text(&verified.stderr));
    assert_sweep_table(&bench);
    assert_eq!(bench.domains(), [""; 0]);
}

/// The table of the sweep above has the numbers of its scenarios' own tables, and the page has all of them.
fn assert_sweep_table(bench: &Bench) {
    let rows = bench.table("out/sweep.csv");
    assert_eq!(rows.len(), 4 * 2);
    let page = text(&bench.read("out/report.html"));
    for (position, row) in rows.iter().enumerate() {
        let (scenario, method) = (format!("scenario-1-{}", position / 2), ["mc", "dee"][position % 2]);
        assert_eq!((&row["scenario"], row["method"].as_str()), (&scenario, method));
        let varied: [f64; 2] = ["disposal.critical_e", "initial.e"].map(|key| row[key].parse().unwrap());
        assert_eq!(varied, [[0.5, 0.1], [0.5, 0.145], [0.6, 0.1], [0.6, 0.145]][position / 2]);
        assert!(row["folder"] == format!("{:06}-{scenario}", position / 2) && row["problem"].is_empty(), "{row:?}");
        let own = |table: &str| {
            let rows = bench.table(&format!("out/{}/{table}", row["folder"]));
            rows.into_iter().rfind(|other| other["method"] == method).unwrap()
        };
        let number = |row: &std::collections::HashMap<String, String>, name: &str| row[name].parse::<f64>().unwrap();
        for name in ["t_yr", "mean_phi_rad", "std_phi_rad", "mean_e", "std_e", "prob_above_critical_e"] {
            assert_eq!(number(row, name), number(&own("moments.csv"), name), "{name}");
        }
        for name in ["prob_reached_critical_e", "low"] {
            let (sweep, own) = (number(row, name), number(&own("first_passage.csv"), name));
            assert!(sweep == own || (sweep.is_nan() && own.is_nan()), "{name}: {sweep} {own}");
        }
        assert!(page.contains(&format!("href=\"{}/\"", row["folder"])), "{page}");
    }
    assert!(page.contains("4 of 4 combinations") && page.contains("initial.e"), "{page}");
}

#[test]
fn a_case_that_fails_in_a_sweep_is_named_in_the_table_and_in_the_exit_code() {
    let bench = Bench::new();
    let broken = "[[propagator]]\nlabel = \"broken\"\ncommand = [\"false\"]\n";
    let launch = bench.launch_file("small", &format!("restart = \"never\"\n{SMALL}{broken}"));
    let sweep = sweep(&bench, "\"initial.e\" = [0.1, 0.145]");
    let mut command = bench.phasecloud();
    let output = command.arg("serve").arg(&launch).arg("--sweep").arg(sweep).args(["--out", "out"]).output().unwrap();
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    for words in ["scenario-1-0, broken: ", "scenario-1-1, broken: ", "2 cases failed"] {
        assert!(errors.contains(words), "{words}: {errors}");
    }
    let rows = bench.table("out/sweep.csv");
    let failed: Vec<_> = rows.iter().filter(|row| row["method"] == "broken").collect();
    assert!(failed.len() == 2 && failed.iter().all(|row| row["problem"].contains("exit status: 1")), "{rows:?}");
    assert_eq!(rows.iter().filter(|row| row["problem"].is_empty()).count(), 4);
}

#[test]
fn a_sweep_that_is_stopped_says_what_it_has_not_done_and_vouches_for_what_it_has() {
    let bench = Bench::new();
    let launch = bench.launch_file("small", SMALL);
    let sweep = sweep(&bench, "\"initial.e\" = { from = 0.1, to = 0.2, count = 500 }");
    let mut command = bench.phasecloud();
    command.arg("serve").arg(&launch).arg("--sweep").arg(sweep).args(["--out", "out"]);
    let service = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let begun = Instant::now();
    while !bench.path("out/000001-scenario-1-001").exists() {
        assert!(begun.elapsed() < WATCHDOG, "nothing is recorded");
        std::thread::sleep(Duration::from_millis(5));
    }
    kill_process(Pid::from_child(&service), Signal::INT).unwrap();
    let output = service.wait_with_output().unwrap();
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{errors}");
    assert!(errors.contains("the results are not whole: the sweep was stopped; "), "{errors}");
    let rows = bench.table("out/sweep.csv");
    let left = rows.iter().filter(|row| row["problem"] == "not done: the sweep was stopped").count();
    assert!(left > 0 && errors.contains(&format!("{left} of its 500 combinations were not done")), "{left}: {errors}");
    assert_eq!(rows.len(), left + 2 * (500 - left));
    assert!(text(&bench.read("out/report.html")).contains("this is not the whole of it"));
    let manifest: serde_json::Value = serde_json::from_slice(&bench.read("out/manifest.json")).unwrap();
    assert_eq!((&manifest["complete"], manifest["folders"].as_array().unwrap().len()), (&false.into(), 500 - left));
    let verify = || {
        let output = bench.phasecloud().arg("verify").arg(bench.path("out")).output().unwrap();
        (output.status.code(), text(&output.stdout) + &text(&output.stderr))
    };
    assert_eq!(verify().0, Some(0), "{}", verify().1);
    std::fs::remove_file(bench.path("out/000000-scenario-1-000/moments.csv")).unwrap();
    std::fs::remove_dir_all(bench.path("out/000001-scenario-1-001")).unwrap();
    let (code, said) = verify();
    assert_eq!(code, Some(1), "{said}");
    for words in ["000000-scenario-1-000/moments.csv is missing", "000001-scenario-1-001 is missing"] {
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn a_sweep_has_room_for_the_snapshots_that_it_needs_unless_told_otherwise() {
    let bench = Bench::new();
    let launch = bench.launch_file("small", SMALL);
    let sweep = sweep(&bench, "\"times.step\" = [0.5, 0.1]");
    let serve = |more: &[&str], out: &str| {
        let mut command = bench.phasecloud();
        command.arg("serve").arg(&launch).arg("--sweep").arg(&sweep).args(["--out", out]).args(more);
        command.output().unwrap()
    };
    let output = serve(&[], "out");
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(bench.table("out/moments.csv").len(), 2 * (5 + 21));
    let output = serve(&["--most-snapshots", "20"], "few");
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains("times.step = 0.1: it has 21 snapshots, there is room for 20"), "{errors}");
    assert_eq!(bench.table("few/moments.csv").len(), 2 * 5);
}

#[test]
fn submit_returns_when_the_folder_is_sealed_and_says_how_its_cases_went() {
    let bench = Bench::new();
    let broken = "[[propagator]]\nlabel = \"broken\"\ncommand = [\"false\"]\n";
    let launch = bench.launch_file("small", &format!("restart = \"never\"\n{SMALL}{broken}"));
    let service = start(&bench, &launch);
    for position in 0..3 {
        let output = submit(&bench, &bench.path("scenario-1.toml"));
        // The folder is there and whole at once.
        let folder = bench.path(&format!("served/{position:06}-scenario-1"));
        let verified = bench.phasecloud().arg("verify").arg(&folder).output().unwrap();
        assert!(verified.status.success(), "{}", text(&verified.stderr));
        assert_eq!(output.status.code(), Some(1), "a case has failed");
        assert!(text(&output.stderr).contains("scenario-1, broken: "), "{}", text(&output.stderr));
    }
    let long = common::SCENARIO_1.replace("step = 0.5 ", "step = 0.1 ");
    let output = submit(&bench, &bench.write("long.toml", &long));
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("21 snapshots, there is room for 16"), "{}", text(&output.stderr));
    end(service);
    assert_eq!(submit(&bench, &bench.path("scenario-1.toml")).status.code(), Some(2), "there is no service");
}

#[test]
fn submit_ends_when_the_service_has_ended() {
    for (how, signal) in [("asked", Signal::INT), ("killed", Signal::KILL)] {
        let bench = Bench::new();
        // A case that never reports anything: the request is under way until the service ends.
        let silent = "[[propagator]]\nlabel = \"silent\"\ncommand = [\"sleep\", \"1000\"]\n";
        let mut service = start(&bench, &bench.launch_file("small", &format!("{SMALL}{silent}")));
        let mut command = bench.phasecloud();
        command.arg("submit").arg(bench.path("scenario-1.toml")).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut asking = command.spawn().unwrap();
        std::thread::sleep(Duration::from_secs(2));
        assert!(asking.try_wait().unwrap().is_none(), "{how}: it waits for the silent case");
        kill_process(Pid::from_child(&service), signal).unwrap();
        service.wait().unwrap();
        let ended = Instant::now();
        while asking.try_wait().unwrap().is_none() {
            assert!(ended.elapsed() < WATCHDOG, "{how}: submit does not end");
            std::thread::sleep(Duration::from_millis(20));
        }
        let output = asking.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{how}");
        let errors = text(&output.stderr);
        assert!(errors.contains("scenario-1: the service has ended"), "{how}: {errors}");
        assert!(bench.phasecloud().arg("clean").status().unwrap().success());
    }
}

#[test]
fn what_cannot_be_done_is_named_and_the_rest_of_a_sweep_is_done() {
    let bench = Bench::new();
    // Without oblateness and with so much radiation pressure, orbits reach e = 1.
    bench.write("scenario-1.toml", &common::SCENARIO_1.replace("0.40921", "0.0"));
    let launch = bench.launch_file("small", SMALL);
    let sweep = sweep(&bench, "\"orbit.radiation\" = [0.1, 3.0, 0.15]");
    let mut command = bench.phasecloud();
    let output = command.arg("serve").arg(&launch).arg("--sweep").arg(sweep).args(["--out", "out"]).output().unwrap();
    let errors = text(&output.stderr);
    assert!(errors.contains("scenario 1 of the sweep") && errors.contains("left the domain e < 1"), "{errors}");
    assert!(text(&output.stdout).contains("2 scenarios in"), "{}", text(&output.stdout));
    assert_eq!(output.status.code(), Some(1), "{errors}");
    let rows = bench.table("out/sweep.csv");
    assert_eq!(rows.len(), 2 * 2 + 1);
    let refused = &rows[2];
    assert!(refused["method"].is_empty() && refused["folder"].is_empty(), "{refused:?}");
    assert!(refused["orbit.radiation"] == "3" && refused["problem"].contains("orbit.radiation = 3: "), "{refused:?}");
    assert!(text(&bench.read("out/report.html")).contains("2 of 3 combinations"));
}

#[test]
fn a_service_answers_requests_also_after_a_process_was_killed_and_ends_on_request() {
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES);
    bench.run_well(&launch, "alone");
    let service = start(&bench, &launch);
    for position in 0..5 {
        let output = submit(&bench, &bench.path("scenario-1.toml"));
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(text(&output.stdout).contains(&format!("recorded as {position:06}-scenario-1")));
        let victim = ["mc", "estimator", "recorder", "scenario", "comparator"][position];
        let process = of_runs_below(&bench.path("")).into_iter().find(|process| process.label == victim).unwrap();
        signal(&process, Signal::KILL);
    }
    let bad = bench.write(
        "bad.toml",
        &common::SCENARIO_1.replace("radiation = 0.15", "radiation = 3.0").replace("0.40921", "0.0"),
    );
    let output = submit(&bench, &bad);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("left the domain"), "{}", text(&output.stderr));
    assert_eq!(end(service), Some(0));
    for position in 0..5 {
        for file in REPRODUCIBLE {
            let served = bench.read(&format!("served/{position:06}-scenario-1/{file}"));
            assert!(served == bench.read(&format!("alone/{file}")), "{position}: {file}");
        }
    }
    assert_eq!(bench.domains(), [""; 0]);
    let nobody = submit(&bench, &bench.path("scenario-1.toml"));
    assert!(text(&nobody.stderr).contains("no service that takes requests"), "{}", text(&nobody.stderr));
}

#[test]
fn each_of_several_who_ask_at_once_for_scenarios_of_one_name_gets_its_own() {
    let bench = Bench::new();
    let service = start(&bench, &bench.launch_file("small", SMALL));
    std::thread::scope(|scope| {
        for e in ["0.11", "0.12", "0.13"] {
            let bench = &bench;
            scope.spawn(move || {
                let mine = bench.write(&format!("mine-{e}.toml"), &common::SCENARIO_1.replace("0.145", e));
                let output = submit(bench, &mine);
                assert!(output.status.success(), "{}", text(&output.stderr));
                let said = text(&output.stdout);
                let folder = said
                    .split_whitespace()
                    .find(|word| word.contains("-scenario-1"))
                    .unwrap_or_else(|| panic!("{said}"));
                let name = folder.rsplit('/').next().unwrap().trim_end_matches([',', ';', '.']);
                let done = text(&bench.read(&format!("served/{name}/scenarios/scenario-1.toml")));
                let value = done.lines().find_map(|line| line.strip_prefix("e = ")).unwrap().trim().to_owned();
                assert_eq!(value.split(' ').next(), Some(e), "{said}");
            });
        }
    });
    assert_eq!(end(service), Some(0));
}

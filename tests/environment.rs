//! The surroundings of a run do not disturb it: variables, ignored signals, a program that is replaced, cleaners of the
//! temporary folder.
#![allow(missing_docs)]

mod common;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use common::processes::{Said, end_of, of_runs_below, signal, signal_child, wait_for};
use common::{Bench, REPRODUCIBLE, text};
use rustix::process::Signal;

const SMALL: &str = "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 2_000\n";

/// Starts a service by this command and waits until all its processes are ready.
fn serve(bench: &Bench, command: &mut Command) -> Child {
    command.arg("serve").arg(bench.launch_file("small", SMALL)).args(["--out", "served"]);
    let mut service = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    Said::by(service.stderr.take().unwrap()).wait_for("5 processes are ready");
    service
}

fn submit(bench: &Bench) -> Output {
    bench.phasecloud().args(["submit", "scenario-1.toml"]).output().unwrap()
}

fn end(service: &mut Child) {
    signal_child(service, Signal::INT);
    assert_eq!(end_of(service).code(), Some(0));
}

#[test]
fn variables_that_are_meant_for_the_processes_of_a_run_disturb_no_run_and_no_service() {
    let bench = Bench::new();
    bench.run_well(&bench.launch_file("small", SMALL), "plain");
    let all = [
        ("PHASECLOUD_LABEL", "mine"),
        ("PHASECLOUD_NODE", "mc"),
        ("PHASECLOUD_RUN_ID", "7"),
        ("PHASECLOUD_LAUNCHER", "1"),
        ("PHASECLOUD_SHARD", "1"),
        ("PHASECLOUD_SHARDS", "2"),
        ("PHASECLOUD_REDUCE", "1"),
        ("PHASECLOUD_ATTEMPT", "3"),
        ("PHASECLOUD_GRACE", "1000"),
        ("PHASECLOUD_ROOT", "/nowhere"),
        ("PHASECLOUD_PREFIX", "pc"),
    ];
    for (index, variables) in [&all[..1], &all[..]].into_iter().enumerate() {
        let out = format!("out-{index}");
        let mut command = bench.phasecloud();
        command.arg("run").arg(bench.path("small.toml")).args(["--out", &out]).envs(variables.iter().copied());
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        for file in REPRODUCIBLE {
            assert!(bench.read(&format!("{out}/{file}")) == bench.read(&format!("plain/{file}")), "{file}");
        }
    }
    let mut service = serve(&bench, bench.phasecloud().envs(all));
    let mut asks = bench.phasecloud();
    let output = asks.args(["submit", "scenario-1.toml"]).envs(all).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    end(&mut service);
}

/// Whether a process ignores SIGHUP, as the kernel says.
fn ignores_hangup(process: u32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap();
    u64::from_str_radix(mask.trim(), 16).unwrap() & 1 == 1
}

#[test]
fn a_hangup_that_is_ignored_stays_ignored_in_every_process_and_ends_no_service_otherwise() {
    let bench = Bench::new();
    let plain = bench.phasecloud();
    let surroundings = |command: &mut Command| {
        command.current_dir(bench.path(".")).env("TMPDIR", bench.path(".")).stdin(Stdio::null());
    };
    let mut command = Command::new("sh");
    command.args(["-c", "trap '' HUP; exec \"$@\"", "sh"]).arg(plain.get_program());
    surroundings(&mut command);
    let mut service = serve(&bench, &mut command);
    let processes = of_runs_below(&bench.path(""));
    assert_eq!(processes.len(), 5);
    assert!(ignores_hangup(service.id()));
    assert!(processes.iter().all(|process| ignores_hangup(process.pid as u32)), "{processes:?}");
    end(&mut service);

    std::fs::remove_dir_all(bench.path("served")).unwrap();
    // This test may itself have been started with the signal ignored.
    let mut command = Command::new("env");
    command.arg("--default-signal=HUP").arg(plain.get_program());
    surroundings(&mut command);
    let mut service = serve(&bench, &mut command);
    assert!(!ignores_hangup(service.id()));
    signal_child(&service, Signal::HUP);
    assert!(submit(&bench).status.success());
    end(&mut service);
}

#[test]
fn a_service_whose_program_has_been_replaced_starts_its_processes_from_the_one_that_it_is() {
    let bench = Bench::new();
    let program = bench.path("phasecloud");
    std::fs::copy(env!("CARGO_BIN_EXE_phasecloud"), &program).unwrap();
    let mut command = Command::new(&program);
    command.current_dir(bench.path(".")).env("TMPDIR", bench.path(".")).stdin(Stdio::null());
    let mut service = serve(&bench, &mut command);
    std::fs::remove_file(&program).unwrap();
    bench.write("phasecloud", "#!/bin/sh\nexit 7\n");
    for victim in ["mc", "estimator"] {
        let processes = of_runs_below(&bench.path(""));
        signal(processes.iter().find(|process| process.label == victim).unwrap(), Signal::KILL);
        let output = submit(&bench);
        assert!(output.status.success(), "{victim}: {}", text(&output.stderr));
    }
    end(&mut service);
    assert_eq!(bench.table("served/000001-scenario-1/moments.csv").len(), 5);
}

/// All plain files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let below = entries.flat_map(|entry| match entry.file_type().unwrap() {
        kind if kind.is_dir() => files(&entry.path()),
        kind if kind.is_file() => vec![entry.path()],
        _ => Vec::new(),
    });
    below.collect()
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn a_service_is_found_and_works_after_a_cleaner_has_been_in_the_temporary_folder() {
    let bench = Bench::new();
    let mut service = serve(&bench, &mut bench.phasecloud());
    let id = bench.domains().pop().unwrap();
    let user = bench.path(&format!("phasecloud-{}", rustix::process::getuid().as_raw()));
    let notice = user.join(&id).join("run.json");
    let is_fresh = |file: &Path| {
        let age = file.metadata().and_then(|data| data.modified()).ok()?.elapsed().unwrap_or_default();
        (age.as_secs() < 3600).then_some(())
    };
    // To a cleaner the files seem to be 20 days old; the launcher renews their times before a cleaner comes.
    let old = std::time::SystemTime::now() - std::time::Duration::from_secs(20 * 86_400);
    let dated = files(&user);
    for file in &dated {
        std::fs::File::open(file).unwrap().set_modified(old).unwrap();
    }
    assert!(dated.len() > 20);
    wait_for("they stay old", || {
        dated.iter().filter(|file| file.exists()).all(|file| is_fresh(file).is_some()).then_some(())
    });
    // A cleaner that removes all that it can, all the same.
    files(&user).iter().for_each(|file| std::fs::remove_file(file).unwrap());
    wait_for("the notice does not come back", || notice.exists().then_some(()));
    let topics = text(&bench.phasecloud().arg("topics").output().unwrap().stdout);
    assert!(topics.contains(&id), "{topics}");
    let cleaned = text(&bench.phasecloud().arg("clean").output().unwrap().stdout);
    assert!(cleaned.contains("in use") && !cleaned.contains("removed"), "{cleaned}");
    for victim in ["", "mc", "recorder"] {
        if let Some(process) = of_runs_below(&bench.path("")).iter().find(|process| process.label == victim) {
            signal(process, Signal::KILL);
        }
        let output = submit(&bench);
        assert!(output.status.success(), "{victim}: {}", text(&output.stderr));
    }
    end(&mut service);
    assert_eq!(bench.domains(), [""; 0]);
    assert_eq!(common::shared_memory_of(&id), [""; 0]);
}

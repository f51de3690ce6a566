//! A run is its user's alone.
#![allow(missing_docs)]

mod common;

use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::Bench;
use rustix::process::{Pid, Signal, kill_process};

/// Only to end a test that would hang.
const WATCHDOG: Duration = Duration::from_secs(60);

/// Whether `nobody` can do what the command says; `None` if this user cannot become nobody.
fn nobody_can(command: &[&str]) -> Option<bool> {
    let as_nobody = |command: &[&str]| {
        let mut switch = Command::new("setpriv");
        switch.args(["--reuid=65534", "--regid=65534", "--clear-groups"]).args(command);
        switch.stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|status| status.success())
    };
    as_nobody(&["true"]).then(|| as_nobody(command))
}

#[test]
fn folder_and_shared_memory_of_a_run_are_open_to_their_owner_alone() {
    let bench = Bench::new();
    let launch = bench.launch_file("long", "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 20_000_000\n");
    let mut child = bench.phasecloud();
    let mut child = child.arg("run").arg(launch).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let started = Instant::now();
    // All five processes hold files in shared memory once the estimator reads what the propagator sends.
    let (run_id, files) = loop {
        assert!(started.elapsed() < WATCHDOG, "the run did not start");
        std::thread::sleep(Duration::from_millis(50));
        let Some(run_id) = bench.domains().pop() else { continue };
        let files = common::shared_memory_of(&run_id);
        if files.iter().filter(|name| name.ends_with(".data")).count() >= 5 {
            break (run_id, files);
        }
    };
    let user = bench.path(&format!("phasecloud-{}", rustix::process::getuid().as_raw()));
    let root = user.join(&run_id);
    assert_eq!((user.metadata().unwrap().mode() & 0o777, root.metadata().unwrap().mode() & 0o777), (0o700, 0o700));
    for file in &files {
        // A file may be gone again by now.
        let Ok(metadata) = Path::new("/dev/shm").join(file).metadata() else { continue };
        assert_eq!(metadata.mode() & 0o077, 0, "{file} has mode {:o}", metadata.mode());
        assert_eq!(metadata.uid(), rustix::process::getuid().as_raw());
    }
    let file = format!("/dev/shm/{}", files.iter().find(|name| name.ends_with(".data")).unwrap());
    match nobody_can(&["head", "-c", "1", &file]) {
        Some(can) => {
            assert!(!can, "nobody can read {file}");
            assert_eq!(nobody_can(&["ls", &root.to_string_lossy()]), Some(false));
            assert_eq!(nobody_can(&["rm", "-f", &file]), Some(false));
        }
        None => println!("skipped: only root can become another user"),
    }
    kill_process(Pid::from_child(&child), Signal::TERM).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));
}

#[test]
fn a_domain_that_another_user_has_prepared_is_not_entered() {
    let bench = Bench::new();
    let user = bench.path(&format!("phasecloud-{}", rustix::process::getuid().as_raw()));
    std::fs::create_dir(&user).unwrap();
    if std::os::unix::fs::chown(&user, Some(65534), None).is_err() {
        println!("skipped: only root can give folders away");
        return;
    }
    let output = bench.run(&bench.launch_file("four", common::FOUR_CASES), "out");
    let errors = common::text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains("not a folder that its user alone can enter"), "{errors}");
}

#[test]
fn names_in_files_cannot_leave_the_results_folder() {
    let bench = Bench::new();
    for (from, to) in
        [("label = \"mc\"", "label = \"../mc\""), ("name = \"", "name = \"/tmp/"), ("name = \"", "name = \"..")]
    {
        let launch = bench.launch_file("four", common::FOUR_CASES);
        let text = std::fs::read_to_string(&launch).unwrap().replacen(from, to, 1);
        std::fs::write(&launch, text).unwrap();
        assert_eq!(bench.run(&launch, "out").status.code(), Some(2));
    }
    let hostile = common::SCENARIO_1.replace("name = \"scenario-1\"", "name = \"../../../escaped\"");
    bench.write("scenario-1.toml", &hostile);
    assert_eq!(bench.run(&bench.launch_file("four", common::FOUR_CASES), "out").status.code(), Some(2));
    assert!(!bench.path("out").exists());
}

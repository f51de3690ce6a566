//! Nobody but its user can reach a run.
#![allow(missing_docs)]

mod common;

use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use common::processes::{Process, of_runs_below, signal};
use common::{Bench, FOUR_CASES, REPRODUCIBLE, text};
use rustix::process::{Pid, Signal, kill_process};

/// Only ends a test that would hang.
const WATCHDOG: Duration = Duration::from_secs(180);

/// Users that own nothing.
const USERS: [u32; 2] = [65534, 65533];

/// A command that is run as another user; only root can.
fn as_user(user: u32, program: impl AsRef<std::ffi::OsStr>) -> Command {
    let mut switch = Command::new("setpriv");
    switch.args([format!("--reuid={user}"), format!("--regid={user}"), "--clear-groups".into()]).arg(program);
    switch.stdin(Stdio::null());
    switch
}

/// Whether the user can do what the command does; `None` if this user cannot become the other.
fn can(user: u32, command: &[&str]) -> Option<bool> {
    let succeeds = |command: &[&str]| {
        let mut switched = as_user(user, command[0]);
        let switched = switched.args(&command[1..]).stdout(Stdio::null()).stderr(Stdio::null());
        switched.status().is_ok_and(|status| status.success())
    };
    succeeds(&["true"]).then(|| succeeds(command))
}

/// A run of a user whose estimator is stopped, so that it is under way for as long as the test needs.
struct Held {
    user: u32,
    run: Child,
    folder: std::path::PathBuf,
    run_id: String,
    estimator: Process,
}

impl Held {
    fn start(bench: &Bench, user: u32, launch: &Path) -> Self {
        let folder = bench.path(&format!("phasecloud-{user}"));
        let mut command = as_user(user, bench.path("phasecloud"));
        command.current_dir(bench.path(".")).env("TMPDIR", bench.path("")).env("HOME", "/nonexistent");
        command.arg("run").arg(launch).args(["--quiet", "--out", &format!("out-{user}")]);
        let run = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let started = Instant::now();
        let estimator = loop {
            assert!(started.elapsed() < WATCHDOG, "the run of {user} did not start");
            if let Some(found) = of_runs_below(&folder).into_iter().find(|process| process.label == "estimator") {
                break found;
            }
        };
        signal(&estimator, Signal::STOP);
        let run_id = std::fs::read_dir(&folder).unwrap().flatten().next().unwrap().file_name();
        Self { user, run, folder, run_id: run_id.to_string_lossy().into_owned(), estimator }
    }

    /// Domain and shared memory can be neither read nor removed by `other`, who does not even see that there is a run.
    fn check_closed_to(&self, bench: &Bench, other: u32) {
        let domain = self.folder.join(&self.run_id).display().to_string();
        let files = common::shared_memory_of(&self.run_id);
        assert!(!files.is_empty());
        let paths: Vec<_> = files.iter().map(|file| format!("/dev/shm/{file}")).chain([domain]).collect();
        for path in &paths {
            let Ok(metadata) = Path::new(path).symlink_metadata() else { continue };
            assert_eq!((metadata.uid(), metadata.mode() & 0o077), (self.user, 0), "{path}");
        }
        let script = "for f do test -e $f && { test -r $f || test -w $f || rm -rf $f; } && echo $f; done";
        let output = as_user(other, "sh").args(["-c", script, "sh"]).args(&paths).output().unwrap();
        assert_eq!(text(&output.stdout), "", "{other} can read, write or remove");
        assert!(text(&output.stderr).contains("cannot remove"), "{other} has not tried");
        let clean =
            as_user(other, bench.path("phasecloud")).arg("clean").env("TMPDIR", bench.path("")).output().unwrap();
        let said = text(&clean.stdout) + &text(&clean.stderr);
        assert!(clean.status.success() && !said.contains(&self.run_id), "{said}");
    }
}

#[test]
fn runs_of_two_users_at_the_same_time_never_meet() {
    let bench = Bench::new();
    if can(USERS[0], &["true"]).is_none() {
        println!("skipped: only root can become another user");
        return;
    }
    // The same as for /tmp: everybody can write, nobody can remove the files of others.
    let open_to_all = |name: &str, mode| {
        std::fs::set_permissions(bench.path(name), std::fs::Permissions::from_mode(mode)).unwrap();
    };
    std::fs::copy(env!("CARGO_BIN_EXE_phasecloud"), bench.path("phasecloud")).unwrap();
    let launch = bench.launch_file("four", FOUR_CASES);
    bench.run_well(&launch, "alone");
    for (name, mode) in [("", 0o1777), ("phasecloud", 0o755), ("four.toml", 0o644), ("scenario-1.toml", 0o644)] {
        open_to_all(name, mode);
    }
    let [one, two] = USERS.map(|user| Held::start(&bench, user, &launch));
    one.check_closed_to(&bench, two.user);
    two.check_closed_to(&bench, one.user);
    for held in [one, two] {
        signal(&held.estimator, Signal::CONT);
        let output = held.run.wait_with_output().unwrap();
        assert!(output.status.success(), "{}: {}", held.user, text(&output.stderr));
        for file in REPRODUCIBLE {
            let same = bench.read(&format!("out-{}/{file}", held.user)) == bench.read(&format!("alone/{file}"));
            assert!(same, "{}: {file}", held.user);
        }
        assert_eq!(common::shared_memory_of(&held.run_id), [""; 0]);
        assert_eq!(std::fs::read_dir(&held.folder).unwrap().count(), 0);
    }
}

#[test]
fn folder_and_shared_memory_of_a_run_are_open_to_their_owner_alone() {
    let bench = Bench::new();
    let launch = bench.launch_file("long", "[[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 20_000_000\n");
    let mut child = bench.phasecloud();
    let mut child = child.arg("run").arg(launch).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let started = Instant::now();
    // All five processes hold files in shared memory once the estimator reads the propagator's messages.
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
        // A file may have been removed meanwhile.
        let Ok(metadata) = Path::new("/dev/shm").join(file).metadata() else { continue };
        assert_eq!(metadata.mode() & 0o077, 0, "{file} has mode {:o}", metadata.mode());
        assert_eq!(metadata.uid(), rustix::process::getuid().as_raw());
    }
    let file = format!("/dev/shm/{}", files.iter().find(|name| name.ends_with(".data")).unwrap());
    match can(USERS[0], &["head", "-c", "1", &file]) {
        Some(readable) => {
            assert!(!readable, "nobody can read {file}");
            assert_eq!(can(USERS[0], &["ls", &root.to_string_lossy()]), Some(false));
            assert_eq!(can(USERS[0], &["rm", "-f", &file]), Some(false));
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
    let output = bench.run(&bench.launch_file("four", FOUR_CASES), "out");
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(errors.contains("not a folder that its user alone can enter"), "{errors}");
}

#[test]
fn names_in_files_cannot_leave_the_results_folder() {
    let bench = Bench::new();
    for (from, to) in
        [("label = \"mc\"", "label = \"../mc\""), ("name = \"", "name = \"/tmp/"), ("name = \"", "name = \"..")]
    {
        let launch = bench.launch_file("four", FOUR_CASES);
        let text = std::fs::read_to_string(&launch).unwrap().replacen(from, to, 1);
        std::fs::write(&launch, text).unwrap();
        assert_eq!(bench.run(&launch, "out").status.code(), Some(2));
    }
    let hostile = common::SCENARIO_1.replace("name = \"scenario-1\"", "name = \"../../../escaped\"");
    bench.write("scenario-1.toml", &hostile);
    assert_eq!(bench.run(&bench.launch_file("four", FOUR_CASES), "out").status.code(), Some(2));
    assert!(!bench.path("out").exists());
}

//! Limits of the machine: a clear error, a clean domain, and an exit code as `--help` says.
//!
//! File systems that are small or read-only are mounted in a mount namespace of the test's own; where that is not allowed, the
//! tests say so and are skipped, unless `PHASECLOUD_REQUIRE_NAMESPACES=1`.
#![allow(missing_docs)]

mod common;

use std::path::Path;
use std::process::{Command, Output, Stdio};

use common::{Bench, FOUR_CASES, text};

/// `phasecloud run` after `preparation`, in a shell in a mount namespace of its own if `mounts`.
fn run_prepared(bench: &Bench, preparation: &str, mounts: bool, launch: &Path, out: &str) -> Output {
    let mut command = match mounts {
        true => Command::new("unshare"),
        false => Command::new("sh"),
    };
    if mounts {
        command.args(["-rm", "sh"]);
    }
    command.arg("-c").arg(format!("{preparation} && exec \"$@\"")).arg("sh");
    command.arg(env!("CARGO_BIN_EXE_phasecloud")).arg("run").arg(launch).arg("--out").arg(bench.path(out));
    command.current_dir(bench.path(".")).env("TMPDIR", bench.path(".")).stdin(Stdio::null());
    command.output().unwrap()
}

/// Whether file systems can be mounted here; says so if not.
fn can_mount() -> bool {
    let probe = Command::new("unshare").args(["-rm", "mount", "-t", "tmpfs", "tmpfs", "/mnt"]).output();
    let can = probe.is_ok_and(|output| output.status.success());
    assert!(can || std::env::var("PHASECLOUD_REQUIRE_NAMESPACES").is_err(), "mount namespaces are required");
    if !can {
        println!("skipped: no mount namespaces here");
    }
    can
}

/// The run fails as it should: exit code, words, no results, no domain, nothing in shared memory.
fn check(bench: &Bench, output: &Output, code: i32, words: &[&str], out: &str) {
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{errors}");
    assert!(words.iter().any(|words| errors.contains(words)), "{errors}");
    assert!(!bench.path(out).join("manifest.json").exists());
    let left: Vec<_> = std::fs::read_dir(bench.path(".")).unwrap().flatten().map(|entry| entry.file_name()).collect();
    assert!(!left.iter().any(|name| name.to_string_lossy().contains("partial")), "{left:?}");
    assert_eq!(bench.domains(), [""; 0]);
}

#[test]
fn shared_memory_that_is_too_small_is_refused() {
    if can_mount() {
        let bench = Bench::new();
        let launch = bench.launch_file("four", FOUR_CASES);
        let output = run_prepared(&bench, "mount -t tmpfs -o size=4m tmpfs /dev/shm", true, &launch, "out");
        check(&bench, &output, 2, &["/dev/shm has 4 MiB free"], "out");
    }
}

#[test]
fn shared_memory_that_is_filled_during_the_run_ends_it_by_name() {
    if can_mount() {
        let bench = Bench::new();
        let fill = "head -c 100m /dev/zero > /dev/shm/fill; exit 3";
        let cases = format!("{FOUR_CASES}[[propagator]]\nlabel = \"filler\"\ncommand = [\"sh\", \"-c\", \"{fill}\"]\n");
        let launch = bench.launch_file("filled", &cases);
        let output = run_prepared(&bench, "mount -t tmpfs -o size=40m tmpfs /dev/shm", true, &launch, "out");
        let errors = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{errors}");
        assert!(errors.contains("/dev/shm has run full"), "{errors}");
        assert_eq!(bench.domains(), [""; 0]);
    }
}

#[test]
fn a_read_only_or_full_output_disk_is_told() {
    if can_mount() {
        let bench = Bench::new();
        let launch = bench.launch_file("four", FOUR_CASES);
        std::fs::create_dir(bench.path("disk")).unwrap();
        let mount = |options: &str| format!("mount -t tmpfs -o {options} tmpfs {}", bench.path("disk").display());
        let output = run_prepared(&bench, &mount("ro"), true, &launch, "disk/out");
        check(&bench, &output, 2, &["Read-only file system"], "disk/out");
        let output = run_prepared(&bench, &mount("size=256k"), true, &launch, "disk/out");
        check(&bench, &output, 1, &["No space left on device"], "disk/out");
    }
}

#[test]
fn too_few_file_descriptors_are_refused() {
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES);
    let output = run_prepared(&bench, "ulimit -n 100", false, &launch, "out");
    check(&bench, &output, 2, &["file descriptors a process, 100 are allowed"], "out");
}

#[test]
fn a_case_that_is_refused_memory_is_named_and_the_others_are_compared() {
    let bench = Bench::new();
    let big = "[[propagator]]\nlabel = \"big\"\nnode = \"mc\"\nsamples = 20_000_000\n";
    let launch = bench.launch_file("big", &format!("{FOUR_CASES}{big}"));
    let output = run_prepared(&bench, "ulimit -v 1500000", false, &launch, "out");
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains("big: "), "{errors}");
    assert_eq!(bench.table("out/moments.csv").len(), 20, "{errors}");
    assert_eq!(bench.domains(), [""; 0]);
}

/// A shell command that may not have more than a few processes and threads: as root, which no such limit holds for, as nobody.
fn with_few_processes(bench: &Bench, most: u32) -> Command {
    let is_root = rustix::process::getuid().is_root();
    let mut command = Command::new(if is_root { "setpriv" } else { "prlimit" });
    if is_root {
        let own = Command::new("chown").args(["-R", "65534:65534"]).arg(bench.path(".")).status().unwrap();
        assert!(own.success());
        command.args(["--reuid=65534", "--regid=65534", "--clear-groups", "prlimit"]);
    }
    command.arg(format!("--nproc={most}")).current_dir(bench.path(".")).env("TMPDIR", bench.path("."));
    command.stdin(Stdio::null());
    command
}

#[test]
fn too_few_processes_or_too_little_address_space_are_told_in_words() {
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES);
    let program = bench.path("phasecloud");
    std::fs::copy(env!("CARGO_BIN_EXE_phasecloud"), &program).unwrap();
    // What suffices on one machine does not on another: whole results, or an error in words and none.
    let told = |output: &Output, what: &str| {
        let errors = text(&output.stderr);
        assert!(matches!(output.status.code(), Some(0..=2)), "{what}: {:?} {errors}", output.status);
        assert!(!errors.contains("panicked"), "{what}: {errors}");
        assert!(output.status.success() || errors.contains("error: "), "{what}: {errors}");
        assert_eq!(bench.domains(), [""; 0], "{what}");
        let _ = std::fs::remove_dir_all(bench.path("out"));
        output.status.success()
    };
    for kilobytes in [100_000, 60_000] {
        let output = run_prepared(&bench, &format!("ulimit -v {kilobytes}"), false, &launch, "out");
        told(&output, &format!("ulimit -v {kilobytes}"));
    }
    for most in [1, 3, 10] {
        let mut command = with_few_processes(&bench, most);
        let output = command.arg(&program).arg("run").arg(&launch).args(["--out", "out"]).output().unwrap();
        assert!(!told(&output, &format!("ulimit -u {most}")), "ulimit -u {most} suffices for eight processes");
    }
}

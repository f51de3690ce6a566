//! Limits of the machine: a clear error, a clean domain, and an exit code as `--help` says.
//!
//! File systems that are small or read-only are mounted in a mount namespace of the test's own; where that is not
//! allowed, the tests say so and are skipped, unless `PHASECLOUD_REQUIRE_NAMESPACES=1`.
#![allow(missing_docs)]

mod common;

use std::path::Path;
use std::process::{Command, Output, Stdio};

use common::{Bench, FOUR_CASES, text};

/// `phasecloud run` after `preparation`, in a shell, which is in a mount namespace of its own if `mounts`.
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

/// Whether file systems can be mounted here; prints that the test is skipped if not.
fn can_mount() -> bool {
    let probe = Command::new("unshare").args(["-rm", "mount", "-t", "tmpfs", "tmpfs", "/mnt"]).output();
    let can = probe.is_ok_and(|output| output.status.success());
    assert!(can || std::env::var("PHASECLOUD_REQUIRE_NAMESPACES").is_err(), "mount namespaces are required");
    if !can {
        println!("skipped: no mount namespaces here");
    }
    can
}

/// The run fails as it should: exit code, message, no results, no domain, nothing in shared memory.
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
fn a_mount_point_is_filled_also_in_a_parent_that_cannot_be_written() {
    if can_mount() {
        let bench = Bench::new();
        let launch = bench.launch_file("four", FOUR_CASES);
        std::fs::create_dir_all(bench.path("parent")).unwrap();
        // The parent is a disk that becomes read-only once the mount point is there; the mount can be seen only from
        // inside the namespace.
        let (parent, out) = (bench.path("parent"), bench.path("parent/out"));
        let (parent, out) = (parent.display(), out.display());
        let mounts = format!(
            "mount -t tmpfs tmpfs {parent} && mkdir {out} && mount -t tmpfs -o size=64m tmpfs {out} && mount -o remount,ro {parent}"
        );
        let mut command = Command::new("unshare");
        let program = env!("CARGO_BIN_EXE_phasecloud");
        let shell = format!(
            "{mounts} && {program} run {} --out {out} && {program} verify {out} && ls -A {out} && ls -A {parent}",
            launch.display()
        );
        command.args(["-rm", "sh", "-c", &shell]).current_dir(bench.path(".")).env("TMPDIR", bench.path("."));
        let output = command.stdin(Stdio::null()).output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        let said = text(&output.stdout);
        assert!(said.contains("parent/out: good") && said.contains("manifest.json"), "{said}");
        assert!(!said.contains("partial"), "{said}");

        let read_only = format!("mount -t tmpfs -o ro tmpfs {parent}");
        let output = run_prepared(&bench, &read_only, true, &launch, "parent");
        check(&bench, &output, 2, &["Read-only file system"], "parent");
        assert!(!text(&output.stderr).contains("ready"), "nothing has been computed");
    }
}

/// The disk becomes full somewhere between the first file and the last: whatever is sealed is whole.
#[test]
#[ignore = "long; .ci/long runs it"]
fn no_half_of_a_file_is_sealed_however_much_of_the_results_the_disk_can_hold() {
    if !can_mount() {
        return;
    }
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES);
    std::fs::create_dir(bench.path("disk")).unwrap();
    let disk = bench.path("disk");
    let disk = disk.display();
    let program = env!("CARGO_BIN_EXE_phasecloud");
    let mut outcomes = std::collections::BTreeSet::new();
    for size in ["1200k", "2200k", "2800k", "3400k", "4000k", "5200k", "64m"] {
        let kept = bench.path(&format!("kept-{size}"));
        // The results are copied from the disk, which disappears with the namespace.
        let shell = format!(
            "mount -t tmpfs -o size={size} tmpfs {disk}; {program} run {} --out {disk}/out; code=$?; cp -r {disk} {}; exit $code",
            launch.display(),
            kept.display()
        );
        let mut command = Command::new("unshare");
        command.args(["-rm", "sh", "-c", &shell]).current_dir(bench.path(".")).env("TMPDIR", bench.path("."));
        let output = command.stdin(Stdio::null()).output().unwrap();
        let errors = text(&output.stderr);
        let out = kept.join("out");
        let is_sealed = out.join("manifest.json").exists();
        outcomes.insert((is_sealed, out.join("report.html").exists()));
        assert_eq!(output.status.success(), is_sealed, "{size}: {errors}");
        assert!(
            is_sealed && out.join("report.html").exists() || errors.contains("No space left on device"),
            "{size}: {errors}"
        );
        if is_sealed {
            let verified = bench.phasecloud().arg("verify").arg(&out).output().unwrap();
            assert!(verified.status.success(), "{size}: {}", text(&verified.stderr));
            assert_whole(&out, size);
        }
    }
    assert!(outcomes.contains(&(false, false)) && outcomes.contains(&(true, true)), "{outcomes:?}");
}

/// Every file has the ending that files of its kind have.
fn assert_whole(folder: &Path, size: &str) {
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            assert_whole(&path, size);
            continue;
        }
        let content = std::fs::read(&path).unwrap();
        let text = String::from_utf8_lossy(&content);
        let is_whole = match path.extension().and_then(|extension| extension.to_str()).unwrap_or("") {
            "svg" => text.trim_end().ends_with("</svg>"),
            "html" => text.trim_end().ends_with("</html>"),
            "json" => serde_json::from_slice::<serde_json::Value>(&content).is_ok(),
            "npz" => content.windows(4).rev().take(100).any(|bytes| bytes == b"PK\x05\x06"),
            "csv" | "jsonl" | "toml" => text.ends_with('\n'),
            other => panic!("{other}: {}", path.display()),
        };
        assert!(is_whole, "{size}: {} is a half", path.display());
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
fn files_that_may_not_be_as_long_as_those_of_a_run_are_refused() {
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES);
    let output = run_prepared(&bench, "ulimit -f 1", false, &launch, "out");
    check(&bench, &output, 2, &["raise the limit (ulimit -f)"], "out");
}

#[test]
#[ignore = "long; .ci/long runs it"]
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

/// A shell command that may have only a few processes and threads; run by root, for whom such limits do not hold, it
/// runs as nobody.
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
fn too_few_processes_and_too_little_memory_are_told_in_words() {
    let bench = Bench::new();
    let launch = bench.launch_file("four", FOUR_CASES);
    let program = bench.path("phasecloud");
    std::fs::copy(env!("CARGO_BIN_EXE_phasecloud"), &program).unwrap();
    // A limit that suffices on one machine does not on another: the run gives whole results, or an error message and no
    // results.
    let told = |output: &Output, what: &str| {
        let errors = text(&output.stderr);
        assert!(matches!(output.status.code(), Some(0..=2)), "{what}: {:?} {errors}", output.status);
        assert!(!errors.contains("panicked"), "{what}: {errors}");
        assert!(output.status.success() || errors.contains("error: "), "{what}: {errors}");
        assert_eq!(bench.domains(), [""; 0], "{what}");
        let _ = std::fs::remove_dir_all(bench.path("out"));
        output.status.success()
    };
    for limit in ["-v 60000", "-v 300000", "-s 64", "-s 256", "-d 40000"] {
        let output = run_prepared(&bench, &format!("ulimit {limit}"), false, &launch, "out");
        assert!(!told(&output, limit), "{limit}");
        assert!(text(&output.stderr).contains(&format!("raise the limit (ulimit {})", &limit[..2])), "{limit}");
    }
    for most in [1, 3, 10] {
        let mut command = with_few_processes(&bench, most);
        let output = command.arg(&program).arg("run").arg(&launch).args(["--out", "out"]).output().unwrap();
        assert!(!told(&output, &format!("ulimit -u {most}")), "ulimit -u {most} suffices for eight processes");
    }
}

//! Programs that play a propagator in a test: examples of this package, which are built with it.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::time::SystemTime;

/// An example's program. `cargo test` has built it; `cargo test --test NAME` builds only the test, so that the program
/// may be absent, or older than its sources: it is built here then.
pub fn example(name: &str) -> PathBuf {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let program = Path::new(env!("CARGO_BIN_EXE_phasecloud")).with_file_name("examples").join(name);
    let _guard = ONE_AT_A_TIME.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    if !is_up_to_date(&program) {
        build(name, program.parent().and_then(Path::parent).unwrap());
    }
    assert!(program.exists(), "{} was not built", program.display());
    program
}

/// Whether a program is there and none of its sources, which Cargo lists in a file beside it, has been changed since it
/// was built.
fn is_up_to_date(program: &Path) -> bool {
    let changed = |path: &Path| path.metadata().and_then(|about| about.modified()).ok();
    let sources = std::fs::read_to_string(program.with_extension("d")).unwrap_or_default();
    let sources = sources.lines().next().and_then(|line| line.split_once(": ")).map_or("", |(_, sources)| sources);
    let is_older =
        |built: SystemTime| sources.split(' ').all(|path| changed(Path::new(path)).is_some_and(|at| at <= built));
    !sources.is_empty() && changed(program).is_some_and(is_older)
}

/// Builds into the folder of the program under test, whose parent is the target folder.
fn build(name: &str, profile: &Path) {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(env!("CARGO_MANIFEST_DIR")).args(["build", "--quiet", "--example", name]);
    cargo.arg("--target-dir").arg(profile.parent().unwrap());
    if profile.ends_with("release") {
        cargo.arg("--release");
    }
    if cfg!(feature = "hosts") {
        cargo.args(["--features", "hosts"]);
    }
    assert!(cargo.status().unwrap().success(), "the example {name} does not build");
}

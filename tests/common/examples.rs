//! Programs that play a propagator in a test: examples of this package, which are built with it.

use std::path::{Path, PathBuf};
use std::process::Command;

/// An example's program. `cargo test` has built it; `cargo test --test NAME` builds only the test, so it is built here.
pub fn example(name: &str) -> PathBuf {
    let program = Path::new(env!("CARGO_BIN_EXE_phasecloud")).with_file_name("examples").join(name);
    if !program.exists() {
        build(name, program.parent().and_then(Path::parent).unwrap());
    }
    assert!(program.exists(), "{} was not built", program.display());
    program
}

/// Builds into the folder of the program under test, whose parent is the target folder.
fn build(name: &str, profile: &Path) {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(env!("CARGO_MANIFEST_DIR")).args(["build", "--quiet", "--example", name]);
    cargo.arg("--target-dir").arg(profile.parent().unwrap());
    if profile.ends_with("release") {
        cargo.arg("--release");
    }
    assert!(cargo.status().unwrap().success(), "the example {name} does not build");
}

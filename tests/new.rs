//! `phasecloud new`: its crate builds, and it writes the programs that `tests/check.rs` and `tests/python/` check.
#![allow(missing_docs)]

mod common;

use std::path::Path;
use std::process::Command;

use common::{Bench, text};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn source(path: &str) -> String {
    std::fs::read_to_string(Path::new(ROOT).join(path)).unwrap()
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn a_new_crate_compiles_and_is_the_skeleton_that_is_checked() {
    let bench = Bench::new();
    let output = bench.phasecloud().args(["new", "my-method"]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("phasecloud check -- my-method/target/release/my-method"));
    // The example `skeleton` is built from this file, and tests/check.rs runs it.
    let written = text(&bench.read("my-method/src/main.rs"));
    assert_eq!(written, source("launch/new/main.rs").replace("NAME", "my-method"));
    // This program's own target folder is used, in which most has been compiled before.
    let build = Command::new(env!("CARGO"))
        .args(["check", "--offline", "--manifest-path"])
        .arg(bench.path("my-method/Cargo.toml"))
        .env("CARGO_TARGET_DIR", Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap())
        .output()
        .unwrap();
    assert!(build.status.success(), "{}", text(&build.stderr));
}

#[test]
fn a_new_python_propagator_is_the_example_with_its_kit() {
    let bench = Bench::new();
    let output = bench.phasecloud().args(["new", "--python", "mine.py"]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    // tests/python/ checks the example, and that these files keep all rules without the package.
    for (written, original) in [
        ("propagator.py", "examples/python/monte_carlo.py"),
        ("phasecloud_kit.py", "python/phasecloud/kit/__init__.py"),
        ("phasecloud_layout.py", "python/phasecloud/kit/layout.py"),
        ("requirements.txt", "examples/python/requirements.txt"),
    ] {
        let (written, original) = (text(&bench.read(&format!("mine.py/{written}"))), source(original));
        assert_eq!(written.lines().count(), original.lines().count());
        let differ = written.lines().zip(original.lines()).filter(|(written, original)| written != original);
        for (written, original) in differ {
            assert!(written.contains("import") && original.contains("import"), "{written} instead of {original}");
        }
    }
}

#[test]
fn nothing_is_overwritten_and_names_are_checked() {
    let bench = Bench::new();
    bench.write("taken", "mine");
    for (name, told) in [
        ("taken", "taken is there already"),
        ("taken/mine", "there is no folder taken; make it first"),
        ("nowhere/mine", "there is no folder nowhere; make it first"),
        ("-", "the last part of the path is the propagator's name, and it must be 1 to 31 letters"),
        ("sub/a b", "\"sub/a b\" is not allowed"),
        ("1st", "must start with a letter"),
        ("..", "\"..\" is not allowed"),
        ("", "a value is required"),
        ("deps", "take another, like my-deps"),
        ("fn", "like my-fn"),
        ("nodes", "like my-nodes"),
    ] {
        let output = bench.phasecloud().args(["new", "--", name]).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{name}");
        assert!(text(&output.stderr).contains(told), "{}", text(&output.stderr));
    }
    assert_eq!(bench.read("taken"), b"mine");
}

#[test]
fn a_path_may_lead_to_it_and_its_last_part_is_the_name() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("sub")).unwrap();
    let output = bench.phasecloud().args(["new", "sub/mine/"]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&bench.read("sub/mine/Cargo.toml")).contains("name = \"mine\""));
}

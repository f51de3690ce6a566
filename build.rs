//! Says which version is built: from which revision, with which features.

use std::path::Path;
use std::process::Command;

fn main() {
    let version = env!("CARGO_PKG_VERSION");
    let features = if std::env::var_os("CARGO_FEATURE_HOSTS").is_some() { "hosts" } else { "none" };
    let revision = revision();
    println!("cargo::rustc-env=PHASECLOUD_VERSION={version} (revision {revision}, features: {features})");
}

/// The revision of the checkout. A build for development does not ask for it: everything would be built anew after each
/// commit.
fn revision() -> String {
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var("PROFILE").is_ok_and(|profile| profile != "release") {
        return "of a build for development".into();
    }
    let git = |words: &[&str]| {
        let output = Command::new("git").args(words).output().ok().filter(|output| output.status.success())?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    // Sources that are not in a checkout of their own may lie in that of another project.
    let is_own = git(&["rev-parse", "--show-prefix"]).is_some_and(|prefix| prefix.is_empty());
    let Some(revision) = git(&["rev-parse", "--short=12", "HEAD"]).filter(|_| is_own) else { return "unknown".into() };
    for file in ["HEAD", "logs/HEAD"] {
        if let Some(path) = git(&["rev-parse", "--git-path", file]).filter(|path| Path::new(path).exists()) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    revision
}

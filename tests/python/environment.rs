//! The interpreters that the tests need: one with the packages of the kit, one with heyoka beside them.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::LazyLock;

use crate::common::text;

/// The examples.
pub fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/python")
}

/// An interpreter with the packages that the kit requires; made once, and again when the requirements change.
pub static INTERPRETER: LazyLock<Result<PathBuf, String>> = LazyLock::new(|| {
    let environment = Path::new(env!("CARGO_TARGET_TMPDIR")).join("python");
    let interpreter = environment.join("bin/python");
    let requirements = examples().join("requirements.txt");
    let wanted = std::fs::read_to_string(&requirements).map_err(|e| format!("{}: {e}", requirements.display()))?;
    let installed = environment.join("installed.txt");
    if std::fs::read_to_string(&installed).ok().as_deref() != Some(&wanted) {
        succeed(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&environment))?;
        let pip = ["-m", "pip", "install", "--quiet", "--retries", "1", "-r"];
        succeed(Command::new(&interpreter).args(pip).arg(&requirements))?;
        std::fs::write(&installed, wanted).map_err(|e| format!("{}: {e}", installed.display()))?;
    }
    lead_to_the_package(&interpreter)?;
    Ok(interpreter)
});

/// Makes `import phasecloud` find the sources of this checkout, as an editable installation does. The kit needs no
/// compiled part of the package.
fn lead_to_the_package(interpreter: &Path) -> Result<(), String> {
    let where_to = "import site; print(site.getsitepackages()[0])";
    let output = Command::new(interpreter).args(["-c", where_to]).output().map_err(|e| e.to_string())?;
    let file = Path::new(text(&output.stdout).trim()).join("phasecloud.pth");
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("python");
    std::fs::write(&file, package.display().to_string()).map_err(|e| format!("{}: {e}", file.display()))
}

fn succeed(command: &mut Command) -> Result<(), String> {
    let output = command.stdin(Stdio::null()).output().map_err(|e| format!("{command:?}: {e}"))?;
    if output.status.success() { Ok(()) } else { Err(format!("{command:?}: {}", text(&output.stderr))) }
}

/// The same with heyoka, which has no package for every machine.
pub static WITH_HEYOKA: LazyLock<Result<PathBuf, String>> = LazyLock::new(|| {
    let interpreter = INTERPRETER.as_ref()?;
    if succeed(Command::new(interpreter).args(["-c", "import heyoka"])).is_err() {
        let pip = ["-m", "pip", "install", "--quiet", "--retries", "1", "--only-binary", ":all:", "-r"];
        succeed(Command::new(interpreter).args(pip).arg(examples().join("requirements-heyoka.txt")))?;
    }
    Ok(interpreter.clone())
});

/// The interpreter, or `None` after printing why there is none.
pub fn interpreter() -> Option<&'static Path> {
    required(&INTERPRETER)
}

pub fn required(interpreter: &'static Result<PathBuf, String>) -> Option<&'static Path> {
    match interpreter.as_ref() {
        Ok(interpreter) => Some(interpreter),
        Err(why) => {
            assert!(std::env::var_os("PHASECLOUD_REQUIRE_PYTHON").is_none_or(|value| value != "1"), "{why}");
            println!("skipped: {why}");
            None
        }
    }
}

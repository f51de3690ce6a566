//! `phasecloud new`: the skeleton of a propagator that builds and passes `phasecloud check` as it stands.

use std::path::Path;
use std::process::ExitCode;

use nodes::input::{PLAIN_NAME, is_plain_name};

use crate::BAD_INPUT;
use crate::cli::NewArguments;

/// The checkout that this program was built from; a new crate depends on its libraries.
const CHECKOUT: &str = env!("CARGO_MANIFEST_DIR");

const MANIFEST: &str = include_str!("new/Cargo.toml.in");
const PROGRAM: &str = include_str!("new/main.rs");
const PYTHON: [(&str, &str); 4] = [
    ("propagator.py", include_str!("../examples/python/monte_carlo.py")),
    ("phasecloud_kit.py", include_str!("../examples/python/phasecloud_kit.py")),
    ("phasecloud_layout.py", include_str!("../examples/python/phasecloud_layout.py")),
    ("requirements.txt", include_str!("../examples/python/requirements.txt")),
];

/// Writes a skeleton into a new folder and says what to do with it.
pub fn run(arguments: &NewArguments) -> ExitCode {
    match write(arguments) {
        Ok(next) => {
            say!("{next}");
            ExitCode::SUCCESS
        }
        Err(problem) => {
            remark!("error: phasecloud new: {problem}");
            ExitCode::from(BAD_INPUT)
        }
    }
}

fn write(arguments: &NewArguments) -> Result<String, String> {
    let folder = &arguments.folder;
    let name = folder.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    if !is_plain_name(name) {
        return Err(format!("\"{name}\" is not allowed as a name, {PLAIN_NAME}"));
    }
    let files = if arguments.python { python_files() } else { rust_files(name)? };
    let failed = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    // Fails where there is something already: nothing is ever overwritten.
    std::fs::create_dir(folder).map_err(|e| failed(folder, e))?;
    for (path, text) in files {
        let path = folder.join(path);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(|e| failed(parent, e))?;
        }
        std::fs::write(&path, text).map_err(|e| failed(&path, e))?;
    }
    Ok(if arguments.python { python_next(folder) } else { rust_next(folder, name) })
}

fn python_files() -> Vec<(&'static str, String)> {
    PYTHON.map(|(path, text)| (path, text.to_owned())).into()
}

/// The lock file makes the new crate use the versions that its libraries were tested with.
fn rust_files(name: &str) -> Result<Vec<(&'static str, String)>, String> {
    if !name.starts_with(|c: char| c.is_ascii_alphabetic()) || name.contains('.') {
        return Err(format!(
            "\"{name}\" is not allowed as the name of a crate; it must start with a letter and have no '.'"
        ));
    }
    let lock = Path::new(CHECKOUT).join("Cargo.lock");
    let lock = std::fs::read_to_string(&lock).map_err(|e| {
        format!("{}: {e}; the libraries are there in the checkout that made this program", lock.display())
    })?;
    // As a TOML string, whatever characters the path has.
    let library = |folder: &str| toml::Value::from(format!("{CHECKOUT}/{folder}")).to_string();
    let manifest = MANIFEST
        .replace("{name}", name)
        .replace("{density}", &library("density"))
        .replace("{messages}", &library("messages"))
        .replace("{nodes}", &library("nodes"));
    Ok(vec![
        ("Cargo.toml", manifest),
        ("Cargo.lock", lock),
        (".gitignore", "/target\n".into()),
        ("src/main.rs", PROGRAM.replace("target/release/NAME", &format!("target/release/{name}"))),
    ])
}

fn rust_next(folder: &Path, name: &str) -> String {
    let folder = folder.display();
    format!(
        "Written: {folder}. Next:\n  cargo build --release --manifest-path {folder}/Cargo.toml\n  \
         phasecloud check -- {folder}/target/release/{name}\nIn a launch file:\n  [[propagator]]\n  label = \"{name}\"\n  \
         command = [\"{folder}/target/release/{name}\"]"
    )
}

fn python_next(folder: &Path) -> String {
    let folder = folder.display();
    format!(
        "Written: {folder}. Next:\n  python3 -m venv {folder}/venv\n  \
         {folder}/venv/bin/pip install -r {folder}/requirements.txt\n  \
         phasecloud check -- {folder}/venv/bin/python {folder}/propagator.py\nIn a launch file:\n  [[propagator]]\n  \
         label = \"mine\"\n  command = [\"{folder}/venv/bin/python\", \"{folder}/propagator.py\"]"
    )
}

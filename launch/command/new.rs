//! `phasecloud new`: the skeleton of a propagator that builds and passes `phasecloud check` as it stands.

use std::path::Path;
use std::process::ExitCode;

use messages::text::printable;
use nodes::files::input::{PLAIN_NAME, is_plain_name};

use crate::exit::BAD_INPUT;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `phasecloud new`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  phasecloud new my-method\n  phasecloud new my-method --python")]
pub struct NewArguments {
    /// The folder to write, which does not exist yet; its last part is the propagator's name
    #[arg(value_name = "NAME")]
    pub folder: PathBuf,
    /// Write it in Python instead of Rust
    #[arg(long)]
    pub python: bool,
}

/// The checkout that this program was built from; a new crate depends on its libraries.
const CHECKOUT: &str = env!("CARGO_MANIFEST_DIR");

/// Names that a new crate cannot have: folders of cargo, keywords, crates that come with Rust, and our own libraries.
const NOT_FOR_CRATES: [&str; 70] = [
    "build",
    "deps",
    "examples",
    "incremental", // folders of cargo
    "abstract",
    "as",
    "async",
    "await",
    "become",
    "box",
    "break",
    "const",
    "continue",
    "crate",
    "do",
    "dyn",
    "else",
    "enum",
    "extern",
    "false",
    "final",
    "fn",
    "for",
    "gen",
    "if",
    "impl",
    "in",
    "let",
    "loop",
    "macro",
    "match",
    "mod",
    "move",
    "mut",
    "override",
    "priv",
    "pub",
    "ref",
    "return",
    "self",
    "Self",
    "static",
    "struct",
    "super",
    "trait",
    "true",
    "try",
    "type",
    "typeof",
    "union",
    "unsafe",
    "unsized",
    "use",
    "virtual",
    "where",
    "while",
    "yield", // keywords
    "alloc",
    "core",
    "proc_macro",
    "std",
    "test", // crates that come with Rust
    "density",
    "kit",
    "messages",
    "nodes",
    "phasecloud_density",
    "phasecloud_kit",
    "phasecloud_messages",
    "phasecloud_nodes", // our own libraries
];

const MANIFEST: &str = include_str!("../new/Cargo.toml.in");
const PROGRAM: &str = include_str!("../new/main.rs");
const PYTHON: [(&str, &str); 4] = [
    ("propagator.py", include_str!("../../examples/python/monte_carlo.py")),
    ("phasecloud_kit.py", include_str!("../../python/phasecloud/kit/__init__.py")),
    ("phasecloud_layout.py", include_str!("../../python/phasecloud/kit/layout.py")),
    ("requirements.txt", include_str!("../../examples/python/requirements.txt")),
];
/// The kit's imports in the package phasecloud, and those of its copies beside a program, which need no package.
const BESIDE: [(&str, &str); 3] = [
    ("from phasecloud.kit import", "from phasecloud_kit import"),
    ("from . import layout\n", "import phasecloud_layout as layout\n"),
    ("from .layout import", "from phasecloud_layout import"),
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
    let name = plain_name(folder, "propagator")?;
    check_place(folder)?;
    let files = if arguments.python { python_files() } else { rust_files(&name)? };
    write_files(folder, files)?;
    Ok(if arguments.python { python_next(folder) } else { rust_next(folder, &name) })
}

/// The last part of a path, as the name of what is written there.
pub(super) fn plain_name(folder: &Path, what: &str) -> Result<String, String> {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    if is_plain_name(&name) {
        return Ok(name.into_owned());
    }
    Err(format!(
        "\"{}\" is not allowed: the last part of the path is the {what}'s name, and {PLAIN_NAME}",
        printable(&folder.to_string_lossy())
    ))
}

/// Writes files into a new folder.
pub(super) fn write_files(
    folder: &Path,
    files: impl IntoIterator<Item = (&'static str, String)>,
) -> Result<(), String> {
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
    Ok(())
}

/// Refuses a folder that exists, since nothing is overwritten, and one whose parent does not exist.
pub(super) fn check_place(folder: &Path) -> Result<(), String> {
    let parent = folder.parent().filter(|parent| !parent.as_os_str().is_empty());
    if std::fs::symlink_metadata(folder).is_ok() {
        return Err(format!("{} is there already; take another name", folder.display()));
    }
    match parent {
        Some(parent) if !parent.is_dir() => {
            Err(format!("{}: there is no folder {}; make it first", folder.display(), parent.display()))
        }
        _ => Ok(()),
    }
}

fn python_files() -> Vec<(&'static str, String)> {
    let beside = |text: &str| BESIDE.iter().fold(text.to_owned(), |text, (from, to)| text.replace(from, to));
    PYTHON.map(|(path, text)| (path, beside(text))).into()
}

/// The lock file makes the new crate use the versions that its libraries were tested with.
fn rust_files(name: &str) -> Result<Vec<(&'static str, String)>, String> {
    if !name.starts_with(|c: char| c.is_ascii_alphabetic()) || name.contains('.') {
        return Err(format!(
            "\"{name}\" is not allowed as the name of a crate; it must start with a letter and have no '.'"
        ));
    }
    if NOT_FOR_CRATES.contains(&name.replace('-', "_").as_str()) {
        return Err(format!(
            "\"{name}\" is not allowed as the name of a crate, cargo, Rust or phasecloud use it themselves; take another, like my-{name}"
        ));
    }
    let lock = Path::new(CHECKOUT).join("Cargo.lock");
    let lock = std::fs::read_to_string(&lock).map_err(|e| {
        format!("{}: {e}; the libraries are there in the checkout that made this program", lock.display())
    })?;
    // A TOML string can hold whatever characters the path has.
    let library = |folder: &str| toml::Value::from(format!("{CHECKOUT}/{folder}")).to_string();
    let manifest = MANIFEST
        .replace("{name}", name)
        .replace("{density}", &library("density"))
        .replace("{messages}", &library("messages"))
        .replace("{kit}", &library("kit"));
    Ok(vec![
        ("Cargo.toml", manifest),
        ("Cargo.lock", lock),
        (".gitignore", "/target\n".into()),
        ("src/main.rs", PROGRAM.replace("target/release/NAME", &format!("target/release/{name}"))),
    ])
}

/// A path, quoted where needed so that a shell reads it as one word.
pub(super) fn word(path: &Path) -> String {
    let text = path.display().to_string();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
    if text.chars().all(is_plain) { text } else { format!("'{}'", text.replace('\'', "'\\''")) }
}

/// The line of a launch file that gives these paths as `command`.
fn command(paths: &[&Path]) -> String {
    let texts: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    format!("command = {}", toml::Value::from(texts))
}

fn rust_next(folder: &Path, name: &str) -> String {
    let (manifest, program) = (folder.join("Cargo.toml"), folder.join("target/release").join(name));
    format!(
        "Written: {}. Next:\n  cargo build --release --manifest-path {}\n  phasecloud check -- {}\nIn a launch file:\n  \
         [[propagator]]\n  label = \"{name}\"\n  {}",
        folder.display(),
        word(&manifest),
        word(&program),
        command(&[&program])
    )
}

fn python_next(folder: &Path) -> String {
    let in_folder = |name: &str| folder.join(name);
    let (python, program) = (in_folder("venv/bin/python"), in_folder("propagator.py"));
    format!(
        "Written: {}. Next:\n  python3 -m venv {}\n  {} install -r {}\n  phasecloud check -- {} {}\nIn a launch file:\n  \
         [[propagator]]\n  label = \"mine\"\n  {}",
        folder.display(),
        word(&in_folder("venv")),
        word(&in_folder("venv/bin/pip")),
        word(&in_folder("requirements.txt")),
        word(&python),
        word(&program),
        command(&[&python, &program])
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_to_be_done_next_can_be_pasted_whatever_the_folder_is_called() {
        let next = rust_next(Path::new("it's \"mine\"/my-method"), "my-method");
        assert!(next.contains(r#"--manifest-path 'it'\''s "mine"/my-method/Cargo.toml'"#), "{next}");
        let line = next.lines().last().unwrap();
        let table: toml::Table = toml::from_str(line).unwrap();
        assert_eq!(table["command"][0].as_str(), Some("it's \"mine\"/my-method/target/release/my-method"));
        assert!(rust_next(Path::new("a/b"), "b").contains("check -- a/b/target/release/b\n"));
    }
}

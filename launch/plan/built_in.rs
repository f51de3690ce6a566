//! The launch files of this repository and their scenarios, as they are in the program, so that it works from any
//! folder.

use std::path::{Path, PathBuf};

use nodes::files::input::{InputError, InputFile};

/// The launch file that is taken when none is named.
const DEFAULT: &str = "scenario-1";

macro_rules! files {
    ($($name:literal),+ $(,)?) => {
        [$(($name, include_str!(concat!("../", $name, ".toml")))),+]
    };
}

/// By name, the launch files. Those that need programs or hosts of the user's are not among them.
const LAUNCH_FILES: [(&str, &str); 8] =
    files!["scenario-1", "scenario-2", "scenario-3", "paper", "as-printed", "three-dimensional", "fidelity", "sweep",];

/// By their path from a launch file, without extension, the scenario files.
const SCENARIOS: [(&str, &str); 5] = files![
    "scenarios/scenario-1",
    "scenarios/scenario-2",
    "scenarios/scenario-3",
    "scenarios/three-dimensional",
    "scenarios/unaveraged-shadow",
];

/// The built-in launch file that is meant: that of `phasecloud run` if none is named, or the one that is named, unless
/// there is a file with such a path.
pub(crate) fn launch_file(named: Option<&Path>) -> Option<InputFile> {
    let name = match named {
        None => DEFAULT,
        Some(path) if path.is_file() => return None,
        Some(path) => path.to_str()?,
    };
    let (name, text) = LAUNCH_FILES.iter().find(|(known, _)| *known == name)?;
    Some(InputFile::from_text(&PathBuf::from(format!("launch/{name}.toml")), text))
}

/// The error about a launch file that cannot be read, with the names that would do instead if a name is what was given.
pub(crate) fn with_names(error: InputError, path: &Path) -> InputError {
    let is_name = path.extension().is_none() && path.components().count() == 1 && !path.exists();
    if !is_name {
        return error;
    }
    let names = LAUNCH_FILES.map(|(name, _)| name).join(", ");
    InputError { problem: format!("{}; the launch files that are built in are {names}", error.problem), ..error }
}

/// The scenario file that a built-in launch file names.
///
/// # Errors
/// If it is not built in.
pub(crate) fn scenario(named: &Path) -> Result<InputFile, InputError> {
    let path = Path::new("launch").join(named);
    match SCENARIOS.iter().find(|(known, _)| Path::new(&format!("{known}.toml")) == named) {
        Some((_, text)) => Ok(InputFile::from_text(&path, text)),
        None => Err(InputError { file: path, line: 0, key: String::new(), problem: "is not built in".into() }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::launch_file::Launch;

    #[test]
    fn every_built_in_launch_file_is_good_by_its_name_alone() {
        for (name, _) in LAUNCH_FILES {
            let launch = Launch::load(Some(Path::new(name)), None).unwrap();
            assert_eq!(launch.name, name);
            assert!(!launch.scenarios.is_empty());
        }
    }

    #[test]
    fn a_file_goes_before_a_name_and_an_unknown_name_is_told_with_the_known_ones() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("paper");
        assert!(launch_file(Some(&path)).is_none());
        let why = |path: &str| Launch::load(Some(Path::new(path)), None).unwrap_err().to_string();
        let told = why("papers");
        assert!(told.contains("cannot be read") && told.contains("built in are scenario-1, scenario-2"), "{told}");
        assert!(!why("papers.toml").contains("built in"));
    }
}

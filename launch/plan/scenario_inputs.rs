//! The scenarios of a launch file: the files that it names, read and checked.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use nodes::files::input::{InputError, InputFile};
use nodes::files::scenario_file::{self, AnyScenario};
use toml::Spanned;

use super::built_in;

/// A scenario with the file it came from.
#[derive(Debug, Clone)]
pub struct ScenarioInput {
    /// The text of the file.
    pub text: String,
    /// What it says.
    pub content: AnyScenario,
}

impl ScenarioInput {
    /// Reads and checks what a scenario file says.
    pub(super) fn check(file: &InputFile) -> Result<Self, InputError> {
        Ok(Self { content: scenario_file::check_cloud(file)?, text: file.text().into() })
    }
}

/// The scenarios that a launch file names, relative to its folder, or the one that replaces them.
pub(super) fn named_scenarios(
    file: &InputFile,
    path: Option<&Path>,
    scenarios: &Spanned<Vec<Spanned<PathBuf>>>,
    replacement: Option<&Path>,
) -> Result<Vec<ScenarioInput>, InputError> {
    if let Some(replacement) = replacement {
        return Ok(vec![ScenarioInput::check(&InputFile::read(replacement)?)?]);
    }
    let read = |relative: &Path| match path {
        Some(path) => InputFile::read(&path.parent().unwrap_or(Path::new(".")).join(relative)),
        None => built_in::scenario(relative),
    };
    let named = scenarios.get_ref();
    if named.is_empty() {
        return Err(file.error(scenarios, "names no scenario; it must name at least one file"));
    }
    let mut names = BTreeSet::new();
    let mut inputs = Vec::new();
    for relative in named {
        let content = read(relative.get_ref()).map_err(|e| file.error(relative, &e.to_string()))?;
        let input = ScenarioInput::check(&content)?;
        if !names.insert(input.content.name().to_owned()) {
            let problem = format!("a second scenario with the name \"{}\"; names must differ", input.content.name());
            return Err(file.error(relative, &problem));
        }
        inputs.push(input);
    }
    Ok(inputs)
}

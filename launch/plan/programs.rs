//! Whether the programs that a launch file names can be started.

use std::io::ErrorKind;
use std::path::Path;

use bridge::plan::HOME;
use nodes::files::input::{InputError, InputFile};
use rustix::fs::{Access, access};

use super::cases::{Case, Runs, command_error};

/// All that is wrong with the programs of a launch file, with line and key.
pub fn problems(file: &InputFile, cases: &[Case]) -> Vec<InputError> {
    let problem = |(index, case): (usize, &Case)| {
        let problem = format!("of the case {}: {}", case.label, program_problem(case)?);
        Some(command_error(file, index, &problem))
    };
    cases.iter().enumerate().filter_map(problem).collect()
}

/// What is wrong with the program of a case that runs on this host.
fn program_problem(case: &Case) -> Option<String> {
    let Runs::Command(words) = &case.runs else { return None };
    let is_here = case.members().any(|(_, shard)| case.host_of(shard) == HOME);
    let program = words.first().filter(|_| is_here)?;
    if let Some(word) = words.iter().find(|word| word.contains('\0')) {
        return Some(format!("{word:?} holds a NUL, which no program can be given"));
    }
    if program.contains('/') {
        let folder = std::env::current_dir().unwrap_or_default();
        return match std::fs::metadata(program) {
            Err(e) if e.kind() == ErrorKind::NotFound => {
                Some(format!("there is no program {program}, looked up from {}", folder.display()))
            }
            Err(e) => Some(format!("the program {program}, looked up from {}: {e}", folder.display())),
            Ok(found) if !found.is_file() => Some(format!("{program} is not a program but a folder or a device")),
            Ok(_) if !is_executable(Path::new(program)) => {
                Some(format!("{program} is not executable (chmod +x {program})"))
            }
            Ok(_) => None,
        };
    }
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&folders).map(|folder| folder.join(program)).any(|path| is_executable(&path));
    let problem = || {
        format!(
            "there is no program \"{program}\" in the folders of PATH; one elsewhere needs a path, like ./{program}"
        )
    };
    (!found).then(problem)
}

fn is_executable(path: &Path) -> bool {
    path.is_file() && access(path, Access::EXEC_OK).is_ok()
}

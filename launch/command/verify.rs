//! `phasecloud verify`: whether results folders are as they were written.

use std::process::ExitCode;

use crate::exit::BAD_INPUT;
use crate::record::checksums;

/// Prints what differs between results folders and their manifests.
pub fn run(folders: &[std::path::PathBuf]) -> ExitCode {
    let mut code = ExitCode::SUCCESS;
    for folder in folders {
        match checksums::verify(folder) {
            Ok((count, differ)) if differ.is_empty() => say!("{}: good, {count} files", folder.display()),
            Ok((_, differ)) => {
                differ.iter().for_each(|problem| remark!("error: {}: {problem}", folder.display()));
                code = ExitCode::FAILURE;
            }
            Err(problem) => {
                remark!("error: {problem}");
                code = ExitCode::from(BAD_INPUT);
            }
        }
    }
    code
}

//! `phasecloud`: the one command users get. It starts the processes of a run, looks after them, and prints what came out.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod checksums;
mod cli;
mod domains;
mod ending;
mod log_sink;
mod manifest;
mod node_command;
mod preflight;
mod progress;
mod report;
mod results_folder;
mod run_command;
mod supervisor;

use std::process::ExitCode;

use clap::Parser;

use launch::launch_file;

use cli::{Cli, Command, RunArguments};
use launch_file::Launch;

/// Bad input; nothing was started.
const BAD_INPUT: u8 = 2;

fn main() -> ExitCode {
    let command = Cli::parse().command.or_else(|| Cli::parse_from(["phasecloud", "run"]).command);
    match command.unwrap_or(Command::Run(RunArguments::default())) {
        Command::Run(arguments) => run_command::run(&arguments),
        Command::Validate { files } => validate(&files),
        Command::Verify { folders } => verify(&folders),
        Command::Node(arguments) => node_command::run(arguments),
    }
}

/// Prints what differs between results folders and their manifests.
fn verify(folders: &[std::path::PathBuf]) -> ExitCode {
    let mut code = ExitCode::SUCCESS;
    for folder in folders {
        match checksums::verify(folder) {
            Ok((count, differ)) if differ.is_empty() => println!("{}: good, {count} files", folder.display()),
            Ok((_, differ)) => {
                differ.iter().for_each(|problem| eprintln!("error: {}: {problem}", folder.display()));
                code = ExitCode::FAILURE;
            }
            Err(problem) => {
                eprintln!("error: {problem}");
                code = ExitCode::from(BAD_INPUT);
            }
        }
    }
    code
}

fn validate(files: &[std::path::PathBuf]) -> ExitCode {
    let mut code = ExitCode::SUCCESS;
    for file in files {
        match Launch::load(Some(file), None) {
            Ok(launch) => println!(
                "{}: good, {} cases on {} scenarios",
                file.display(),
                launch.cases.len(),
                launch.scenarios.len()
            ),
            Err(error) => {
                eprintln!("error: {error}");
                code = ExitCode::from(BAD_INPUT);
            }
        }
    }
    code
}

//! `phasecloud`: the one command users get. It starts the processes of a run, looks after them, and prints what came out.

mod cli;
mod domains;
mod launch_file;
mod manifest;
mod node_command;
mod preflight;
mod progress;
mod report;
mod report_command;
mod results_folder;
mod run_command;
mod supervisor;

use std::process::ExitCode;

use clap::Parser;

use cli::{Cli, Command, RunArguments};
use launch_file::Launch;

/// Bad input; nothing was started.
const BAD_INPUT: u8 = 2;

fn main() -> ExitCode {
    match Cli::parse().command.unwrap_or(Command::Run(RunArguments::default())) {
        Command::Run(arguments) => run_command::run(&arguments),
        Command::Report(arguments) => report_command::run(&arguments),
        Command::Validate { files } => validate(&files),
        Command::Node(arguments) => node_command::run(arguments),
    }
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

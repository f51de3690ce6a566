//! `phasecloud`: the one command users get. It starts the processes of a run, looks after them, and prints what came out.

mod attach;
mod cli;
mod domains;
mod graph;
mod launch_file;
mod live;
mod manifest;
mod node_command;
mod observe;
mod preflight;
mod recording;
mod replay_command;
mod report;
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
        Command::Replay(arguments) => replay_command::run(&arguments),
        Command::Topics(target) => observe::topics::run(&target),
        Command::Echo(arguments) => observe::echo::run(&arguments),
        Command::Hz(arguments) => observe::hz::run(&arguments),
        Command::Watch(arguments) => observe::watch::run(&arguments),
        Command::Graph { launch_file } => graph::run(launch_file.as_deref()),
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

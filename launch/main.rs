//! `phasecloud`: the one command users get. It starts the processes of a run, looks after them, and prints what came out.

mod attach;
mod check;
mod clean_command;
mod cli;
mod commands;
mod domain_command;
mod domains;
mod graph;
mod guard;
mod live;
mod manifest;
mod member;
mod new_command;
mod node_command;
mod observe;
mod preflight;
mod recording;
mod replay_command;
mod report;
mod report_command;
mod results_folder;
mod run;
mod run_command;
mod serve_command;
mod submit_command;
mod supervisor;

use std::process::ExitCode;

use clap::Parser;

use launch::launch_file;

use cli::{Cli, Command, RunArguments};
use launch_file::Launch;

/// Bad input; nothing was started.
const BAD_INPUT: u8 = 2;

fn main() -> ExitCode {
    match Cli::parse().command.unwrap_or(Command::Run(RunArguments::default())) {
        Command::Run(arguments) => run_command::run(&arguments),
        Command::Serve(arguments) => serve_command::run(&arguments),
        Command::Submit(arguments) => submit_command::run(&arguments),
        Command::Clean => clean_command::run(),
        Command::Replay(arguments) => replay_command::run(&arguments),
        Command::Topics(target) => observe::topics::run(&target),
        Command::Echo(arguments) => observe::echo::run(&arguments),
        Command::Hz(arguments) => observe::hz::run(&arguments),
        Command::Watch(arguments) => observe::watch::run(&arguments),
        Command::Graph { launch_file } => graph::run(launch_file.as_deref()),
        Command::Report(arguments) => report_command::run(&arguments),
        Command::Validate { files } => validate(&files),
        Command::Check(arguments) => check::run(&arguments),
        Command::New(arguments) => new_command::run(&arguments),
        Command::Domain(arguments) => domain_command::run(&arguments),
        Command::Node(arguments) => node_command::run(arguments),
        Command::Guard { words } => guard::run(&words),
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

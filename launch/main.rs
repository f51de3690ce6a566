//! `phasecloud`: the one command users get. It starts the processes of a run, looks after them, and prints what came out.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic))]
// They end the process when nobody reads; see `output`.
#![deny(clippy::print_stdout, clippy::print_stderr)]

#[macro_use]
mod output;

mod attach;
mod check;
mod checksums;
mod clean_command;
mod cli;
mod commands;
mod domain_command;
mod domains;
mod ending;
mod environment;
mod from_environment;
mod graph;
mod guard;
#[cfg(feature = "hosts")]
mod join_command;
mod keeper;
mod live;
mod log_sink;
mod manifest;
mod member;
mod new_command;
mod node_command;
mod observe;
mod plans;
mod preflight;
mod recording;
mod replay_command;
mod report;
mod report_command;
mod results_folder;
mod run;
mod run_command;
mod serve_command;
#[cfg(feature = "hosts")]
mod share;
mod submit_command;
mod supervisor;
mod sweep;
mod validate_command;

use std::process::ExitCode;

use clap::Parser;

use launch::{cases, hosts, launch_file};

use cli::{Cli, Command, RunArguments};

/// Bad input; nothing was started.
const BAD_INPUT: u8 = 2;

fn main() -> ExitCode {
    if let Err(problem) = environment::shed() {
        remark!("error: {problem}");
        return ExitCode::from(BAD_INPUT);
    }
    let command = match command() {
        Ok(command) => command,
        Err(answer) => return output::answer(&answer),
    };
    match command {
        Command::Run(arguments) => run_command::run(&arguments),
        Command::Serve(arguments) => serve_command::run(&arguments),
        Command::Submit(arguments) => submit_command::run(&arguments),
        Command::Join(arguments) => join(&arguments),
        Command::Clean => clean_command::run(),
        Command::Replay(arguments) => replay_command::run(&arguments),
        Command::Topics(target) => output::end(observe::topics::run(&target)),
        Command::Echo(arguments) => output::end(observe::echo::run(&arguments)),
        Command::Hz(arguments) => output::end(observe::hz::run(&arguments)),
        Command::Watch(arguments) => output::end(observe::watch::run(&arguments)),
        Command::Graph { launch_file } => output::end(graph::run(launch_file.as_deref())),
        Command::Report(arguments) => report_command::run(&arguments),
        Command::Validate { files } => output::end(validate_command::run(&files)),
        Command::Check(arguments) => output::end(check::run(&arguments)),
        Command::New(arguments) => new_command::run(&arguments),
        Command::Domain(arguments) => domain_command::run(&arguments),
        Command::Verify { folders } => output::end(verify(&folders)),
        Command::Node(arguments) => node_command::run(arguments),
        Command::Guard { words } => guard::run(&words),
    }
}

/// The command that the command line asks for; none is `run`.
fn command() -> Result<Command, clap::Error> {
    let command = match Cli::try_parse()?.command {
        None => Cli::try_parse_from(["phasecloud", "run"])?.command,
        asked => asked,
    };
    Ok(command.unwrap_or(Command::Run(RunArguments::default())))
}

#[cfg(feature = "hosts")]
use join_command::run as join;

#[cfg(not(feature = "hosts"))]
fn join(_: &cli::JoinArguments) -> ExitCode {
    remark!("error: phasecloud join: {}", hosts::WITHOUT_HOSTS);
    ExitCode::from(BAD_INPUT)
}

/// Prints what differs between results folders and their manifests.
fn verify(folders: &[std::path::PathBuf]) -> ExitCode {
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

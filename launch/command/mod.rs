//! The commands of `phasecloud`, one per file, each with its arguments.

mod ask;
mod ask_in_space;
mod asked;
mod clean;
mod cli;
mod completions;
mod derived;
mod domain;
mod ephemeris;
mod export;
mod fidelity;
mod from_environment;
mod graph;
mod init;
#[cfg(feature = "hosts")]
mod join;
mod long_work;
mod map;
mod new;
pub(crate) mod node;
mod orbit;
mod rare;
mod replay;
pub mod report;
mod run;
mod schema;
mod serve;
mod submit;
mod validate;
mod verify;
mod version;

use std::process::ExitCode;

use clap::{CommandFactory, Parser};

use crate::crew::{environment, guard};
use crate::exit::BAD_INPUT;
use crate::plan::preflight;
use crate::{check, observe, output};

use cli::{Cli, Command};
use run::RunArguments;

/// Does what the command line of this process asks for.
pub fn main() -> ExitCode {
    if let Err(problem) = preflight::check_stack_and_data().and_then(|()| environment::shed()) {
        remark!("error: {problem}");
        return ExitCode::from(BAD_INPUT);
    }
    carry_out()
}

/// Does the same once it is known that the stack is large enough.
#[inline(never)]
fn carry_out() -> ExitCode {
    let command = match command() {
        Ok(command) => command,
        Err(answer) => return self::answer(&answer),
    };
    match command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Serve(arguments) => serve::run(&arguments),
        Command::Submit(arguments) => submit::run(&arguments),
        Command::Join(arguments) => join(&arguments),
        Command::Ask(arguments) => output::end(ask::run(&arguments)),
        Command::Map(arguments) => output::end(map::run(&arguments)),
        Command::Orbit(arguments) => output::end(orbit::run(&arguments)),
        Command::Fidelity(arguments) => output::end(fidelity::run(&arguments)),
        Command::Clean => clean::run(),
        Command::Replay(arguments) => replay::run(&arguments),
        Command::Export(arguments) => output::end(export::run(&arguments)),
        Command::Topics(target) => output::end(observe::topics::run(&target)),
        Command::Echo(arguments) => output::end(observe::echo::run(&arguments)),
        Command::Hz(arguments) => output::end(observe::hz::run(&arguments)),
        Command::Watch(arguments) => output::end(observe::watch::run(&arguments)),
        Command::Graph { launch_file } => output::end(graph::run(launch_file.as_deref())),
        Command::Report(arguments) => report::run(&arguments),
        Command::Validate { files } => output::end(validate::run(&files)),
        Command::Check(arguments) => output::end(check::run(&arguments)),
        Command::New(arguments) => new::run(&arguments),
        Command::Init(arguments) => init::run(&arguments),
        Command::Completions(arguments) => output::end(completions::run(&arguments, Cli::command())),
        Command::Schema(arguments) => output::end(schema::run(&arguments)),
        Command::Man(arguments) => output::end(completions::man(&arguments, Cli::command())),
        Command::Domain(arguments) => domain::run(&arguments),
        Command::Verify { folders } => output::end(verify::run(&folders)),
        Command::Node(arguments) => node::run(arguments),
        Command::Guard { words } => guard::run(&words),
    }
}

/// The command that the command line names; `run` if it names none.
fn command() -> Result<Command, clap::Error> {
    let command = match Cli::try_parse()?.command {
        None => Cli::try_parse_from(["phasecloud", "run"])?.command,
        asked => asked,
    };
    Ok(command.unwrap_or(Command::Run(RunArguments::default())))
}

#[cfg(feature = "hosts")]
use join::run as join;

#[cfg(not(feature = "hosts"))]
fn join(_: &cli::JoinArguments) -> ExitCode {
    remark!("error: phasecloud join: {}", crate::plan::hosts::WITHOUT_HOSTS);
    ExitCode::from(BAD_INPUT)
}

/// Prints what the parser of the command line returns in place of a command: the help, the version, or what it does not
/// understand.
fn answer(answer: &clap::Error) -> ExitCode {
    let printed = answer.print().and_then(|()| std::io::Write::flush(&mut std::io::stdout()));
    if !answer.use_stderr() {
        output::note(printed);
    }
    let words: Vec<String> = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
    if let Some(variable) = from_environment::refused(answer, &words) {
        remark!("The refused value is that of the environment variable {variable}.");
    }
    output::end(ExitCode::from(u8::try_from(answer.exit_code()).unwrap_or(BAD_INPUT)))
}

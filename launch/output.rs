//! What a command prints. A reader that has gone away and a device that is full are no reason to end, so nothing here fails.

use std::fmt::Arguments;
use std::io::{Error, ErrorKind, Write};
use std::process::ExitCode;
use std::sync::OnceLock;

use crate::{BAD_INPUT, from_environment};

/// Why something could not be printed on standard output, if it was not that nobody reads it.
static UNPRINTED: OnceLock<String> = OnceLock::new();

/// Prints a line on standard output.
macro_rules! say {
    ($($words:tt)*) => { $crate::output::print_line(format_args!($($words)*)) };
}

/// Prints a line on standard error.
macro_rules! remark {
    ($($words:tt)*) => { $crate::output::print_remark(format_args!($($words)*)) };
}

/// Prints a line on standard output; use `say!`.
pub fn print_line(words: Arguments<'_>) {
    let mut out = std::io::stdout().lock();
    note(out.write_all(format!("{words}\n").as_bytes()).and_then(|()| out.flush()));
}

/// Prints a line on standard error; use `remark!`.
pub fn print_remark(words: Arguments<'_>) {
    let _ = std::io::stderr().write_all(format!("{words}\n").as_bytes());
}

/// Takes in how printing on standard output went; false if it failed.
pub fn note(printed: Result<(), Error>) -> bool {
    let is_printed = printed.is_ok();
    if let Err(error) = printed
        && error.kind() != ErrorKind::BrokenPipe
    {
        let _ = UNPRINTED.set(error.to_string());
    }
    is_printed
}

/// The end of a command whose result is what it prints: it has failed if that could not be written, unless its reader had
/// seen enough.
pub fn end(code: ExitCode) -> ExitCode {
    let Some(why) = UNPRINTED.get() else { return code };
    remark!("error: standard output cannot be written: {why}");
    if code == ExitCode::SUCCESS { ExitCode::FAILURE } else { code }
}

/// Prints what the reader of the command line says in place of a command: help, the version, or what it does not understand.
pub fn answer(answer: &clap::Error) -> ExitCode {
    let printed = answer.print().and_then(|()| std::io::stdout().flush());
    if !answer.use_stderr() {
        note(printed);
    }
    let words: Vec<String> = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
    if let Some(variable) = from_environment::refused(answer, &words) {
        remark!("The refused value is that of the environment variable {variable}.");
    }
    end(ExitCode::from(u8::try_from(answer.exit_code()).unwrap_or(BAD_INPUT)))
}

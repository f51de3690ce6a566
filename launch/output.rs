//! Printing, which never fails: a command does not end because its reader has gone away or a device is full.

use std::fmt::Arguments;
use std::io::{Error, ErrorKind, Write};
use std::process::ExitCode;
use std::sync::OnceLock;

/// Why standard output could not be written; not set if the only reason is that nobody reads it any more.
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

/// Notes why printing on standard output failed, if it did; returns false if it failed.
pub fn note(printed: Result<(), Error>) -> bool {
    let is_printed = printed.is_ok();
    if let Err(error) = printed
        && error.kind() != ErrorKind::BrokenPipe
    {
        let _ = UNPRINTED.set(error.to_string());
    }
    is_printed
}

/// Returns the exit code of a command whose result is what it prints: it has failed if its output could not be written,
/// unless its reader went away.
pub fn end(code: ExitCode) -> ExitCode {
    let Some(why) = UNPRINTED.get() else { return code };
    remark!("error: standard output cannot be written: {why}");
    if code == ExitCode::SUCCESS { ExitCode::FAILURE } else { code }
}

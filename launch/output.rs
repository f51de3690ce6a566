//! What a command prints. A reader that has gone away and a device that is full are no reason to end, so nothing here fails.

use std::fmt::Arguments;
use std::io::{Error, ErrorKind, Write};
use std::process::ExitCode;
use std::sync::OnceLock;

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

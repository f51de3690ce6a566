//! `phasecloud`: the one command users get.

#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    launch::command::main()
}

//! `phasecloud export`: a recording in a format that other programs read.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use crate::exit::BAD_INPUT;
use crate::record::mcap;

/// Arguments of `phasecloud export`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  phasecloud run --record run.tape && phasecloud export run.tape run.mcap\n\n\
    The file is MCAP, which Foxglove and the packages called mcap read: a channel for each topic, messages as JSON with their schemas. \
    Numbers that are withheld are null. The log time of a message is its place in the recording, a millisecond each.\n\n\
    Exit codes: 0 written; 2 the recording cannot be read, or the file cannot be written.")]
pub struct ExportArguments {
    /// The recording
    pub recording: PathBuf,
    /// The file to write, which does not exist yet; its name ends in .mcap
    pub out: PathBuf,
}

/// Writes the file.
pub fn run(ExportArguments { recording, out }: &ExportArguments) -> ExitCode {
    let is_mcap = out.extension().is_some_and(|extension| extension == "mcap");
    let written = match is_mcap {
        true => mcap::export(recording, out),
        false => Err(format!("{}: the name must end in .mcap, the only format that there is", out.display())),
    };
    match written {
        Ok(count) => {
            say!("Written: {count} messages into {}", out.display());
            ExitCode::SUCCESS
        }
        Err(problem) => {
            remark!("error: phasecloud export: {problem}");
            ExitCode::from(BAD_INPUT)
        }
    }
}

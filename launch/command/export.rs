//! `phasecloud export`: a recording, or the tables of a results folder, in a format that other programs read.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;

use crate::exit::BAD_INPUT;
use crate::record::mcap;
use results::parquet;

use super::report::{one_run, outside_of_results};

/// Arguments of `phasecloud export`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  phasecloud run --record run.tape && phasecloud export run.tape run.mcap\n  \
    phasecloud export results/paper tables\n\n\
    A recording becomes an MCAP file, which Foxglove and the packages called mcap read: a channel for each topic, messages as JSON with their \
    schemas. Numbers that are withheld are null. The log time of a message is its place in the recording, a millisecond each.\n\n\
    The tables of a results folder become Parquet files of the same names in a new folder. A withheld number is NaN. `phasecloud run --export parquet` \
    writes them into the results folder itself.\n\n\
    Exit codes: 0 written; 2 the recording or the folder cannot be read, or a file cannot be written.")]
pub struct ExportArguments {
    /// The recording, or a results folder
    #[arg(value_name = "RECORDING|DIR")]
    pub what: PathBuf,
    /// The file to write, whose name ends in .mcap, or the folder for the tables; it does not exist yet
    pub out: PathBuf,
}

/// In what format a run writes its tables, too.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum TableFormat {
    /// Parquet files, beside the CSV tables and with their names
    Parquet,
}

/// Writes the file or the tables.
pub fn run(ExportArguments { what, out }: &ExportArguments) -> ExitCode {
    let is_mcap = out.extension().is_some_and(|extension| extension == "mcap");
    let written = match (what.is_dir(), is_mcap) {
        _ if !what.exists() => Err(format!("{}: does not exist; name a recording or a results folder", what.display())),
        (true, _) => tables(what, out),
        (false, true) => mcap::export(what, out).map(|count| format!("{count} messages into {}", out.display())),
        (false, false) => Err(format!(
            "{}: the name must end in .mcap, since a recording is written in no other format",
            out.display()
        )),
    };
    match written {
        Ok(what) => {
            say!("Written: {what}");
            ExitCode::SUCCESS
        }
        Err(problem) => {
            remark!("error: phasecloud export: {problem}");
            ExitCode::from(BAD_INPUT)
        }
    }
}

/// Writes the tables of a results folder into a new folder, which is removed again if that fails.
fn tables(folder: &Path, out: &Path) -> Result<String, String> {
    outside_of_results(out)?;
    one_run(folder)?;
    std::fs::create_dir(out).map_err(|e| format!("{}: {e}; name a folder that does not exist yet", out.display()))?;
    match parquet::write(folder, out) {
        Ok(files) => Ok(format!("{} tables into {}", files.len(), out.display())),
        Err(problem) => {
            let _ = std::fs::remove_dir_all(out);
            Err(problem.to_string())
        }
    }
}

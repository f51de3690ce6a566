//! `phasecloud map`: a quantity of a scenario over one or two of its numbers.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use nodes::files::map_file::MapFile;

use crate::exit::BAD_INPUT;
use crate::map::{FIGURE, PAGE, TABLE, compute, prepare, write};

/// Arguments of `phasecloud map`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  phasecloud map launch/maps/re-entry.toml\n\n\
    A map file names a scenario, a quantity and the numbers that are varied (docs/maps.md). A map that was interrupted goes on where it \
    was if it is asked for again.\n\n\
    Exit codes: 0 the map is complete; 1 it cannot be computed or written; 2 bad input.")]
pub struct MapArguments {
    /// The map file
    pub file: PathBuf,
    /// The folder to write [default: maps/NAME, NAME being that of the file]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
}

/// Computes and writes a map.
pub fn run(arguments: &MapArguments) -> ExitCode {
    let map = match MapFile::load(&arguments.file) {
        Ok(map) => map,
        Err(error) => return refuse(&error.to_string()),
    };
    let folder = arguments.out.clone().unwrap_or_else(|| {
        let name = arguments.file.file_stem().unwrap_or_default();
        PathBuf::from("maps").join(name)
    });
    if let Err(problem) = prepare(&map, &folder) {
        return refuse(&problem);
    }
    let written = compute(&map, &folder, arguments.quiet).and_then(|cells| write(&map, &cells, &folder));
    match written {
        Ok(()) => {
            if !arguments.quiet {
                say!("{} is in {}: {TABLE}, {FIGURE}, {PAGE}", map.label(), folder.display());
            }
            ExitCode::SUCCESS
        }
        Err(problem) => {
            remark!("error: {problem}");
            ExitCode::FAILURE
        }
    }
}

fn refuse(problem: &str) -> ExitCode {
    remark!("error: {problem}");
    ExitCode::from(BAD_INPUT)
}

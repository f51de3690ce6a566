//! `phasecloud map`: a quantity of a scenario over one or two of its numbers.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use nodes::files::input::InputFile;
use nodes::files::map_file::MapFile;

use crate::exit::BAD_INPUT;
use crate::map::{FIGURE, Order, PAGE, TABLE, draw, prepare};
use crate::plan::hosts::Hosts;

/// Arguments of `phasecloud map`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  phasecloud map launch/maps/re-entry.toml\n  \
    phasecloud map launch/maps/three-hosts.toml     # and on each host that its table [hosts] names:\n  \
    phasecloud join --connect tcp/127.0.0.1:7447 --name worker-a\n\n\
    A map file names a scenario, a quantity and the numbers that are varied (docs/maps.md). A map that was interrupted goes on where it \
    was if it is asked for again. Hosts that join compute parts of it, and may come and go as they like.\n\n\
    Exit codes: 0 the map is complete; 1 it cannot be computed or written; 2 bad input, or the hosts cannot be listened for; 130 stopped on request, \
    the same command goes on with what is there.")]
pub struct MapArguments {
    /// The map file
    pub file: PathBuf,
    /// The folder to write [default: maps/NAME, NAME being that of the file]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Let hosts talk without encryption beyond this machine
    #[arg(long)]
    pub insecure: bool,
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
}

/// Computes and writes a map.
pub fn run(arguments: &MapArguments) -> ExitCode {
    let (map, hosts) = match read(arguments) {
        Ok(read) => read,
        Err(problem) => return refuse(&problem),
    };
    let folder = arguments.out.clone().unwrap_or_else(|| {
        let name = arguments.file.file_stem().unwrap_or_default();
        PathBuf::from("maps").join(name)
    });
    if let Err(problem) = prepare(&map, &folder) {
        return refuse(&problem);
    }
    let (folder, hosts, is_quiet) = (folder.as_path(), hosts.as_ref(), arguments.quiet);
    match draw(&Order { map: &map, folder, hosts, is_quiet }) {
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

/// The map, and the hosts that may contribute.
fn read(arguments: &MapArguments) -> Result<(MapFile, Option<Hosts>), String> {
    let file = InputFile::read(&arguments.file).map_err(|e| e.to_string())?;
    let map = MapFile::check(&file).map_err(|e| e.to_string())?;
    let folder = arguments.file.parent().unwrap_or(Path::new("."));
    let hosts = map.hosts.as_ref().map(|table| Hosts::check(&file, table, folder)).transpose();
    let mut hosts = hosts.map_err(|e| e.to_string())?;
    hosts.as_mut().map_or(Ok(()), |hosts| hosts.open(arguments.insecure))?;
    Ok((map, hosts))
}

fn refuse(problem: &str) -> ExitCode {
    remark!("error: {problem}");
    ExitCode::from(BAD_INPUT)
}

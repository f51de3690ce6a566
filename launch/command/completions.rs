//! `phasecloud completions` and `phasecloud man`: what shells and `man` know of the command.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Command};
use clap_complete::Shell;

use crate::exit::BAD_INPUT;

/// Arguments of `phasecloud completions`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phasecloud completions bash > ~/.local/share/bash-completion/completions/phasecloud\n  \
    phasecloud completions zsh > ~/.zfunc/_phasecloud\n  phasecloud completions fish > ~/.config/fish/completions/phasecloud.fish"
)]
pub struct CompletionsArguments {
    /// The shell
    pub shell: Shell,
}

/// Arguments of `phasecloud man`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  phasecloud man | man -l -\n  phasecloud man ~/.local/share/man/man1")]
pub struct ManArguments {
    /// Write the pages of all commands into this folder, which is made if it is not there; without it the first page is
    /// printed
    #[arg(value_name = "DIR")]
    pub folder: Option<PathBuf>,
}

/// Prints the script by which a shell completes the command.
pub fn run(arguments: &CompletionsArguments, mut command: Command) -> ExitCode {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, "phasecloud", &mut script);
    print(&script)
}

/// Prints or writes the manual pages.
pub fn man(arguments: &ManArguments, command: Command) -> ExitCode {
    match &arguments.folder {
        None => match page(command) {
            Ok(page) => print(&page),
            Err(error) => refuse(Path::new("the page"), &error),
        },
        Some(folder) => {
            match std::fs::create_dir_all(folder).and_then(|()| clap_mangen::generate_to(command, folder)) {
                Ok(()) => {
                    say!("Written: the pages of phasecloud and its commands into {}", folder.display());
                    ExitCode::SUCCESS
                }
                Err(error) => refuse(folder, &error),
            }
        }
    }
}

fn page(command: Command) -> std::io::Result<Vec<u8>> {
    let mut page = Vec::new();
    clap_mangen::Man::new(command).render(&mut page)?;
    Ok(page)
}

fn print(text: &[u8]) -> ExitCode {
    say!("{}", String::from_utf8_lossy(text).trim_end());
    ExitCode::SUCCESS
}

fn refuse(what: &Path, error: &std::io::Error) -> ExitCode {
    remark!("error: phasecloud man: {}: {error}", what.display());
    ExitCode::from(BAD_INPUT)
}

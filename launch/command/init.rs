//! `phasecloud init`: a folder to start from, with a scenario, a launch file and a page that says what to do with them.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use nodes::files::schema;

use super::new::{check_place, plain_name, word, write_files};
use crate::exit::BAD_INPUT;
use crate::plan::schema as of_launch;

/// Arguments of `phasecloud init`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  phasecloud init my-satellite && phasecloud run my-satellite/launch.toml")]
pub struct InitArguments {
    /// The folder to write, which does not exist yet; its last part is the name of scenario and launch file
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
}

const FILES: [(&str, &str); 3] = [
    ("scenario.toml", include_str!("../init/scenario.toml")),
    ("launch.toml", include_str!("../init/launch.toml")),
    ("README.md", include_str!("../init/README.md")),
];

/// Writes the folder and says what to do with it.
pub fn run(InitArguments { folder }: &InitArguments) -> ExitCode {
    let written = plain_name(folder, "scenario").and_then(|name| {
        check_place(folder)?;
        let files = FILES.map(|(path, text)| (path, text.replace("{name}", &name)));
        let schemas = [("schema/scenario.json", schema::scenario()), ("schema/launch.json", of_launch::schema())];
        let schemas = schemas.map(|(path, schema)| (path, format!("{schema:#}\n")));
        write_files(folder, files.into_iter().chain(schemas))
    });
    match written {
        Ok(()) => {
            let file = |name: &str| word(&folder.join(name));
            say!(
                "Written: {}. Next:\n  phasecloud ask {}\n  phasecloud run {}",
                folder.display(),
                file("scenario.toml"),
                file("launch.toml")
            );
            ExitCode::SUCCESS
        }
        Err(problem) => {
            remark!("error: phasecloud init: {problem}");
            ExitCode::from(BAD_INPUT)
        }
    }
}

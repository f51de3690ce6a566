//! The command line and the environment with which each process of a run is started.

use std::path::PathBuf;
use std::process::Command;

use messages::domain::{PREFIX_VARIABLE, Place, ROOT_VARIABLE};
use nodes::session::{ATTEMPT_VARIABLE, LABEL_VARIABLE, LAUNCHER_VARIABLE, RUN_VARIABLE};

use crate::launch_file::{Case, Launch, Runs};

/// The process that publishes the scenarios.
pub const SCENARIO_NODE: &str = "scenario";
/// The processes that every run needs besides its cases.
pub const SERVICES: [&str; 4] = ["estimator", "comparator", "recorder", SCENARIO_NODE];

/// What the commands of a run are made of.
#[derive(Debug)]
pub struct Commands<'a> {
    pub launch: &'a Launch,
    pub place: &'a Place,
    pub run_id: u64,
    /// The folder that the recorder writes to.
    pub draft: PathBuf,
    /// Arguments of the scenario node: where scenarios come from.
    pub scenarios: Vec<String>,
}

impl Commands<'_> {
    /// The command of process `name`, which has been restarted `attempt` times, while scenario `scenario` is under way.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn of(&self, name: &str, attempt: u32, scenario: u32) -> Result<Command, String> {
        let mut command = match self.launch.cases.iter().find(|case| case.label == name) {
            Some(case) => self.of_case(case)?,
            None => self.of_service(name, scenario)?,
        };
        command.env(ROOT_VARIABLE, &self.place.root).env(PREFIX_VARIABLE, &self.place.prefix);
        command.env(RUN_VARIABLE, self.run_id.to_string());
        command.env(LAUNCHER_VARIABLE, std::process::id().to_string());
        command.env(LABEL_VARIABLE, name);
        command.env(ATTEMPT_VARIABLE, attempt.to_string());
        Ok(command)
    }

    fn of_service(&self, name: &str, scenario: u32) -> Result<Command, String> {
        let mut command = own_command(name)?;
        match name {
            "recorder" => {
                command.arg("--out").arg(&self.draft);
            }
            SCENARIO_NODE => {
                let (phi, e) = self.launch.bins;
                command.args(["--bins", &phi.to_string(), &e.to_string(), "--first", &scenario.to_string()]);
                command.args(&self.scenarios);
            }
            _ => {}
        }
        Ok(command)
    }

    fn of_case(&self, case: &Case) -> Result<Command, String> {
        match &case.runs {
            Runs::BuiltIn { node, settings } => {
                let mut command = own_command(node)?;
                for line in settings.to_lines().map_err(|e| e.to_string())? {
                    command.arg("--set").arg(line);
                }
                Ok(command)
            }
            Runs::Command(words) => {
                let mut command = own_program()?;
                command.args(["guard", "--"]).args(words);
                Ok(command)
            }
        }
    }
}

/// The command that runs one of our own nodes.
fn own_command(kind: &str) -> Result<Command, String> {
    let mut command = own_program()?;
    command.args(["node", kind]);
    Ok(command)
}

fn own_program() -> Result<Command, String> {
    std::env::current_exe().map(Command::new).map_err(|e| format!("cannot find myself: {e}"))
}

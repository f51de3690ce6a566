//! The command line and the environment with which each process of a run is started.

use std::path::{Path, PathBuf};
use std::process::Command;

use messages::domain::{PREFIX_VARIABLE, Place, ROOT_VARIABLE};
use nodes::session::{
    ATTEMPT_VARIABLE, LABEL_VARIABLE, LAUNCHER_VARIABLE, NODE_VARIABLE, REDUCE_VARIABLE, RUN_VARIABLE,
};
use nodes::shard::{SHARD_VARIABLE, SHARDS_VARIABLE};

use crate::launch_file::{Launch, Runs};

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
    /// The recording that the recorder goes on with, if there is one.
    pub tape: Option<PathBuf>,
    /// Arguments of the scenario node: where scenarios come from.
    pub scenarios: Vec<String>,
}

impl Commands<'_> {
    /// The command of process `name`, a service or a member of a case, which has been restarted `attempt` times, while scenario `scenario` is under way.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn of(&self, name: &str, attempt: u32, scenario: u32) -> Result<Command, String> {
        let mut members = self.launch.cases.iter().flat_map(|case| case.members().map(move |member| (case, member)));
        let member = members.find(|(_, (member, _))| member == name);
        let mut command = match (&member, self.launch.substitutes.get(name)) {
            (Some((case, _)), _) => of_what_runs(&case.label, &case.runs)?,
            (None, Some(runs)) => of_what_runs(name, runs)?,
            (None, None) => self.of_service(name, scenario)?,
        };
        command.env(ROOT_VARIABLE, &self.place.root).env(PREFIX_VARIABLE, &self.place.prefix);
        command.env(RUN_VARIABLE, self.run_id.to_string());
        command.env(LAUNCHER_VARIABLE, std::process::id().to_string());
        command.env(NODE_VARIABLE, name);
        for variable in [LABEL_VARIABLE, SHARD_VARIABLE, SHARDS_VARIABLE, REDUCE_VARIABLE] {
            command.env_remove(variable); // only propagators have one
        }
        if let Some((case, (_, shard))) = member {
            command.env(LABEL_VARIABLE, &case.label);
            if case.reduce {
                command.env(REDUCE_VARIABLE, "1");
            }
            if !shard.is_whole() {
                command.env(SHARD_VARIABLE, shard.index.to_string()).env(SHARDS_VARIABLE, shard.count.to_string());
            }
        }
        command.env(ATTEMPT_VARIABLE, attempt.to_string());
        Ok(command)
    }

    fn of_service(&self, name: &str, scenario: u32) -> Result<Command, String> {
        let mut command = own_command(name)?;
        match name {
            "recorder" => {
                command.arg("--out").arg(&self.draft);
                command.args(self.tape.iter().flat_map(|tape| [Path::new("--recording"), tape]));
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
}

/// The command of a case, or of what stands in for one of our own nodes.
fn of_what_runs(name: &str, runs: &Runs) -> Result<Command, String> {
    match runs {
        Runs::BuiltIn { node, settings } => {
            let mut command = own_command(node)?;
            for line in settings.to_lines().map_err(|e| e.to_string())? {
                command.arg("--set").arg(line);
            }
            Ok(command)
        }
        Runs::Recorded(file) => {
            let mut command = own_command("player")?;
            command.args(["--label", name, "--recording"]).arg(file);
            Ok(command)
        }
        Runs::Command(words) => {
            let mut command = own_program()?;
            command.args(["guard", "--"]).args(words);
            Ok(command)
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

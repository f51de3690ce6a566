//! The command line and the environment with which each process of a run is started.

use std::os::unix::fs::MetadataExt;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use kit::environment::{
    ATTEMPT_VARIABLE, LABEL_VARIABLE, LAUNCHER_VARIABLE, NODE_VARIABLE, REDUCE_VARIABLE, RUN_VARIABLE,
};
use kit::shard::{SHARD_VARIABLE, SHARDS_VARIABLE, Shard};
use messages::domain::{PREFIX_VARIABLE, Place, ROOT_VARIABLE};
use messages::service::Service;

use crate::plan::cases::Runs;
use crate::plan::launch_file::Launch;

/// The path under which a process finds the program that it runs; so do its children until they run another one.
const RUNNING: &str = "/proc/self/exe";

/// What is needed to make the commands of a run.
#[derive(Debug)]
pub struct Commands<'a> {
    pub launch: &'a Launch,
    pub place: &'a Place,
    pub run_id: u64,
    /// The folder that the recorder writes to.
    pub draft: PathBuf,
    /// The recording that the recorder continues, if there is one.
    pub tape: Option<PathBuf>,
    /// Arguments of the scenario node: where scenarios come from.
    pub scenarios: Vec<String>,
    /// The file that tells the bridge what to do, if there is a bridge.
    pub bridge_role: Option<PathBuf>,
}

/// Who a process is; it learns that from its environment.
pub struct Identity<'a> {
    /// The domain.
    pub place: &'a Place,
    /// The run.
    pub run_id: u64,
    /// Name of the process.
    pub name: &'a str,
    /// The part that a propagator has in its case; `None` for other nodes.
    pub part: Option<Part<'a>>,
    /// How often it has been restarted.
    pub attempt: u32,
}

/// What a propagator does in its case.
pub struct Part<'a> {
    /// The label of the case.
    pub label: &'a str,
    /// Which shard of it.
    pub shard: Shard,
    /// Whether it reduces its samples before it sends them.
    pub reduce: bool,
}

impl Identity<'_> {
    /// Puts the identity into the environment of a command.
    pub fn give(&self, command: &mut Command) {
        command.env(ROOT_VARIABLE, &self.place.root).env(PREFIX_VARIABLE, &self.place.prefix);
        command.env(RUN_VARIABLE, self.run_id.to_string());
        command.env(LAUNCHER_VARIABLE, std::process::id().to_string());
        command.env(NODE_VARIABLE, self.name);
        for variable in [LABEL_VARIABLE, SHARD_VARIABLE, SHARDS_VARIABLE, REDUCE_VARIABLE] {
            command.env_remove(variable); // only propagators have these
        }
        if let Some(Part { label, shard, reduce }) = self.part {
            command.env(LABEL_VARIABLE, label);
            if reduce {
                command.env(REDUCE_VARIABLE, "1");
            }
            if !shard.is_whole() {
                command.env(SHARD_VARIABLE, shard.index.to_string()).env(SHARDS_VARIABLE, shard.count.to_string());
            }
        }
        command.env(ATTEMPT_VARIABLE, self.attempt.to_string());
    }
}

impl Commands<'_> {
    /// The names of the other hosts.
    pub fn hosts(&self) -> &[String] {
        self.launch.hosts.as_ref().map_or(&[], |hosts| &hosts.names)
    }

    /// The command of the process `name`, a service or a member of a case, which has been restarted `attempt` times.
    /// The scenario `scenario` is under way.
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
        let part =
            member.as_ref().map(|(case, (_, shard))| Part { label: &case.label, shard: *shard, reduce: case.reduce });
        Identity { place: self.place, run_id: self.run_id, name, part, attempt }.give(&mut command);
        Ok(command)
    }

    fn of_service(&self, name: &str, scenario: u32) -> Result<Command, String> {
        let mut command = own_command(name)?;
        match Service::named(name) {
            Some(Service::Recorder) => {
                command.arg("--out").arg(&self.draft).args(["--tolerance", &self.launch.tolerance.to_string()]);
                command.args(self.tape.iter().flat_map(|tape| [Path::new("--recording"), tape]));
            }
            Some(Service::Scenario) => {
                let (phi, e) = self.launch.bins;
                command.args(["--bins", &phi.to_string(), &e.to_string(), "--first", &scenario.to_string()]);
                command.args(&self.scenarios);
            }
            Some(Service::Bridge) => {
                command.args(self.bridge_role.iter().flat_map(|bridge_role| [Path::new("--bridge-role"), bridge_role]));
            }
            Some(Service::Estimator | Service::Comparator) | None => {}
        }
        Ok(command)
    }
}

/// Name of the node that plays back what another node sent.
pub const PLAYER: &str = "player";

/// The command of a case, or of what replaces one of our own nodes.
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
            let mut command = own_command(PLAYER)?;
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
///
/// # Errors
/// If this program cannot be found.
pub fn own_command(kind: &str) -> Result<Command, String> {
    let mut command = own_program()?;
    command.args(["node", kind]);
    Ok(command)
}

/// This program.
///
/// # Errors
/// If it cannot be found.
pub fn own_program() -> Result<Command, String> {
    own_path().map(|path| {
        let mut command = Command::new(path);
        command.arg0("phasecloud");
        command
    })
}

/// Where this program lies, also if its file has been replaced or removed since it was started: the kernel still has
/// the program that runs, and the processes of one run must not be of two versions.
///
/// # Errors
/// If it cannot be found.
pub fn own_path() -> Result<PathBuf, String> {
    let failed = |e: std::io::Error| format!("{RUNNING}: this program cannot find itself: {e}");
    let running = std::fs::metadata(RUNNING).map_err(failed)?;
    let named = std::env::current_exe().map_err(failed)?;
    let is_the_same = |found: std::fs::Metadata| (found.dev(), found.ino()) == (running.dev(), running.ino());
    Ok(if std::fs::metadata(&named).is_ok_and(is_the_same) { named } else { RUNNING.into() })
}

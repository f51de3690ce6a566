//! What a command takes from its environment: not what is meant for the processes of a run.
//!
//! A propagator is known by the label in its environment, whatever it says of itself. A launcher that bears one, exported by
//! its user or inherited from a propagator that starts runs, would be taken for a propagator, and nobody would believe its
//! roster. The kernel shows the environment that a program was started with, so the launcher starts itself anew without.

use std::os::unix::process::CommandExt;

use messages::domain::{PREFIX_VARIABLE, ROOT_VARIABLE};
use nodes::session::{
    ATTEMPT_VARIABLE, GRACE_VARIABLE, LABEL_VARIABLE, LAUNCHER_VARIABLE, NODE_VARIABLE, REDUCE_VARIABLE, RUN_VARIABLE,
};
use nodes::shard::{SHARD_VARIABLE, SHARDS_VARIABLE};

use crate::crew::commands::own_program;

/// Variables by which a launcher tells its processes who they are.
pub const OF_PROCESSES: [&str; 11] = [
    ROOT_VARIABLE,
    PREFIX_VARIABLE,
    RUN_VARIABLE,
    LAUNCHER_VARIABLE,
    NODE_VARIABLE,
    LABEL_VARIABLE,
    SHARD_VARIABLE,
    SHARDS_VARIABLE,
    REDUCE_VARIABLE,
    ATTEMPT_VARIABLE,
    GRACE_VARIABLE,
];

/// The commands that are processes of a run themselves.
const PROCESSES: [&str; 2] = ["node", "guard"];

/// Starts this program anew without the variables of processes, if it has any and is none.
///
/// # Errors
/// If that is not possible.
pub fn shed() -> Result<(), String> {
    let is_process = std::env::args_os().nth(1).is_some_and(|word| PROCESSES.iter().any(|name| word == *name));
    if is_process || OF_PROCESSES.iter().all(|name| std::env::var_os(name).is_none()) {
        return Ok(());
    }
    let mut anew = own_program()?;
    anew.args(std::env::args_os().skip(1));
    for name in OF_PROCESSES {
        anew.env_remove(name);
    }
    let names = OF_PROCESSES.join(", ");
    Err(format!("cannot start anew without {names}, which are for the processes of a run: {}", anew.exec()))
}

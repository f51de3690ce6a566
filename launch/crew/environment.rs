//! Removes from the environment of a command what is meant for the processes of a run.
//!
//! A propagator is recognised by the label in its environment, whatever its messages say. A launcher with a label,
//! exported by its user or inherited from a propagator that starts runs, would be taken for a propagator, and its
//! roster would not be believed. The kernel shows the environment with which a program was started, so the launcher
//! starts itself anew without these variables.

use std::os::unix::process::CommandExt;

use kit::environment::{
    ATTEMPT_VARIABLE, GRACE_VARIABLE, LABEL_VARIABLE, LAUNCHER_VARIABLE, NODE_VARIABLE, REDUCE_VARIABLE, RUN_VARIABLE,
};
use kit::shard::{SHARD_VARIABLE, SHARDS_VARIABLE};
use messages::domain::{PREFIX_VARIABLE, ROOT_VARIABLE};

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

/// Starts this program anew without these variables, if it has any of them and is not a process of a run itself.
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

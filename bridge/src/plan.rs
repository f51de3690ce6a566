//! Who does what: the share of each worker host in a run.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::endpoint::Access;

/// The name of the host that a run is started on, where it is estimated, compared and recorded.
pub const HOME: &str = "home";

/// Where a bridge stands, and what it needs to know there; a file of the launcher's tells it.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Post {
    /// On the home host.
    Home {
        /// Where to listen.
        access: Access,
        /// The plans of the worker hosts, by name.
        plans: BTreeMap<String, Plan>,
    },
    /// On a worker host.
    Worker {
        /// Where home is.
        access: Access,
        /// The worker host's name.
        host: String,
        /// What it has greeted home with.
        process: u64,
        /// The file with its log.
        log: PathBuf,
    },
}

/// A process that a worker host is to run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Share {
    /// Its name.
    pub name: String,
    /// The label of its case.
    pub label: String,
    /// Which shard of the case it is, of how many.
    pub shard: (u32, u32),
    /// Whether it reduces its samples before it sends them.
    pub reduce: bool,
    /// What runs.
    pub program: Program,
}

/// What a process runs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Program {
    /// A propagator that comes with phasecloud, and its settings.
    BuiltIn {
        /// Its name.
        node: String,
        /// A line of TOML each.
        settings: Vec<String>,
    },
    /// Any program: command and arguments.
    Command(Vec<String>),
}

/// A worker host's part in a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Plan {
    /// The run.
    pub run_id: u64,
    /// The name of the launch file's run.
    pub name: String,
    /// Processes of the whole run that propagate.
    pub propagators: usize,
    /// Its cases.
    pub cases: usize,
    /// Snapshots of the longest scenario.
    pub snapshots: usize,
    /// Whether a process that dies is started again.
    pub restart: bool,
    /// The processes.
    pub members: Vec<Share>,
}

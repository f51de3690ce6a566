//! Who does what: the share of each worker host in a run, or in a map.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::endpoint::Access;

/// The name of the host on which a run is started, with its estimator, comparator and recorder.
pub const HOME: &str = "home";

/// On which host a bridge runs, and what it needs to know there; it reads this from a file that the launcher writes.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BridgeRole {
    /// On the home host.
    Home {
        /// Where to listen.
        access: Access,
        /// The plans of the worker hosts, by name.
        plans: BTreeMap<String, HostPlan>,
    },
    /// On a worker host.
    Worker {
        /// Where home is.
        access: Access,
        /// The worker host's name.
        host: String,
        /// The number with which its process has greeted home.
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
        /// One line of TOML per setting.
        settings: Vec<String>,
    },
    /// Any program: command and arguments.
    Command(Vec<String>),
}

/// What a worker host is told to do when it greets home.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Work {
    /// Its share of a run.
    Run(HostPlan),
    /// Parts of a map, for which it asks one after another.
    Map(MapPlan),
}

/// A map to whose computation worker hosts contribute.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MapPlan {
    /// A number that home has drawn for this computation of the map. Home draws another one when it is started again.
    pub map_id: u64,
    /// The path of the map file at home, by which it is named.
    pub file: PathBuf,
    /// The text of the map file.
    pub text: String,
    /// The text of its scenario file.
    pub scenario: String,
}

/// A worker host's part in a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct HostPlan {
    /// The run.
    pub run_id: u64,
    /// The name of the run in the launch file.
    pub name: String,
    /// Number of processes of the whole run that propagate.
    pub propagators: usize,
    /// Number of cases of the whole run.
    pub cases: usize,
    /// Number of snapshots of the longest scenario.
    pub snapshots: usize,
    /// Whether a process that dies is started again.
    pub restart: bool,
    /// The processes that this host is to run.
    pub members: Vec<Share>,
}

//! The variables by which a launcher tells a process what it is.

/// Environment variable that holds a propagator's label.
pub const LABEL_VARIABLE: &str = "PHASECLOUD_LABEL";
/// Environment variable that holds the name of a node that a launcher started. The name of a propagator is its label,
/// that of a shard is the label with the shard's number.
pub const NODE_VARIABLE: &str = "PHASECLOUD_NODE";
/// Environment variable that holds the number that names the run.
pub const RUN_VARIABLE: &str = "PHASECLOUD_RUN_ID";
/// Environment variable that holds the launcher's process id: a node that it started ends with it.
pub const LAUNCHER_VARIABLE: &str = "PHASECLOUD_LAUNCHER";

/// Environment variable that holds how often the launcher has restarted the node.
pub const ATTEMPT_VARIABLE: &str = "PHASECLOUD_ATTEMPT";

/// Environment variable that is 1 if a propagator is to reduce its samples before it sends them.
pub const REDUCE_VARIABLE: &str = "PHASECLOUD_REDUCE";

/// Environment variable that says how many seconds a node that was asked to stop may go on computing.
pub const GRACE_VARIABLE: &str = "PHASECLOUD_GRACE";

//! Launch files: what is to run, checked before anything starts.

pub(crate) mod baseline;
pub(crate) mod built_in;
pub mod cases;
mod checks;
pub mod hosts;
pub mod launch_file;
pub(crate) mod preflight;
pub(crate) mod programs;
mod references;
pub(crate) mod refusals;
pub mod scenario_inputs;
pub(crate) mod schema;

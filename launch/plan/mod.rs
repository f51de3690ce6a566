//! Launch files: what is to run, checked before anything starts.

pub mod cases;
mod checks;
pub mod hosts;
pub mod launch_file;
pub(crate) mod preflight;
pub(crate) mod programs;

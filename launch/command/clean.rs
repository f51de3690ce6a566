//! `phasecloud clean`: removes what runs left in shared memory when their launchers were killed.

use std::process::ExitCode;

use crate::domain;

/// Removes the remains of dead runs and prints which; live runs are not touched.
pub fn run() -> ExitCode {
    for place in domain::sweep() {
        say!("removed {}", place.root.display());
    }
    for place in domain::live() {
        say!("in use  {}", place.root.display());
    }
    ExitCode::SUCCESS
}

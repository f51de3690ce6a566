//! `phasecloud clean`: removes what runs whose launcher was killed have left behind.

use std::process::ExitCode;

use crate::domains;

/// Removes the remains of dead runs and says which; live ones are not touched.
pub fn run() -> ExitCode {
    for place in domains::sweep() {
        say!("removed {}", place.root.display());
    }
    for place in domains::live() {
        say!("in use  {}", place.root.display());
    }
    ExitCode::SUCCESS
}

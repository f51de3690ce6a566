//! `phasecloud clean`: removes what runs whose launcher was killed have left behind.

use std::process::ExitCode;

use crate::domain;

/// Removes the remains of dead runs and says which; live ones are not touched.
pub fn run() -> ExitCode {
    for place in domain::sweep() {
        say!("removed {}", place.root.display());
    }
    for place in domain::live() {
        say!("in use  {}", place.root.display());
    }
    ExitCode::SUCCESS
}

//! The bridge as a node.

use std::path::Path;

use kit::failure::Failure;
use kit::session::Session;
use messages::domain::Place;

use super::greeting::Hello;
use super::{home, worker};
use crate::plan::BridgeRole;

/// Carries messages as the file at `path` says.
///
/// # Errors
/// [`Failure::Stopped`] is the normal end at home. On a worker host the normal end is no error: the run at home has
/// ended.
pub fn run(session: &Session, place: &Place, path: &Path) -> Result<(), Failure> {
    let text = std::fs::read(path).map_err(|e| Failure::file(path, e))?;
    match serde_json::from_slice(&text).map_err(|e| Failure::file(path, e))? {
        BridgeRole::Home { access, plans } => home::run(session, place, &access, plans),
        BridgeRole::Worker { access, host, process, log } => {
            worker::run(session, place, &access, &Hello::of(&host, process), &log)
        }
    }
}

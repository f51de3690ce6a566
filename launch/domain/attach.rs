//! Finding a live run: by its number, by its domain, or because there is only one.

use std::path::{Path, PathBuf};

use clap::Args;
use messages::domain::Place;
use serde::{Deserialize, Serialize};

use super::keeper::NOTICE;
use crate::domain;
use crate::plan::launch_file::Launch;

/// Which run a command is about.
#[derive(Debug, Clone, Default, Args)]
pub struct Target {
    /// The number of the run, or enough of its first digits to tell it from others
    #[arg(long, value_name = "ID")]
    pub run: Option<String>,
    /// The run's domain as ROOT:PREFIX
    #[arg(long, value_name = "ROOT:PREFIX", conflicts_with = "run")]
    pub domain: Option<String>,
}

/// What the launcher tells those that attach to its run.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Notice {
    /// The launch file's name for the run.
    pub name: String,
    /// Where the results will be.
    pub results: PathBuf,
    /// Whether it is a service, which takes requests.
    pub takes_requests: bool,
}

/// A live run.
#[derive(Debug, Clone)]
pub struct LiveRun {
    /// Where its domain lies.
    pub place: Place,
    /// The notice of its launcher; a domain that was made by hand has none.
    pub notice: Option<Notice>,
}

impl LiveRun {
    fn at(place: Place) -> Self {
        let text = std::fs::read(place.root.join(NOTICE)).ok();
        let notice = text.and_then(|text| serde_json::from_slice(&text).ok());
        Self { place, notice }
    }

    /// Whether requests may be answered there; they may in a domain that was made by hand, of which this is not known.
    fn may_take_requests(&self) -> bool {
        self.notice.as_ref().is_none_or(|notice| notice.takes_requests)
    }

    /// The run's number, as the name of its domain's folder.
    pub fn id(&self) -> String {
        self.place.root.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Number and name.
    pub fn title(&self) -> String {
        match &self.notice {
            Some(notice) => format!("run {} ({})", self.id(), notice.name),
            None => format!("run {}", self.id()),
        }
    }
}

/// Writes into the domain's folder what is run there, and whether it takes requests.
///
/// # Errors
/// If it cannot be written.
pub fn announce(place: &Place, launch: &Launch, results: &Path, takes_requests: bool) -> Result<(), String> {
    let results = std::path::absolute(results).unwrap_or_else(|_| results.into());
    let path = place.root.join(NOTICE);
    let failed = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
    let text =
        serde_json::to_vec(&Notice { name: launch.name.clone(), results, takes_requests }).map_err(|e| failed(&e))?;
    std::fs::write(&path, text).map_err(|e| failed(&e))
}

/// All live runs of this user.
pub fn live_runs() -> Vec<LiveRun> {
    domain::live().into_iter().map(LiveRun::at).collect()
}

/// The run that `target` means.
///
/// # Errors
/// If there is none, or several; the message then lists those to choose from.
pub fn find(target: &Target) -> Result<LiveRun, String> {
    find_among(live_runs(), target, "there is no live run; start one with `phasecloud run`")
}

/// The service that `target` means.
///
/// # Errors
/// If there is none, or several; the message then lists those to choose from.
pub fn find_service(target: &Target) -> Result<LiveRun, String> {
    let services = live_runs().into_iter().filter(LiveRun::may_take_requests).collect();
    find_among(
        services,
        target,
        "there is no service that takes requests; start one with `phasecloud serve LAUNCH_FILE`",
    )
}

fn find_among(mut runs: Vec<LiveRun>, target: &Target, none: &str) -> Result<LiveRun, String> {
    if let Some(domain) = &target.domain {
        let (root, prefix) = domain.rsplit_once(':').ok_or("--domain must be ROOT:PREFIX")?;
        let place = Place { root: root.into(), prefix: prefix.into() };
        return if domain::is_live(&place) { Ok(LiveRun::at(place)) } else { Err(format!("no run lives in {domain}")) };
    }
    let wanted = target.run.as_deref().unwrap_or("");
    let matching: Vec<usize> = (0..runs.len()).filter(|&i| runs[i].id().starts_with(wanted)).collect();
    match matching[..] {
        [one] => Ok(runs.swap_remove(one)),
        [] if runs.is_empty() => Err(none.into()),
        _ => Err(format!("which run? Give --run ID, one of:\n{}", list(&runs))),
    }
}

fn list(runs: &[LiveRun]) -> String {
    runs.iter().map(|run| format!("  {}", run.title())).collect::<Vec<_>>().join("\n")
}

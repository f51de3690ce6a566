//! The results folder: whole or not there.
//!
//! A folder that does not exist yet is written under a temporary name beside its final one and renamed when it is
//! whole. One that exists, perhaps a mount point or in a parent that is not ours, cannot be replaced so: it is filled.
//! The draft then lies inside it, and its files move up when they are whole, the manifest last.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use kit::clock;
use results::files::{MANIFEST, SCENARIOS, is_part};

use crate::plan::launch_file::Launch;
use crate::plan::preflight::check_path;
use crate::plan::scenario_inputs::ScenarioInput;
use crate::record::checksums::LOST_AND_FOUND;

/// A results folder in the making.
#[derive(Debug)]
pub struct ResultsFolder {
    /// Where the files are written for now.
    pub draft: PathBuf,
    /// Where they will be.
    pub path: PathBuf,
    /// Whether the folder was there before, so that it is filled.
    fills: bool,
}

impl ResultsFolder {
    /// Makes room for the results of a run called `name`, in `chosen` or else in `results/NAME-TIME`. This shows,
    /// before anything is computed, whether they can be written there.
    ///
    /// # Errors
    /// Which folder cannot be used, and why.
    pub fn prepare(chosen: Option<&Path>, name: &str, run_id: u64) -> Result<Self, String> {
        let path = chosen.map_or_else(|| default_path(name), Path::to_path_buf);
        // An existing folder by its real name: `.` or a link cannot be replaced under the name given.
        let path = path.canonicalize().unwrap_or(path);
        check_path("--out", &path)?;
        let unusable = |error: io::Error| format!("cannot write results to {}: {error}", path.display());
        let fills = is_there_and_empty(&path)?;
        let place = if fills {
            path.as_path()
        } else {
            let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
            fs::create_dir_all(parent).map_err(unusable)?;
            parent
        };
        let draft = place.join(format!("{DRAFT_START}{run_id:012x}{DRAFT_END}"));
        fs::create_dir(&draft).map_err(unusable)?;
        Ok(Self { draft, path, fills })
    }

    /// Keeps a copy of every scenario file in the results, and returns the paths.
    ///
    /// # Errors
    /// Which file cannot be written, and why.
    pub fn keep_scenarios(&self, launch: &Launch) -> Result<Vec<PathBuf>, String> {
        let folder = self.draft.join(SCENARIOS);
        fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let keep = |scenario: &ScenarioInput| {
            let path = folder.join(format!("{}.toml", scenario.content.name()));
            fs::write(&path, &scenario.text).map_err(|e| format!("{}: {e}", path.display()))?;
            Ok(path)
        };
        launch.scenarios.iter().map(keep).collect()
    }

    /// Keeps only the scenarios `kept`, and removes what the recorder has begun for others.
    ///
    /// # Errors
    /// What cannot be removed, and why.
    pub fn keep_only(&self, kept: &[ScenarioInput]) -> Result<(), String> {
        let failed = |path: &Path, e: io::Error| format!("{}: {e}", path.display());
        let names: Vec<String> = kept.iter().map(|scenario| format!("{}.toml", scenario.content.name())).collect();
        let folder = self.draft.join(SCENARIOS);
        for entry in fs::read_dir(&folder).map_err(|e| failed(&folder, e))?.flatten() {
            if !names.contains(&entry.file_name().to_string_lossy().into_owned()) {
                fs::remove_file(entry.path()).map_err(|e| failed(&entry.path(), e))?;
            }
        }
        for entry in fs::read_dir(&self.draft).map_err(|e| failed(&self.draft, e))?.flatten() {
            if is_part(&entry.path()) {
                fs::remove_dir_all(entry.path()).map_err(|e| failed(&entry.path(), e))?;
            }
        }
        Ok(())
    }

    /// Puts the results where they belong.
    ///
    /// # Errors
    /// If the operating system refuses; the results then stay under the temporary name.
    pub fn publish(&self) -> Result<(), String> {
        let published = if self.fills { fill(&self.draft, &self.path) } else { fs::rename(&self.draft, &self.path) };
        published.map_err(|e| {
            format!("the results are in {}, they cannot be moved to {}: {e}", self.draft.display(), self.path.display())
        })
    }

    /// In words, where the results lie that could not be sealed.
    pub fn remains(&self) -> String {
        format!("the tables are whole, but not sealed, in {}", self.draft.display())
    }

    /// Removes what has been written.
    pub fn discard(&self) {
        let _ = fs::remove_dir_all(&self.draft);
    }
}

/// The temporary name: what stands before and after the run's number.
const DRAFT_START: &str = ".phasecloud-";
const DRAFT_END: &str = ".partial";

/// Whether there is an empty folder to fill.
///
/// # Errors
/// What is there instead.
fn is_there_and_empty(path: &Path) -> Result<bool, String> {
    let unusable = |error: io::Error| format!("cannot write results to {}: {error}", path.display());
    let entries = match fs::read_dir(path) {
        Ok(entries) => entries,
        Err(error) if error.kind() == ErrorKind::NotFound && path.is_symlink() => {
            return Err(format!("cannot write results to {}: it is a link to nothing", path.display()));
        }
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(false),
        Err(error) => return Err(unusable(error)),
    };
    for entry in entries {
        let name = entry.map_err(unusable)?.file_name().to_string_lossy().into_owned();
        if name.starts_with(DRAFT_START) && name.ends_with(DRAFT_END) {
            return Err(format!(
                "the results folder {} holds {name}, of a run that is under way or was killed; remove that if no such run is left",
                path.display()
            ));
        }
        // A folder that is a file system of its own has this from the start.
        if name != LOST_AND_FOUND {
            return Err(format!("the results folder {} is not empty; name a new or empty one", path.display()));
        }
    }
    Ok(true)
}

/// Moves everything in `draft` up into `folder`; the manifest, which says that the results are whole, comes last.
fn fill(draft: &Path, folder: &Path) -> io::Result<()> {
    let mut names = fs::read_dir(draft)?.map(|entry| Ok(entry?.file_name())).collect::<io::Result<Vec<_>>>()?;
    names.sort_by_key(|name| name == MANIFEST);
    for name in names {
        fs::rename(draft.join(&name), folder.join(&name))?;
    }
    fs::remove_dir(draft)
}

/// The name for the results of a launch file: that of its scenario, or that of the launch file if there are several.
pub fn name_of(launch: &Launch) -> &str {
    match &launch.scenarios[..] {
        [only] => only.content.name(),
        _ => &launch.name,
    }
}

fn default_path(name: &str) -> PathBuf {
    let time = clock::millis().replace(':', "-");
    Path::new("results").join(format!("{name}-{time}"))
}

//! The results folder: written under a temporary name beside its final one and renamed when it is whole.

use std::path::{Path, PathBuf};

use nodes::clock;
use nodes::recorder::is_part;

use crate::launch_file::{Launch, ScenarioInput};

/// A results folder in the making.
#[derive(Debug)]
pub struct ResultsFolder {
    /// Where the files are written for now.
    pub draft: PathBuf,
    /// Where they will be.
    pub path: PathBuf,
}

impl ResultsFolder {
    /// Makes room for the results of a run called `name`, in `chosen` or else in `results/NAME-TIME`.
    ///
    /// # Errors
    /// Which folder cannot be used, and why.
    pub fn prepare(chosen: Option<&Path>, name: &str, run_id: u64) -> Result<Self, String> {
        let path = chosen.map_or_else(|| default_path(name), Path::to_path_buf);
        // An existing folder by its real name: `.` or a link cannot be replaced under the name given.
        let path = path.canonicalize().unwrap_or(path);
        let unusable = |error: std::io::Error| format!("cannot write results to {}: {error}", path.display());
        match std::fs::read_dir(&path) {
            Ok(mut entries) => {
                if entries.next().is_some() {
                    return Err(format!("the results folder {} is not empty; name a new or empty one", path.display()));
                }
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            Err(error) => return Err(unusable(error)),
        }
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        std::fs::create_dir_all(parent).map_err(unusable)?;
        let draft = parent.join(format!(".phasecloud-{run_id:012x}.partial"));
        std::fs::create_dir(&draft).map_err(unusable)?;
        Ok(Self { draft, path })
    }

    /// Keeps a copy of every scenario file in the results, and says where.
    ///
    /// # Errors
    /// Which file cannot be written, and why.
    pub fn keep_scenarios(&self, launch: &Launch) -> Result<Vec<PathBuf>, String> {
        let folder = self.draft.join("scenarios");
        std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let keep = |scenario: &ScenarioInput| {
            let path = folder.join(format!("{}.toml", scenario.content.name));
            std::fs::write(&path, &scenario.text).map_err(|e| format!("{}: {e}", path.display()))?;
            Ok(path)
        };
        launch.scenarios.iter().map(keep).collect()
    }

    /// Keeps of the scenarios only `kept`, and nothing that the recorder has begun of others.
    ///
    /// # Errors
    /// What cannot be removed, and why.
    pub fn keep_only(&self, kept: &[ScenarioInput]) -> Result<(), String> {
        let failed = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
        let names: Vec<String> = kept.iter().map(|scenario| format!("{}.toml", scenario.content.name)).collect();
        let folder = self.draft.join("scenarios");
        for entry in std::fs::read_dir(&folder).map_err(|e| failed(&folder, e))?.flatten() {
            if !names.contains(&entry.file_name().to_string_lossy().into_owned()) {
                std::fs::remove_file(entry.path()).map_err(|e| failed(&entry.path(), e))?;
            }
        }
        for entry in std::fs::read_dir(&self.draft).map_err(|e| failed(&self.draft, e))?.flatten() {
            if is_part(&entry.path()) {
                std::fs::remove_dir_all(entry.path()).map_err(|e| failed(&entry.path(), e))?;
            }
        }
        Ok(())
    }

    /// Gives the folder its final name.
    ///
    /// # Errors
    /// If the operating system refuses; the results then stay under the temporary name.
    pub fn publish(&self) -> Result<(), String> {
        std::fs::rename(&self.draft, &self.path).map_err(|e| {
            format!("the results are in {}, they cannot be moved to {}: {e}", self.draft.display(), self.path.display())
        })
    }

    /// Removes what has been written.
    pub fn discard(&self) {
        let _ = std::fs::remove_dir_all(&self.draft);
    }
}

fn default_path(name: &str) -> PathBuf {
    let time = clock::millis().replace(':', "-");
    Path::new("results").join(format!("{name}-{time}"))
}

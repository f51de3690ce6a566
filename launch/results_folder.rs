//! The results folder: written under a temporary name beside its final one and renamed when it is whole.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

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
    let time = humantime::format_rfc3339_millis(SystemTime::now()).to_string().replace(':', "-");
    Path::new("results").join(format!("{name}-{time}"))
}

//! What a recording says of the run: enough to run it again.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::plan::launch_file::Launch;

/// The text at the start of a recording, as JSON.
#[derive(Debug, Serialize, Deserialize)]
pub struct About {
    /// Names the run.
    pub run_id: String,
    /// Hash of what was configured, see [`configuration`].
    pub configuration: String,
    /// The program's version.
    pub version: String,
    /// The launch file.
    pub launch_file: String,
    /// The scenarios: name and text.
    pub scenarios: Vec<(String, String)>,
}

/// SHA-256 of the launch file and the scenarios, each preceded by its length, in hexadecimal digits.
pub fn configuration(launch: &Launch) -> String {
    let mut hash = Sha256::new();
    for text in std::iter::once(&launch.text).chain(launch.scenarios.iter().map(|scenario| &scenario.text)) {
        hash.update((text.len() as u64).to_le_bytes());
        hash.update(text);
    }
    hash.finalize().iter().fold(String::new(), |mut digits, byte| {
        let _ = write!(digits, "{byte:02x}");
        digits
    })
}

/// A recording in the making: under a temporary name until the run has ended well.
#[derive(Debug)]
pub struct Draft {
    /// Where it will be.
    path: PathBuf,
    /// Where it is written.
    pub draft: PathBuf,
}

impl Draft {
    /// Begins the recording of a run in a new file.
    ///
    /// # Errors
    /// If the file exists already or cannot be written.
    pub fn begin(path: &Path, launch: &Launch, run_id: u64) -> Result<Self, String> {
        if path.exists() {
            return Err(format!("{} exists already; name a new file for the recording", path.display()));
        }
        let about = About {
            run_id: format!("{run_id:012x}"),
            configuration: configuration(launch),
            version: env!("CARGO_PKG_VERSION").into(),
            launch_file: launch.text.clone(),
            scenarios: launch.scenarios.iter().map(|s| (s.content.name().to_owned(), s.text.clone())).collect(),
        };
        let about = serde_json::to_string(&about).map_err(|e| format!("{}: {e}", path.display()))?;
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(format!(".{run_id:012x}.partial"));
        let draft = path.with_file_name(name);
        messages::recording::start(&draft, &about).map_err(|e| format!("cannot record to {e}"))?;
        Ok(Self { path: path.into(), draft })
    }

    /// Gives the recording its name.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub fn publish(self) -> Result<(), String> {
        let renamed = std::fs::rename(&self.draft, &self.path);
        renamed.map_err(|e| format!("the recording is in {}: {}: {e}", self.draft.display(), self.path.display()))
    }

    /// Removes it.
    pub fn discard(self) {
        let _ = std::fs::remove_file(&self.draft);
    }
}

//! Reads a results folder.

use std::path::Path;

use crate::description::{self, Description};
use crate::error::FolderError;
use crate::files;
use crate::manifest::{self, Manifest};
use crate::moments::{self, MomentsRow};
use crate::rows::{DiagnosticRow, DistanceRow, EffortRow, ErrorRow, GivenRow, NoteRow, PassageRow, VerdictRow};
use crate::table::{read, read_if_there};

/// The manifest and the tables of a results folder. The densities are read one by one ([`crate::arrays::ArrayReader`]).
#[derive(Debug, Clone, Default)]
#[expect(missing_docs, reason = "there is one field for each file")]
pub struct Results {
    pub manifest: Manifest,
    pub moments: Vec<MomentsRow>,
    pub errors: Vec<ErrorRow>,
    pub distances: Vec<DistanceRow>,
    pub effort: Vec<EffortRow>,
    pub passages: Vec<PassageRow>,
    pub given: Vec<GivenRow>,
    pub diagnostics: Vec<DiagnosticRow>,
    pub notes: Vec<NoteRow>,
    pub verdicts: Vec<VerdictRow>,
    pub descriptions: Vec<Description>,
}

impl Results {
    /// Reads the folder.
    ///
    /// # Errors
    /// [`FolderError`] names the first file that is missing or damaged.
    pub fn read(folder: &Path) -> Result<Self, FolderError> {
        Ok(Self {
            manifest: manifest::read(folder)?,
            moments: moments::read(&folder.join(files::MOMENTS))?,
            errors: read(&folder.join(files::ERRORS))?,
            distances: read(&folder.join(files::DISTANCES))?,
            effort: read(&folder.join(files::EFFORT))?,
            passages: read(&folder.join(files::FIRST_PASSAGE))?,
            given: read_if_there(&folder.join(files::GIVEN_RE_ENTRY))?,
            diagnostics: read(&folder.join(files::DIAGNOSTICS))?,
            notes: read(&folder.join(files::NOTES))?,
            descriptions: description::read(folder)?,
            verdicts: read_if_there(&folder.join(files::VERDICTS))?,
        })
    }
}

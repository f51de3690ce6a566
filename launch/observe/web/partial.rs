//! The report of a run under way: that of the cases that have arrived.

use std::path::Path;

use figures::report::PAGE;
use nodes::services::recorder::SoFar;
use results::manifest::{self, CaseRecord, Manifest};

use crate::command::report;
use density::trust::TOLERANCE;

/// Makes the report in a folder that exists only for this, and returns its page.
///
/// # Errors
/// What could not be written, or drawn.
pub fn report(so_far: &SoFar) -> Result<String, String> {
    let folder = tempfile::tempdir().map_err(|e| format!("a temporary folder: {e}"))?;
    so_far.write(folder.path(), TOLERANCE).map_err(|e| e.to_string())?;
    manifest::write(folder.path(), &manifest_of(so_far)).map_err(|e| e.to_string())?;
    report::make(folder.path())?;
    page(folder.path())
}

/// The page of a results folder.
///
/// # Errors
/// If it cannot be read.
pub fn page(folder: &Path) -> Result<String, String> {
    let page = folder.join(PAGE);
    std::fs::read_to_string(&page).map_err(|e| format!("{}: {e}", page.display()))
}

/// What is known of a run before its manifest is written.
fn manifest_of(so_far: &SoFar) -> Manifest {
    let roster = so_far.roster();
    let (arrived, all) = (so_far.complete_cases().len(), roster.cases.len());
    let case = |(label, _): &(String, bool)| (label.clone(), CaseRecord::default());
    Manifest {
        run_id: format!("{:012x}", so_far.run_id()),
        reference: roster.references.first().cloned().unwrap_or_default(),
        references: roster.references.clone(),
        baseline: roster.baseline.clone(),
        tolerance: TOLERANCE,
        cases: roster.cases.iter().map(case).collect(),
        failures: roster.reasons.clone(),
        incomplete_because: Some(format!("the run is under way, and {arrived} of {all} cases have arrived")),
        ..Manifest::default()
    }
}

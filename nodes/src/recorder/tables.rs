//! The files of a results folder: CSV tables with full precision, and the densities.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use messages::layout::comparison;
use messages::text::unpack;
use serde::Serialize;

use super::densities::Densities;
use super::{Judgement, RecordedComparison, Recording, SCENARIO, judgement, rows};
use crate::assignment::Assignment;
use crate::failure::Failure;
use crate::roster::Roster;
use crate::scenario_file;

/// An open CSV file.
struct Table {
    path: PathBuf,
    writer: csv::Writer<File>,
}

impl Table {
    fn create(folder: &Path, name: &str) -> Result<Self, Failure> {
        let path = folder.join(name);
        let writer = csv::Writer::from_path(&path).map_err(|e| Failure::file(&path, e))?;
        Ok(Self { path, writer })
    }

    fn write(&mut self, rows: impl IntoIterator<Item = impl Serialize>) -> Result<(), Failure> {
        for row in rows {
            self.writer.serialize(row).map_err(|e| Failure::file(&self.path, e))?;
        }
        Ok(())
    }

    fn finish(mut self) -> Result<(), Failure> {
        self.writer.flush().map_err(|e| Failure::file(&self.path, e))
    }
}

/// Writes the files of a scenario into `folder`. It is there whole or not at all, and one that is there stays as it is.
pub(crate) fn write(recording: &Recording, roster: &Roster, folder: &Path, tolerance: f64) -> Result<(), Failure> {
    if folder.exists() {
        return Ok(());
    }
    let draft = folder.with_extension("partial");
    let failed = |e| Failure::file(&draft, e);
    if draft.exists() {
        fs::remove_dir_all(&draft).map_err(failed)?;
    }
    fs::create_dir(&draft).map_err(failed)?;
    let mut tables = Tables::create(&draft)?;
    tables.write(recording, roster, tolerance)?;
    tables.finish()?;
    let Assignment { name, problem, .. } = &recording.assignment;
    fs::write(draft.join(SCENARIO), scenario_file::to_text(name, problem)).map_err(failed)?;
    fs::rename(&draft, folder).map_err(failed)
}

/// The open files of a scenario.
struct Tables {
    moments: Table,
    errors: Table,
    distances: Table,
    effort: Table,
    first_passage: Table,
    diagnostics: Table,
    notes: Table,
    verdicts: Table,
    densities: Densities,
}

impl Tables {
    fn create(folder: &Path) -> Result<Self, Failure> {
        let table = |name| Table::create(folder, name);
        Ok(Self {
            moments: table("moments.csv")?,
            errors: table("errors.csv")?,
            distances: table("distances.csv")?,
            effort: table("effort.csv")?,
            first_passage: table("first_passage.csv")?,
            diagnostics: table("diagnostics.csv")?,
            notes: table("notes.csv")?,
            verdicts: table("verdicts.csv")?,
            densities: Densities::create(folder)?,
        })
    }

    /// Writes a scenario, case by case in the roster's order.
    fn write(&mut self, recording: &Recording, roster: &Roster, tolerance: f64) -> Result<(), Failure> {
        let Judgement { notes, verdicts, mut passages } = judgement::of(recording, roster, tolerance);
        self.notes.write(notes)?;
        self.verdicts.write(verdicts)?;
        let scenario = &recording.assignment.name;
        for (method, _) in roster.cases.iter().filter(|(_, failed)| !failed) {
            let Some(case) = recording.case(method) else { continue };
            // Mixtures may have other numbers of components later; what was propagated are those of the first snapshot.
            let trajectories = case.first().map_or(f64::NAN, |first| rows::trajectories(&first.header));
            for density in case {
                self.moments.write([rows::moments(scenario, method, &density.header)])?;
                self.diagnostics.write(rows::diagnostics(scenario, method, &density.header))?;
                self.densities.write(scenario, method, density)?;
            }
            if let Some(passage) = passages.remove(method) {
                self.first_passage.write(rows::passages(scenario, method, &passage))?;
            }
            let is_standing = |c: &RecordedComparison| !roster.has_failed(&unpack(&c.header.reference));
            let of_method = |c: &&RecordedComparison| {
                unpack(&c.header.label) == *method && (c.header.kind == comparison::EFFORT || is_standing(c))
            };
            for recorded in recording.comparisons.values().filter(of_method) {
                match recorded.header.kind {
                    comparison::MOMENTS => self.errors.write(rows::errors(scenario, method, recorded))?,
                    comparison::DISTANCES => self.distances.write(rows::distances(scenario, method, recorded))?,
                    comparison::EFFORT => self.effort.write(rows::effort(scenario, method, recorded, trajectories))?,
                    _ => {}
                }
            }
        }
        Ok(())
    }

    /// Closes all files.
    fn finish(self) -> Result<(), Failure> {
        let Self { moments, errors, distances, effort, first_passage, diagnostics, notes, verdicts, densities } = self;
        for table in [moments, errors, distances, effort, first_passage, diagnostics, notes, verdicts] {
            table.finish()?;
        }
        densities.finish()
    }
}

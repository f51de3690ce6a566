//! The files of a results folder: CSV tables with full precision, and the densities.

use std::fs::File;
use std::path::{Path, PathBuf};

use messages::layout::comparison;
use messages::text::unpack;
use serde::Serialize;

use super::densities::Densities;
use super::{Recording, notes, rows};
use crate::failure::Failure;
use crate::roster::Roster;

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

/// The open files of a results folder.
pub(crate) struct Tables {
    moments: Table,
    errors: Table,
    distances: Table,
    effort: Table,
    first_passage: Table,
    diagnostics: Table,
    notes: Table,
    densities: Densities,
}

impl Tables {
    pub(crate) fn create(folder: &Path) -> Result<Self, Failure> {
        let table = |name| Table::create(folder, name);
        Ok(Self {
            moments: table("moments.csv")?,
            errors: table("errors.csv")?,
            distances: table("distances.csv")?,
            effort: table("effort.csv")?,
            first_passage: table("first_passage.csv")?,
            diagnostics: table("diagnostics.csv")?,
            notes: table("notes.csv")?,
            densities: Densities::create(folder)?,
        })
    }

    /// Writes a scenario, case by case in the roster's order.
    pub(crate) fn write(&mut self, recording: &Recording, roster: &Roster) -> Result<(), Failure> {
        let scenario = &recording.assignment.name;
        for (method, _) in roster.cases.iter().filter(|(_, failed)| !failed) {
            let Some(case) = recording.case(method) else { continue };
            for density in case {
                self.moments.write([rows::moments(scenario, method, &density.header)])?;
                self.diagnostics.write(rows::diagnostics(scenario, method, &density.header))?;
                self.notes.write(notes::of_density(scenario, method, &density.header))?;
                self.densities.write(scenario, method, density)?;
            }
            if let Some(passage) = recording.passages.get(method) {
                self.first_passage.write(rows::passages(scenario, method, passage))?;
                self.notes.write(notes::of_passage(scenario, method, passage))?;
            }
            for recorded in recording.comparisons.values().filter(|c| unpack(&c.header.label) == *method) {
                match recorded.header.kind {
                    comparison::MOMENTS => self.errors.write(rows::errors(scenario, method, recorded))?,
                    comparison::DISTANCES => self.distances.write(rows::distances(scenario, method, recorded))?,
                    comparison::EFFORT => self.effort.write(rows::effort(scenario, method, recorded))?,
                    _ => {}
                }
            }
        }
        Ok(())
    }

    /// Closes all files.
    pub(crate) fn finish(self) -> Result<(), Failure> {
        let Self { moments, errors, distances, effort, first_passage, diagnostics, notes, densities } = self;
        for table in [moments, errors, distances, effort, first_passage, diagnostics, notes] {
            table.finish()?;
        }
        densities.finish()
    }
}

//! The files of a results folder: CSV tables with full precision, and the densities.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use messages::comparison_kind::ComparisonKind;
use messages::text::unpack;
use results::arrays::ArrayWriter;
use results::files;
use results::rows::{DiagnosticRow, DistanceRow, EffortRow, ErrorRow, GivenRow, NoteRow, PassageRow, VerdictRow};
use results::table::Table;
use results::{FolderError, moments};

use super::{Judgement, RecordedComparison, Recording, densities, description, given, judgement, rows};
use crate::files::scenario_file::{self, AnyScenario, ScenarioInSpace};
use crate::services::roster::Roster;
use kit::assignment::{Assignment, Uncertain};
use kit::failure::Failure;
use kit::space::Space;

/// Writes the files of a scenario into `folder`. The folder appears only when it is complete; one that exists already
/// is left unchanged.
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
    write_tables(recording, roster, &draft, tolerance).map_err(|e| Failure::file(&e.path, e.problem))?;
    fs::write(draft.join(files::SCENARIO), scenario_text(&recording.assignment)).map_err(failed)?;
    fs::rename(&draft, folder).map_err(failed)
}

/// The text of the scenario's file. If no file can ask for the scenario's model, the text states the fields of the
/// message.
pub(super) fn scenario_text(assignment: &Assignment) -> String {
    let said = &assignment.description;
    if let Some(plane) = &assignment.plane {
        return scenario_file::to_text(&said.name, &plane.problem, None);
    }
    if let Some(Uncertain { problem, .. }) = &assignment.uncertain {
        return scenario_file::to_text(&said.name, &problem.plane, Some(problem.spread));
    }
    if let Some(problem) = &assignment.in_space {
        let scenario = ScenarioInSpace::of_cloud(said.name.clone(), problem.clone());
        return AnyScenario::InSpace(scenario).to_text().unwrap_or_default();
    }
    let parameters: String = said.parameters.iter().map(|p| format!("{} = {:?}\n", p.name, p.value)).collect();
    let symbols: Vec<&str> = said.variables.iter().map(|variable| variable.symbol.as_str()).collect();
    format!(
        "name = \"{}\"\n\n[model]\nname = \"{}\"\nvariables = {symbols:?}\n\n[parameters]\n{parameters}\n[initial]\nmean = {:?}\n\
         covariance = {:?} # upper triangle, row by row\n\n[times]\nat = {:?}\n\n[disposal]\nvariable = \"{}\"\ncritical = {:?}\n",
        said.name, said.model, said.mean, said.covariance, assignment.times, symbols[said.reentry], said.critical,
    )
}

/// Writes all tables, the densities and the description of a scenario into a folder.
pub(super) fn write_tables(
    recording: &Recording,
    roster: &Roster,
    folder: &Path,
    tolerance: f64,
) -> Result<(), FolderError> {
    let mut tables = Tables::create(folder, &recording.assignment.space)?;
    tables.write(recording, roster, tolerance)?;
    tables.finish()?;
    results::description::write(folder, &description::of(&recording.assignment))
}

/// The open files of a scenario.
struct Tables {
    /// The columns of numbers of the moments.
    columns: Arc<[String]>,
    moments: Table,
    errors: Table,
    distances: Table,
    effort: Table,
    first_passage: Table,
    given_re_entry: Table,
    diagnostics: Table,
    notes: Table,
    verdicts: Table,
    densities: ArrayWriter,
}

impl Tables {
    fn create(folder: &Path, space: &Space) -> Result<Self, FolderError> {
        let columns = rows::moments_columns(space);
        Ok(Self {
            moments: Table::with_head(&folder.join(files::MOMENTS), moments::head(&columns))?,
            errors: Table::create::<ErrorRow>(&folder.join(files::ERRORS))?,
            distances: Table::create::<DistanceRow>(&folder.join(files::DISTANCES))?,
            effort: Table::create::<EffortRow>(&folder.join(files::EFFORT))?,
            first_passage: Table::create::<PassageRow>(&folder.join(files::FIRST_PASSAGE))?,
            given_re_entry: Table::create::<GivenRow>(&folder.join(files::GIVEN_RE_ENTRY))?,
            diagnostics: Table::create::<DiagnosticRow>(&folder.join(files::DIAGNOSTICS))?,
            notes: Table::create::<NoteRow>(&folder.join(files::NOTES))?,
            verdicts: Table::create::<VerdictRow>(&folder.join(files::VERDICTS))?,
            densities: ArrayWriter::create(&folder.join(files::DENSITIES))?,
            columns,
        })
    }

    /// Writes a scenario, case by case in the roster's order.
    fn write(&mut self, recording: &Recording, roster: &Roster, tolerance: f64) -> Result<(), FolderError> {
        let Judgement { notes, verdicts, mut passages } = judgement::of(recording, roster, tolerance);
        self.notes.write(notes)?;
        self.verdicts.write(verdicts)?;
        let (scenario, space) = (&recording.assignment.description.name, &recording.assignment.space);
        for (method, _) in roster.cases.iter().filter(|(_, failed)| !failed) {
            let Some(case) = recording.case(method) else { continue };
            // A mixture may have another number of components later; those of the first snapshot are the ones that
            // were propagated.
            let trajectories = case.first().map_or(0, |first| first.header.trajectories);
            let trajectories = if trajectories > 0 { trajectories as f64 } else { f64::NAN };
            for reading in case {
                self.moments.write([rows::moments(scenario, method, &self.columns, reading)])?;
                self.diagnostics.write(rows::diagnostics(scenario, method, &reading.header))?;
                densities::add(&mut self.densities, scenario, method, reading)?;
            }
            if let Some(passage) = passages.remove(method) {
                self.first_passage.write(rows::passages(scenario, method, &passage))?;
                self.given_re_entry.write(given::rows(scenario, method, &passage))?;
            }
            let is_standing = |c: &RecordedComparison| !roster.has_failed(&unpack(&c.header.reference));
            let of_method = |c: &&RecordedComparison| {
                unpack(&c.header.label) == *method
                    && (c.header.content() == Some(ComparisonKind::Effort) || is_standing(c))
            };
            for recorded in recording.comparisons.values().filter(of_method) {
                match recorded.header.content() {
                    Some(ComparisonKind::Moments) => {
                        self.errors.write(rows::errors(scenario, method, recorded, space))?
                    }
                    Some(ComparisonKind::Distances) => {
                        self.distances.write(rows::distances(scenario, method, recorded, space))?
                    }
                    Some(ComparisonKind::Effort) => {
                        self.effort.write(rows::effort(scenario, method, recorded, trajectories))?
                    }
                    Some(ComparisonKind::End) | None => {}
                }
            }
        }
        Ok(())
    }

    /// Closes all files.
    fn finish(self) -> Result<(), FolderError> {
        let Self { moments, errors, distances, effort, first_passage, given_re_entry, .. } = self;
        for table in [moments, errors, distances, effort, first_passage, given_re_entry] {
            table.finish()?;
        }
        for table in [self.diagnostics, self.notes, self.verdicts] {
            table.finish()?;
        }
        self.densities.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scenario_without_any_result_has_every_table_with_its_head() {
        let folder = tempfile::tempdir().unwrap();
        let part = folder.path().join("part");
        let recording = Recording::new(kit::example::assignment());
        write(&recording, &Roster::default(), &part, 0.01).unwrap();
        for (name, head) in [
            (
                "moments.csv",
                "scenario,method,t_yr,mean_phi_rad,std_phi_rad,mean_e,std_e,cov_phi_e,prob_above_critical_e,",
            ),
            ("errors.csv", "scenario,method,reference,t_yr,quantity,value,reference_value,abs_error,rel_error\n"),
            ("distances.csv", "scenario,method,reference,t_yr,density,measure,value\n"),
            ("effort.csv", "scenario,method,t_prop_s,t_int_s,t_cal_s,ratio_to_baseline,trajectories\n"),
            ("first_passage.csv", "scenario,method,t_yr,prob_reached_critical_e,low,high,interval\n"),
            ("given_re_entry.csv", "scenario,method,t_yr,given,mean_C,std_C,error_mean_C,error_std_C,errors\n"),
            ("diagnostics.csv", "scenario,method,t_yr,diagnostic,value\n"),
            ("notes.csv", "scenario,method,t_yr,note\n"),
        ] {
            let text = fs::read_to_string(part.join(name)).unwrap();
            assert!(text.starts_with(head) && text.matches('\n').count() == 1, "{name}: {text}");
        }
    }
}

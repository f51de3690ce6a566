//! Judges the results of a scenario before they are written: notes, verdicts, and usable first-passage curves.

use std::collections::BTreeMap;

use results::rows::{NoteRow, VerdictRow};

use super::agreement::{CaseResults, Contradiction, contradictions};
use super::notes::{of_density, of_passage};
use super::{RecordedPassage, Recording, curves, fallbacks, verdicts};
use crate::services::passage_rules::{breach, doubts, without_rounding};
use crate::services::roster::Roster;

/// The result of judging a scenario.
pub(super) struct Judgement {
    /// The rows of `notes.csv`: fallbacks first, then errors, warnings and remarks.
    pub(super) notes: Vec<NoteRow>,
    /// The rows of `verdicts.csv`.
    pub(super) verdicts: Vec<VerdictRow>,
    /// The first-passage curves that break no rule, by label.
    pub(super) passages: BTreeMap<String, RecordedPassage>,
}

/// Judges the cases of a scenario that have not failed, and notes which have.
pub(super) fn of(recording: &Recording, roster: &Roster, tolerance: f64) -> Judgement {
    let assignment = &recording.assignment;
    let scenario = &assignment.description.name;
    let note = |method: &str, t_yr: f64, note: String| NoteRow {
        scenario: scenario.clone(),
        method: method.into(),
        t_yr,
        note,
    };
    let mut notes = Vec::new();
    for (label, _) in roster.cases.iter().filter(|(_, failed)| *failed) {
        notes.extend(roster.reason(label).map(|why| note(label, f64::NAN, format!("lost: {why}"))));
    }
    let (mut cases, mut passages) = (Vec::new(), BTreeMap::new());
    for (label, _) in roster.cases.iter().filter(|(_, failed)| !failed) {
        let Some(snapshots) = recording.case(label) else { continue };
        for snapshot in &snapshots {
            let said = of_density(snapshot);
            notes.extend(said.into_iter().map(|text| note(label, snapshot.header.time, text)));
        }
        let mut said = CaseResults { label, snapshots, passage: Vec::new(), counted: 0 };
        if let Some(mut passage) = recording.passage(label) {
            if let Some(what) = breach(&passage.values) {
                let text = format!("error: its first-passage curve is not used, it cannot be right: {what}");
                notes.push(note(label, f64::NAN, text));
            } else {
                passage.values = without_rounding(&passage.values);
                let doubts = doubts(&passage.values, passage.header.samples, assignment, &said.snapshots);
                notes.extend(doubts.into_iter().map(|doubt| note(label, f64::NAN, format!("warning: {doubt}"))));
                notes.extend(of_passage(&passage).map(|text| note(label, f64::NAN, text)));
                (said.passage, said.counted) = (passage.values.clone(), passage.header.samples);
                passages.insert(label.clone(), passage);
            }
        }
        cases.push(said);
    }
    notes.extend(fallbacks::of(recording, roster, &passages));
    notes.extend(
        curves::off_the_reference(&cases, roster)
            .into_iter()
            .map(|Contradiction { label, time, what }| note(&label, time, format!("warning: {what}"))),
    );
    let contradictions = contradictions(&cases, assignment.description.critical, assignment.description.scenarios);
    notes.extend(
        contradictions
            .into_iter()
            .map(|Contradiction { label, time, what }| note(&label, time, format!("error: {what}"))),
    );
    notes.sort_by_key(NoteRow::severity);
    Judgement { notes, verdicts: verdicts::of(recording, roster, tolerance), passages }
}

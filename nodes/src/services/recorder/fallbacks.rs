//! Notes on where cases are compared with another case than the first reference, and why.

use std::collections::BTreeMap;

use results::notes::{Severity, listed};
use results::rows::NoteRow;

use super::notes::{with_estimate, withheld_passages};
use super::{RecordedPassage, Recording};
use crate::services::passage_rules::rows;
use crate::services::roster::Roster;
use crate::services::yardstick::{Figure, stand_for};

/// The notes for every reference that has failed, for every snapshot at which the first reference withholds a figure,
/// and for its first-passage curve. `passages` are the curves that can be used.
pub(super) fn of(recording: &Recording, roster: &Roster, passages: &BTreeMap<String, RecordedPassage>) -> Vec<NoteRow> {
    let mut notes = Vec::new();
    let mut note = |method: &str, t_yr: f64, text: String| {
        let (scenario, method) = (recording.assignment.description.name.clone(), method.to_owned());
        notes.push(NoteRow { scenario, method, t_yr, note: format!("{}{text}", Severity::Fallback.prefix()) });
    };
    let is_there = |label: &str| !roster.has_failed(label) && recording.case(label).is_some();
    let there: Vec<&str> = roster.references.iter().map(String::as_str).filter(|label| is_there(label)).collect();
    for (place, label) in roster.references.iter().enumerate().filter(|(_, label)| !is_there(label)) {
        // A reference that has failed is not missed if one before it in the list is there.
        if there.first().is_none_or(|first| roster.references.iter().position(|other| other == first) > Some(place)) {
            note(
                label,
                f64::NAN,
                format!(
                    "the reference {label} is missing: {}; {}",
                    roster.reason(label).unwrap_or("it has failed"),
                    in_its_place(there.first().copied())
                ),
            );
        }
    }
    let Some((&first, _)) = there.split_first() else { return notes };
    for (index, &time) in recording.assignment.times.iter().enumerate() {
        let readings: Vec<_> = there
            .iter()
            .filter_map(|&label| Some((label, recording.densities.get(&(label.to_owned(), index as u32))?)))
            .collect();
        let Some((_, of_first)) = readings.first() else { continue };
        let mut groups: Vec<(Option<&str>, Vec<String>)> = Vec::new();
        for figure in Figure::all(&of_first.space).filter(|figure| !figure.is_stated(of_first)) {
            let instead = stand_for(readings.iter().copied(), figure);
            let words = with_estimate(figure, of_first);
            match groups.iter_mut().find(|(other, _)| *other == instead) {
                Some((_, withheld)) => withheld.push(words),
                None => groups.push((instead, vec![words])),
            }
        }
        for (instead, withheld) in groups {
            let (withheld, instead) = (listed(&withheld), in_its_place(instead));
            note(
                first,
                time,
                format!("the reference {first} withholds {withheld}: that is above what it stands behind; {instead}"),
            );
        }
    }
    let curve = |label: &str| passages.get(label).map(|passage| &passage.values[..]);
    if let Some(withheld) = curve(first).and_then(withheld_passages) {
        let states_all =
            |label: &&&str| curve(label).is_some_and(|values| rows(values).iter().all(|row| !row.is_withheld()));
        let instead = in_its_place(there[1..].iter().find(states_all).copied());
        note(first, f64::NAN, format!("the reference {first} withholds {withheld}; {instead}"));
    }
    notes
}

fn in_its_place(instead: Option<&str>) -> String {
    match instead {
        Some(label) => format!("{label} is the reference there"),
        None => "there is no other reference that has it, so nothing is compared there".into(),
    }
}

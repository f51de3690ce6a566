//! Errors, warnings and remarks about results, the gravest first, after the references that others replace.

use std::collections::BTreeMap;

use results::notes::{NoteGroup, Severity, groups};
use results::rows::NoteRow;

/// Prints one line for each reference in whose place another one is used.
pub fn print_fallbacks(scenario: &str, notes: &[NoteRow]) {
    let of_scenario = notes.iter().filter(|note| note.scenario == scenario && note.severity() == Severity::Fallback);
    for (place, group) in groups(of_scenario).iter().enumerate() {
        let text = format!("{scenario}: {}{}{}", group.when(), group.first.text(), more(group));
        say!("{}{text}", if place == 0 { "\n" } else { "" });
    }
}

/// Prints one line for each method, scenario and kind of note: the first, and how many more there are.
pub fn print(notes: &[NoteRow]) {
    let lines = lines(notes);
    if !lines.is_empty() {
        say!("\nNotes");
    }
    for line in lines {
        say!("- {line}");
    }
}

fn lines(notes: &[NoteRow]) -> Vec<String> {
    let mut sorted: Vec<&NoteRow> = notes.iter().filter(|note| note.severity() != Severity::Fallback).collect();
    sorted.sort_by_key(|note| note.severity());
    let line = |group: &NoteGroup<'_>| {
        let NoteRow { scenario, method, t_yr, note } = group.first;
        let when = if t_yr.is_nan() { String::new() } else { format!(", t = {t_yr} yr") };
        format!("{scenario}, {method}{when}: {note}{}", more(group))
    };
    groups(sorted).iter().map(line).collect()
}

/// The notes that are errors, in words.
pub fn errors(notes: &[NoteRow]) -> Vec<String> {
    let errors = notes.iter().filter(|note| note.severity() == Severity::Error);
    let in_words = |group: &NoteGroup<'_>| {
        let NoteRow { scenario, method, .. } = group.first;
        format!("{scenario}, {method}: {}{}{}", group.when(), group.first.text(), more(group))
    };
    groups(errors).iter().map(in_words).collect()
}

/// The first error of each case, in words, by the label of the case.
pub fn errors_by_case(notes: &[NoteRow]) -> BTreeMap<String, String> {
    let errors = notes.iter().rev().filter(|note| note.severity() == Severity::Error);
    errors.map(|note| (note.method.clone(), note.text().to_owned())).collect()
}

/// How many more notes a group has than the one that is shown.
fn more(group: &NoteGroup<'_>) -> String {
    match group.times.len() - 1 {
        0 => String::new(),
        more => format!(" (and {more} more times, see notes.csv)"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn note(method: &str, t_yr: f64, note: &str) -> NoteRow {
        NoteRow { scenario: "s".into(), method: method.into(), t_yr, note: note.into() }
    }

    #[test]
    fn nothing_hides_behind_more_times_that_is_graver_or_of_another_kind() {
        let notes = [
            note("exact", 1.0, "warning: reached 1.0e-3 in L1"),
            note("exact", 2.0, "warning: reached 5.2e2 in L1"),
            note("exact", 3.0, "warning: something else"),
            note("exact", 3.0, "error: exact and mc disagree"),
            note("mc", f64::NAN, "no curve"),
            note("exact", 4.0, "fallback: mc is the reference there"),
        ];
        assert_eq!(
            lines(&notes),
            [
                "s, exact, t = 3 yr: error: exact and mc disagree",
                "s, exact, t = 1 yr: warning: reached 1.0e-3 in L1 (and 1 more times, see notes.csv)",
                "s, exact, t = 3 yr: warning: something else",
                "s, mc: no curve",
            ]
        );
        assert_eq!(errors(&notes), ["s, exact: at t = 3 yr exact and mc disagree"]);
    }
}

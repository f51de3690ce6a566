//! Errors, warnings and remarks about results, the gravest first, after the references that others replace.

use std::collections::BTreeMap;

use nodes::services::recorder::notes::{SEVERITIES, severity};
use serde::Deserialize;

/// A row of `notes.csv`.
#[derive(Debug, Clone, Deserialize)]
pub struct Note {
    scenario: String,
    method: String,
    t_yr: f64,
    note: String,
}

/// Notes about one method in one scenario that differ only in their numbers.
struct Group<'a> {
    first: &'a Note,
    times: Vec<f64>,
}

const FALLBACK: usize = 0;
const ERROR: usize = 2;

/// Prints one line for each reference in whose place another one is used.
pub fn print_fallbacks(scenario: &str, notes: &[Note]) {
    let of_scenario = notes.iter().filter(|note| note.scenario == scenario && severity(&note.note) == FALLBACK);
    for (place, group) in groups(of_scenario).iter().enumerate() {
        let text = group.first.note.trim_start_matches(SEVERITIES[FALLBACK]);
        let text = format!("{scenario}: {}{text}{}", group.when(), group.more());
        say!("{}{text}", if place == 0 { "\n" } else { "" });
    }
}

/// Prints one line for each method, scenario and kind of note: the first, and how many more there are.
pub fn print(notes: &[Note]) {
    let lines = lines(notes);
    if !lines.is_empty() {
        say!("\nNotes");
    }
    for line in lines {
        say!("- {line}");
    }
}

fn lines(notes: &[Note]) -> Vec<String> {
    let mut sorted: Vec<&Note> = notes.iter().filter(|note| severity(&note.note) != FALLBACK).collect();
    sorted.sort_by_key(|note| severity(&note.note));
    let line = |group: &Group<'_>| {
        let Note { scenario, method, t_yr, note } = group.first;
        let when = if t_yr.is_nan() { String::new() } else { format!(", t = {t_yr} yr") };
        format!("{scenario}, {method}{when}: {note}{}", group.more())
    };
    groups(sorted.into_iter()).iter().map(line).collect()
}

/// The notes that are errors, in words.
pub fn errors(notes: &[Note]) -> Vec<String> {
    let errors = notes.iter().filter(|note| severity(&note.note) == ERROR);
    let in_words = |group: &Group<'_>| {
        let Note { scenario, method, note, .. } = group.first;
        let text = note.trim_start_matches(SEVERITIES[ERROR]);
        format!("{scenario}, {method}: {}{text}{}", group.when(), group.more())
    };
    groups(errors).iter().map(in_words).collect()
}

/// The first error of each case, in words, by the label of the case.
pub fn errors_by_case(notes: &[Note]) -> BTreeMap<String, String> {
    let errors = notes.iter().rev().filter(|note| severity(&note.note) == ERROR);
    errors.map(|note| (note.method.clone(), note.note.trim_start_matches(SEVERITIES[ERROR]).to_owned())).collect()
}

/// Groups the notes that differ only in their numbers, in the order of the first note of each group.
fn groups<'a>(notes: impl Iterator<Item = &'a Note>) -> Vec<Group<'a>> {
    let kind = |note: &Note| {
        let words: String = note.note.chars().filter(|c| !c.is_ascii_digit() && !"+-.e".contains(*c)).collect();
        (note.scenario.clone(), note.method.clone(), words)
    };
    let mut groups: Vec<Group<'a>> = Vec::new();
    for note in notes {
        match groups.iter_mut().find(|group| kind(group.first) == kind(note)) {
            Some(group) => group.times.push(note.t_yr),
            None => groups.push(Group { first: note, times: vec![note.t_yr] }),
        }
    }
    groups
}

impl Group<'_> {
    /// The times that it is about.
    fn when(&self) -> String {
        let times: Vec<String> = self.times.iter().filter(|t| !t.is_nan()).map(f64::to_string).collect();
        match &times[..] {
            [] => String::new(),
            [one] => format!("at t = {one} yr "),
            [first @ .., last] => format!("at t = {} and {last} yr ", first.join(", ")),
        }
    }

    fn more(&self) -> String {
        match self.times.len() - 1 {
            0 => String::new(),
            more => format!(" (and {more} more times, see notes.csv)"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn note(method: &str, t_yr: f64, note: &str) -> Note {
        Note { scenario: "s".into(), method: method.into(), t_yr, note: note.into() }
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

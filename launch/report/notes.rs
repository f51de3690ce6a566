//! Warnings and remarks of the methods about their own results.

use serde::Deserialize;

/// A row of `notes.csv`.
#[derive(Debug, Deserialize)]
pub struct Note {
    scenario: String,
    method: String,
    t_yr: f64,
    note: String,
}

/// Prints one line for each method and scenario with something to say: its first note, and how many more there are.
pub fn print(notes: &[Note]) {
    let mut groups: Vec<Vec<&Note>> = Vec::new();
    for note in notes {
        let subject = |other: &Note| (other.scenario.clone(), other.method.clone(), other.t_yr.is_nan());
        match groups.last_mut() {
            Some(group) if subject(group[0]) == subject(note) => group.push(note),
            _ => groups.push(vec![note]),
        }
    }
    if !groups.is_empty() {
        say!("\nNotes");
    }
    for group in groups {
        let Note { scenario, method, t_yr, note } = group[0];
        let when = if t_yr.is_nan() { String::new() } else { format!(", t = {t_yr} yr") };
        let more = match group.len() - 1 {
            0 => String::new(),
            more => format!(" (and {more} more times, see notes.csv)"),
        };
        say!("- {scenario}, {method}{when}: {note}{more}");
    }
}

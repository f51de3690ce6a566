//! The notes of `notes.csv`: how severe each is, and which of them differ only in their numbers.

use crate::rows::NoteRow;

/// How severe a note is. The most severe comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// A reference withholds something or is missing, and another case takes its place.
    Fallback,
    /// A case has no results in the scenario.
    Lost,
    /// Two statements contradict one another, or a result cannot be right.
    Error,
    /// A result, or a part of it, is not to be trusted.
    Warning,
    /// Anything else.
    Remark,
}

impl Severity {
    const ALL: [Self; 5] = [Self::Fallback, Self::Lost, Self::Error, Self::Warning, Self::Remark];

    /// The words with which such a note begins; none for a remark.
    pub fn prefix(self) -> &'static str {
        match self {
            Self::Fallback => "fallback: ",
            Self::Lost => "lost: ",
            Self::Error => "error: ",
            Self::Warning => "warning: ",
            Self::Remark => "",
        }
    }

    /// The severity of a note with this text.
    pub fn of(note: &str) -> Self {
        Self::ALL.into_iter().find(|severity| note.starts_with(severity.prefix())).unwrap_or(Self::Remark)
    }
}

impl NoteRow {
    /// How severe the note is.
    pub fn severity(&self) -> Severity {
        Severity::of(&self.note)
    }

    /// The note without the words that state its severity.
    pub fn text(&self) -> &str {
        self.note.strip_prefix(self.severity().prefix()).unwrap_or(&self.note)
    }
}

/// Notes about one case in one scenario that differ only in their numbers.
#[derive(Debug, Clone)]
pub struct NoteGroup<'a> {
    /// The first of them.
    pub first: &'a NoteRow,
    /// The times of all of them \[yr\]; `NaN` for a note about the whole scenario.
    pub times: Vec<f64>,
}

impl NoteGroup<'_> {
    /// The times that the notes are about, in words: `0.5, 1 and 2`; empty for notes about the whole scenario.
    pub fn times_in_words(&self) -> String {
        let times: Vec<String> = self.times.iter().filter(|t| !t.is_nan()).map(f64::to_string).collect();
        listed(&times)
    }

    /// The beginning of a sentence: `at t = 0.5, 1 and 2 yr `; empty for notes about the whole scenario.
    pub fn when(&self) -> String {
        match self.times_in_words() {
            times if times.is_empty() => times,
            times => format!("at t = {times} yr "),
        }
    }
}

/// Groups the notes that differ only in their numbers, in the order of the first note of each group.
pub fn groups<'a>(notes: impl IntoIterator<Item = &'a NoteRow>) -> Vec<NoteGroup<'a>> {
    let kind = |note: &NoteRow| {
        let words: String = note.note.chars().filter(|c| !c.is_ascii_digit() && !"+-.e".contains(*c)).collect();
        (note.scenario.clone(), note.method.clone(), words)
    };
    let mut groups: Vec<NoteGroup<'a>> = Vec::new();
    for note in notes {
        match groups.iter_mut().find(|group| kind(group.first) == kind(note)) {
            Some(group) => group.times.push(note.t_yr),
            None => groups.push(NoteGroup { first: note, times: vec![note.t_yr] }),
        }
    }
    groups
}

/// `a, b and c`.
pub fn listed(words: &[impl AsRef<str>]) -> String {
    match words {
        [] => String::new(),
        [one] => one.as_ref().to_owned(),
        [first @ .., last] => {
            let first: Vec<&str> = first.iter().map(AsRef::as_ref).collect();
            format!("{} and {}", first.join(", "), last.as_ref())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_come_before_warnings_and_warnings_before_remarks() {
        let mut sorted = ["no curve", "warning: coarse", "lost: too slow", "error: wrong", "fallback: mc"];
        sorted.sort_by_key(|note| Severity::of(note));
        assert_eq!(sorted, ["fallback: mc", "lost: too slow", "error: wrong", "warning: coarse", "no curve"]);
    }

    #[test]
    fn a_group_says_at_which_times_its_notes_are() {
        let note = |t_yr, note: &str| NoteRow { t_yr, note: note.into(), ..NoteRow::default() };
        let notes = [note(0.5, "warning: off by 1.0e-3"), note(f64::NAN, "no curve"), note(2.0, "warning: off by 5")];
        let groups = groups(&notes);
        assert_eq!(groups.iter().map(NoteGroup::when).collect::<Vec<_>>(), ["at t = 0.5 and 2 yr ", ""]);
        assert_eq!((groups[0].first.severity(), groups[0].first.text()), (Severity::Warning, "off by 1.0e-3"));
    }
}

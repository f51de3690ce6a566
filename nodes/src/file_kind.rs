//! Finds out whether a TOML file is a launch file, a scenario file or a sweep file.
//!
//! Users confuse these files. It then helps more to say what to do with the file than to list the keys that are
//! missing.

use toml::Spanned;
use toml::de::DeTable;

use crate::input::{InputError, InputFile};

/// A kind of file that phasecloud reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// Cases and the scenarios they are run on.
    Launch,
    /// One problem.
    Scenario,
    /// A scenario of which some values are varied.
    Sweep,
}

impl FileKind {
    const ALL: [Self; 3] = [Self::Launch, Self::Scenario, Self::Sweep];

    /// Keys at the top of the file that no other kind has.
    fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Launch => &[
                "propagator",
                "scenarios",
                "reference",
                "tolerance",
                "bins",
                "patience",
                "restart",
                "hosts",
                "accuracy",
            ],
            Self::Scenario => &["orbit", "initial", "times", "disposal"],
            Self::Sweep => &["vary", "scenario"],
        }
    }

    /// The kind as words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Launch => "a launch file",
            Self::Scenario => "a scenario file",
            Self::Sweep => "a sweep file",
        }
    }

    /// The kind to which most of the file's keys belong; `None` if no key belongs to a kind, or two kinds have
    /// equally many.
    pub fn of(file: &InputFile) -> Option<Self> {
        Self::told_by(file.table().ok()?.get_ref()).map(|(kind, _)| kind)
    }

    /// The kind, and the first key that belongs to it.
    fn told_by<'t, 'd>(table: &'t DeTable<'d>) -> Option<(Self, &'t Spanned<std::borrow::Cow<'d, str>>)> {
        let of_kind = |kind: Self| table.keys().filter(move |key| kind.keys().contains(&key.get_ref().as_ref()));
        let most = Self::ALL.into_iter().map(|kind| of_kind(kind).count()).max()?;
        let mut likely = Self::ALL.into_iter().filter(|kind| of_kind(*kind).count() == most);
        let (Some(kind), None) = (likely.next(), likely.next()) else { return None };
        of_kind(kind).min_by_key(|key| key.span().start).map(|key| (kind, key))
    }

    /// Checks that the file is of this kind.
    ///
    /// # Errors
    /// If the file is of another kind: which, and what to do with it.
    pub fn expect(self, file: &InputFile) -> Result<(), InputError> {
        let Ok(table) = file.table() else { return Ok(()) }; // the TOML reader reports the error
        match Self::told_by(table.get_ref()) {
            Some((kind, key)) if kind != self => Err(file.error(key, &self.instead_of(kind, file))),
            _ => Ok(()),
        }
    }

    /// What to do with a file of kind `found` that stands where one of this kind belongs.
    fn instead_of(self, found: Self, file: &InputFile) -> String {
        let path = file.path().display();
        let advice = match (found, self) {
            (Self::Scenario, Self::Launch) => format!(
                "`phasecloud run --scenario {path}` runs the default cases on it, with a launch file before --scenario those of the \
                 file; `phasecloud submit` gives it to a running service"
            ),
            (Self::Scenario, _) => {
                "a sweep file names it as scenario = \"...\" and says under [vary] which of its values are varied"
                    .to_string()
            }
            (Self::Launch, Self::Scenario) => format!("`phasecloud run {path}` runs it on the scenarios that it names"),
            (Self::Launch, _) => format!("`phasecloud serve {path} --sweep SWEEP_FILE` runs its cases on a sweep"),
            (Self::Sweep, _) => format!("`phasecloud serve LAUNCH_FILE --sweep {path}` works on it"),
        };
        format!("this is {}, but {} belongs here; {advice}", found.words(), self.words())
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    const LAUNCH: &str = "name = \"l\"\nscenarios = [\"s.toml\"]\nreference = \"mc\"\n[[propagator]]\nlabel = \"mc\"\n";
    const SCENARIO: &str = "name = \"s\"\n[orbit]\nradiation = 1\n[initial]\ne = 0.1\n";
    const SWEEP: &str = "scenario = \"s.toml\"\n[vary]\n\"initial.e\" = [0.1]\n";

    fn file(text: &str) -> InputFile {
        InputFile::from_text(Path::new("x.toml"), text)
    }

    #[test]
    fn a_file_is_what_most_of_its_keys_say() {
        for (text, kind) in [
            (LAUNCH, Some(FileKind::Launch)),
            (SCENARIO, Some(FileKind::Scenario)),
            (SWEEP, Some(FileKind::Sweep)),
            ("name = \"x\"\n", None),
            ("scenario = \"s.toml\"\n[orbit]\n", None),
            ("not toml", None),
        ] {
            assert_eq!(FileKind::of(&file(text)), kind, "{text}");
        }
    }

    #[test]
    fn every_other_kind_is_recognised_with_what_to_do() {
        for (expected, text, words) in [
            (
                FileKind::Launch,
                SCENARIO,
                "x.toml:2: orbit: this is a scenario file, but a launch file belongs here; `phasecloud run --scenario x.toml`",
            ),
            (
                FileKind::Launch,
                SWEEP,
                "x.toml:1: scenario: this is a sweep file, but a launch file belongs here; `phasecloud serve LAUNCH_FILE --sweep x.toml`",
            ),
            (
                FileKind::Scenario,
                LAUNCH,
                "x.toml:2: scenarios: this is a launch file, but a scenario file belongs here; `phasecloud run x.toml`",
            ),
            (FileKind::Scenario, SWEEP, "`phasecloud serve LAUNCH_FILE --sweep x.toml`"),
            (FileKind::Sweep, LAUNCH, "`phasecloud serve x.toml --sweep SWEEP_FILE`"),
            (FileKind::Sweep, SCENARIO, "names it as scenario"),
        ] {
            let error = expected.expect(&file(text)).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
        assert!(FileKind::Launch.expect(&file(LAUNCH)).is_ok() && FileKind::Launch.expect(&file("x = [")).is_ok());
    }
}

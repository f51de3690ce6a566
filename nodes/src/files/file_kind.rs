//! Which kind of file a TOML file is: launch file, scenario file, sweep file or map file. Users take one for another;
//! then what to do with it is more help than a list of keys that are missing.

use std::path::Path;

use toml::Spanned;
use toml::de::DeTable;

/// The table that only a map file has.
const QUANTITY: &str = "quantity";

/// A kind of file that phasecloud reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// Cases and the scenarios they are run on.
    Launch,
    /// One problem.
    Scenario,
    /// A scenario with values varied.
    Sweep,
    /// A quantity of a scenario with values varied.
    Map,
}

impl FileKind {
    const ALL: [Self; 4] = [Self::Launch, Self::Scenario, Self::Sweep, Self::Map];

    /// Keys at the top of the file that no other kind has.
    fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Launch => &[
                "propagator",
                "baseline",
                "scenarios",
                "reference",
                "tolerance",
                "bins",
                "patience",
                "restart",
                "hosts",
                "accuracy",
            ],
            Self::Scenario => &["model", "epoch", "orbit", "initial", "times", "disposal"],
            Self::Sweep => &["vary", "scenario"],
            Self::Map => &[QUANTITY, "vary", "scenario", "hosts"],
        }
    }

    /// The kind as words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Launch => "a launch file",
            Self::Scenario => "a scenario file",
            Self::Sweep => "a sweep file",
            Self::Map => "a map file",
        }
    }

    /// The kind of file that a table is by most of its keys, and the first key that tells; `None` if it has none that
    /// tells, or as many of another kind.
    pub(crate) fn told_by<'t, 'd>(table: &'t DeTable<'d>) -> Option<(Self, &'t Spanned<std::borrow::Cow<'d, str>>)> {
        // A map file has the keys of a sweep file, and its quantity.
        let is_possible = |kind: Self| kind != Self::Map || table.keys().any(|key| key.get_ref().as_ref() == QUANTITY);
        let of_kind = |kind: Self| {
            table.keys().filter(move |key| is_possible(kind) && kind.keys().contains(&key.get_ref().as_ref()))
        };
        let most = Self::ALL.into_iter().map(|kind| of_kind(kind).count()).max()?;
        let mut likely = Self::ALL.into_iter().filter(|kind| of_kind(*kind).count() == most);
        let (Some(kind), None) = (likely.next(), likely.next()) else { return None };
        of_kind(kind).min_by_key(|key| key.span().start).map(|key| (kind, key))
    }

    /// What to do with a file of kind `found` that stands where one of this kind belongs.
    pub(crate) fn instead_of(self, found: Self, path: &Path) -> String {
        let path = path.display();
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
            (Self::Sweep, Self::Map) => {
                "a map file has a table [quantity] besides, which says what is shown".to_string()
            }
            (Self::Sweep, _) => format!("`phasecloud serve LAUNCH_FILE --sweep {path}` works on it"),
            (Self::Map, _) => format!("`phasecloud map {path}` draws it"),
        };
        format!("this is {}, but {} belongs here; {advice}", found.words(), self.words())
    }
}

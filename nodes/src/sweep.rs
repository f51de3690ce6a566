//! Sweep files: one scenario, with some of its values varied, in every combination.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::{Spanned, Table, Value};

use crate::file_kind::FileKind;
use crate::input::{InputError, InputFile, LONGEST_PLAIN_NAME};
use crate::scenario_file::{self, ScenarioFile};

/// Most scenarios of a sweep.
const MOST_SCENARIOS: usize = 1_000_000;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    scenario: Spanned<PathBuf>,
    vary: Spanned<BTreeMap<Spanned<String>, Spanned<Values>>>,
}

/// The values that a key takes.
#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "a list of numbers, or { from, to, count }")]
enum Values {
    List(Vec<f64>),
    Range { from: f64, to: f64, count: usize },
}

impl Values {
    fn count(&self) -> usize {
        match self {
            Self::List(values) => values.len(),
            Self::Range { count, .. } => *count,
        }
    }

    fn value(&self, index: usize) -> Option<f64> {
        match self {
            Self::List(values) => values.get(index).copied(),
            Self::Range { from, count: 1, .. } => Some(*from),
            Self::Range { from, to, count } => Some(from + (to - from) * index as f64 / (count - 1) as f64),
        }
    }
}

/// A sweep: its scenarios are made one at a time.
#[derive(Debug)]
pub struct Sweep {
    base: Table,
    name: String,
    axes: Vec<(String, Values)>,
    count: usize,
}

impl Sweep {
    /// Reads a sweep file, and checks the scenario that it varies and the first combination.
    ///
    /// # Errors
    /// [`InputError`] with file, line and key.
    pub fn load(path: &Path) -> Result<Self, InputError> {
        Self::check(&InputFile::read(path)?)
    }

    /// Checks a sweep file that has been read, the scenario that it varies and the first combination.
    ///
    /// # Errors
    /// [`InputError`] with file, line and key.
    pub fn check(file: &InputFile) -> Result<Self, InputError> {
        FileKind::Sweep.expect(file)?;
        let raw: Raw = file.parse()?;
        let folder = file.path().parent().unwrap_or(Path::new("."));
        let in_base = |error: &dyn std::fmt::Display| file.error(&raw.scenario, &error.to_string());
        let base_file = InputFile::read(&folder.join(raw.scenario.get_ref())).map_err(|e| in_base(&e))?;
        let base = scenario_file::check(&base_file).map_err(|e| in_base(&e))?;
        let mut count = 1usize;
        for values in raw.vary.get_ref().values() {
            count = count.saturating_mul(values.get_ref().count());
        }
        if count == 0 || count > MOST_SCENARIOS {
            let problem = format!("has {count} combinations; there must be 1 to {MOST_SCENARIOS}");
            return Err(file.error(&raw.vary, &problem));
        }
        let table: Table = base_file.parse()?;
        for key in raw.vary.get_ref().keys() {
            if !is_number(&table, key.get_ref()) {
                let problem = format!("\"{}\" is not a number of the scenario; write it as TABLE.KEY", key.get_ref());
                return Err(file.error(key, &problem));
            }
        }
        let raw_vary = Spanned::new(raw.vary.span(), ());
        let axes = raw.vary.into_inner().into_iter().map(|(k, v)| (k.into_inner(), v.into_inner())).collect();
        let sweep = Self { base: table, name: base.name, axes, count };
        sweep.scenario(0).map_err(|e| file.error(&raw_vary, &e.to_string()))?;
        Ok(sweep)
    }

    /// Number of scenarios.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none, which [`Sweep::load`] refuses.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The most snapshots of any of its scenarios.
    pub fn most_snapshots(&self) -> usize {
        let looked_at = if self.keys().any(|key| key.starts_with("times.")) { self.count } else { 1 };
        let snapshots = |index| self.scenario(index).ok().map(|scenario| scenario.problem.times.len());
        (0..looked_at).filter_map(snapshots).max().unwrap_or(1)
    }

    /// The keys that are varied, as `TABLE.KEY`.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        self.axes.iter().map(|(key, _)| key.as_str())
    }

    /// The value of each key in combination `index`, the last key varying fastest.
    pub fn values(&self, index: usize) -> Vec<f64> {
        let mut rest = index;
        let value = |(_, axis): &(String, Values)| {
            let count = axis.count().max(1);
            let value = axis.value(rest % count).unwrap_or(f64::NAN);
            rest /= count;
            value
        };
        let mut values: Vec<f64> = self.axes.iter().rev().map(value).collect();
        values.reverse();
        values
    }

    /// Keys and values of combination `index` in words.
    pub fn combination(&self, index: usize) -> String {
        let values = self.values(index);
        self.keys().zip(values).map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>().join(", ")
    }

    /// The name of scenario `index`: `NAME-INDEX`, all of the same length; `NAME` is cut where it is too long for that.
    pub fn name(&self, index: usize) -> String {
        let digits = self.count.saturating_sub(1).to_string().len();
        let stem: String = self.name.chars().take(LONGEST_PLAIN_NAME - digits - 1).collect();
        format!("{stem}-{index:0digits$}")
    }

    /// Which scenario is called `name`.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        let index = name.rsplit_once('-')?.1.parse().ok()?;
        (index < self.count && self.name(index) == name).then_some(index)
    }

    /// Scenario `index`.
    ///
    /// # Errors
    /// If its values are not allowed.
    pub fn scenario(&self, index: usize) -> Result<ScenarioFile, InputError> {
        let mut table = self.base.clone();
        for (key, value) in self.keys().zip(self.values(index)) {
            set(&mut table, key, value);
        }
        let name = self.name(index);
        table.insert("name".into(), Value::String(name.clone()));
        let shown = PathBuf::from(format!("{name} ({})", self.combination(index)));
        scenario_file::check(&InputFile::from_text(&shown, &table.to_string()))
    }
}

/// Whether `TABLE.KEY` is a number of a scenario.
fn is_number(scenario: &Table, key: &str) -> bool {
    let value = key.split_once('.').and_then(|(table, key)| scenario.get(table)?.get(key));
    value.is_some_and(|value| value.is_float() || value.is_integer())
}

fn set(scenario: &mut Table, key: &str, value: f64) {
    let Some((table, key)) = key.split_once('.') else { return };
    if let Some(Value::Table(table)) = scenario.get_mut(table) {
        table.insert(key.into(), Value::Float(value));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BASE: &str = "name = \"s\"\n[orbit]\nradiation = 0.15\noblateness = 0.4\n[initial]\nphi = 2.2\ne = 0.145\n\
         delta_phi = 0.39\ndelta_e = 0.05\n[times]\nend = 2.0\nstep = 0.5\n[disposal]\ncritical_e = 0.6\n";

    fn load(text: &str) -> Result<Sweep, InputError> {
        let folder = std::env::temp_dir().join(format!("phasecloud-sweep-{}-{:p}", std::process::id(), text));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("base.toml"), BASE).unwrap();
        let path = folder.join("sweep.toml");
        std::fs::write(&path, text).unwrap();
        let sweep = Sweep::load(&path);
        std::fs::remove_dir_all(&folder).unwrap();
        sweep
    }

    #[test]
    fn every_combination_comes_once_and_the_last_key_varies_fastest() {
        let sweep = load(
            "scenario = \"base.toml\"\n[vary]\n\"initial.e\" = [0.1, 0.2]\n\
             \"orbit.radiation\" = { from = 0.1, to = 0.3, count = 3 }\n",
        )
        .unwrap();
        assert_eq!(sweep.len(), 6);
        let found: Vec<_> = (0..6)
            .map(|index| {
                let ScenarioFile { name, problem } = sweep.scenario(index).unwrap();
                assert_eq!(name, format!("s-{index}"));
                assert_eq!(sweep.index_of(&name), Some(index));
                assert_eq!(sweep.values(index)[0], problem.initial.mean_e);
                (problem.initial.mean_e, (problem.force.radiation * 1e9).round() / 1e9)
            })
            .collect();
        assert_eq!(sweep.combination(3), "initial.e = 0.2, orbit.radiation = 0.1");
        assert_eq!((sweep.index_of("s-6"), sweep.index_of("s-03"), sweep.index_of("t-3")), (None, None, None));
        assert_eq!(found, [(0.1, 0.1), (0.1, 0.2), (0.1, 0.3), (0.2, 0.1), (0.2, 0.2), (0.2, 0.3)]);
    }

    #[test]
    fn scenarios_of_a_long_name_have_names_of_their_own_that_are_allowed() {
        let base = BASE.replace("\"s\"", "\"a-name-of-thirty-one-characters\"");
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("base.toml"), base).unwrap();
        let text = "scenario = \"base.toml\"\n[vary]\n\"initial.e\" = { from = 0.1, to = 0.2, count = 11 }\n";
        std::fs::write(folder.path().join("sweep.toml"), text).unwrap();
        let sweep = Sweep::load(&folder.path().join("sweep.toml")).unwrap();
        assert_eq!(sweep.scenario(10).unwrap().name, "a-name-of-thirty-one-charact-10");
        assert_eq!(sweep.index_of("a-name-of-thirty-one-charact-10"), Some(10));
    }

    #[test]
    fn a_mistake_is_told_with_line_and_key() {
        let vary = |text: &str| format!("scenario = \"base.toml\"\n[vary]\n{text}\n");
        for (text, line, words) in [
            (vary("\"initial.eccentricity\" = [0.1]"), 3, "not a number of the scenario"),
            (vary("\"initial.e\" = []"), 2, "0 combinations"),
            (vary("\"initial.e\" = \"x\""), 3, "a list of numbers"),
            (vary("\"initial.e\" = [1.5]"), 2, "between 0 and 1"),
            ("scenario = \"none.toml\"\n[vary]\n".into(), 1, "cannot be read"),
        ] {
            let error = load(&text).unwrap_err();
            assert_eq!(error.line, line, "{error}");
            assert!(error.to_string().contains(words), "{error}");
        }
    }
}

//! Sweep files: one scenario, with some of its values varied, in every combination.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::{Spanned, Table, Value};

use crate::input::{InputError, InputFile};
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
        let file = InputFile::read(path)?;
        let raw: Raw = file.parse()?;
        let folder = path.parent().unwrap_or(Path::new("."));
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

    /// Scenario `index`, the last key varying fastest; called `NAME-INDEX`.
    ///
    /// # Errors
    /// If its values are not allowed.
    pub fn scenario(&self, index: usize) -> Result<ScenarioFile, InputError> {
        let mut table = self.base.clone();
        let mut rest = index;
        let mut values = Vec::new();
        for (key, axis) in self.axes.iter().rev() {
            let count = axis.count().max(1);
            let value = axis.value(rest % count).unwrap_or(f64::NAN);
            rest /= count;
            set(&mut table, key, value);
            values.push(format!("{key} = {value}"));
        }
        let digits = self.count.saturating_sub(1).to_string().len();
        let name = format!("{}-{index:0digits$}", self.name);
        table.insert("name".into(), Value::String(name.clone()));
        values.reverse();
        let shown = PathBuf::from(format!("{name} ({})", values.join(", ")));
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
                (problem.initial.mean_e, (problem.force.radiation * 1e9).round() / 1e9)
            })
            .collect();
        assert_eq!(found, [(0.1, 0.1), (0.1, 0.2), (0.1, 0.3), (0.2, 0.1), (0.2, 0.2), (0.2, 0.3)]);
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

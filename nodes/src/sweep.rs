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

    /// Whether every value makes a scenario of its own, and all that is written has an effect.
    ///
    /// # Errors
    /// What is wrong and what would be right.
    fn check(&self) -> Result<(), String> {
        match self {
            Self::List(values) if values.is_empty() => Err("names no value; it must name at least one".into()),
            Self::Range { count: 0, .. } => Err("count = 0 leaves no value; it must be at least 1".into()),
            Self::Range { from, to, count: 1 } if from != to => Err(format!(
                "to = {to} has no effect, as count = 1 takes from = {from} alone; write [{from}], or a count of 2 or more"
            )),
            _ => match self.repeated() {
                Some(value) => Err(format!(
                    "takes the value {value} twice, which makes the same scenario twice; values must differ"
                )),
                None => Ok(()),
            },
        }
    }

    /// A value that comes twice.
    fn repeated(&self) -> Option<f64> {
        let mut values: Vec<f64> = (0..self.count()).filter_map(|index| self.value(index)).collect();
        values.sort_by(f64::total_cmp);
        values.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0])
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
        if raw.vary.get_ref().is_empty() {
            return Err(file.error(&raw.vary, "names no key; it must vary at least one number of the scenario"));
        }
        let table: Table = base_file.parse()?;
        for (key, values) in raw.vary.get_ref() {
            if !numbers(&table).contains(key.get_ref()) {
                return Err(file.error(key, &not_varied(&table, key.get_ref())));
            }
            values.get_ref().check().map_err(|problem| file.error(key, &problem))?;
        }
        let mut count = 1usize;
        for values in raw.vary.get_ref().values() {
            count = count.saturating_mul(values.get_ref().count());
        }
        if count > MOST_SCENARIOS {
            let problem = format!("has {count} combinations; there must be at most {MOST_SCENARIOS}");
            return Err(file.error(&raw.vary, &problem));
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

/// The numbers of a scenario, as `TABLE.KEY`.
fn numbers(scenario: &Table) -> Vec<String> {
    let is_number = |value: &Value| value.is_float() || value.is_integer();
    let of_table = |(name, value): (&String, &Value)| {
        let keys = value.as_table().into_iter().flatten().filter(|(_, value)| is_number(value));
        keys.map(|(key, _)| format!("{name}.{key}")).collect::<Vec<_>>()
    };
    scenario.iter().flat_map(of_table).collect()
}

/// Why `key` cannot be varied, and what can.
fn not_varied(scenario: &Table, key: &str) -> String {
    let why = given_otherwise(scenario, key).unwrap_or("is not a number of the scenario");
    format!("{why}; what can be varied is {}", numbers(scenario).join(", "))
}

/// Orbit and times can each be given in two ways: what is to be said of a key of the way that the scenario has not taken.
fn given_otherwise(scenario: &Table, key: &str) -> Option<&'static str> {
    let has = |table: &str, key: &str| scenario.get(table).is_some_and(|table| table.get(key).is_some());
    match key {
        "orbit.radiation" | "orbit.oblateness" if has("orbit", "semi_major_axis") => {
            Some("is not in the scenario, which gives its orbit by the satellite")
        }
        "orbit.semi_major_axis" | "orbit.area_to_mass" | "orbit.reflectivity" if has("orbit", "radiation") => {
            Some("is not in the scenario, which gives its orbit by radiation and oblateness")
        }
        "times.end" | "times.step" if has("times", "at") => {
            Some("is not in the scenario, which lists its times in times.at")
        }
        _ if key.starts_with("times.at") && has("times", "at") => {
            Some("is not a number of the scenario but a list or in one, which a sweep cannot vary")
        }
        _ if key.starts_with("times.at") => Some("is not in the scenario, which gives its times by end and step"),
        _ => None,
    }
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

    /// A scenario that gives its orbit by the satellite and lists its times.
    const SATELLITE: &str = "name = \"s\"\n[orbit]\nsemi_major_axis = 2.5\narea_to_mass = 10\nreflectivity = 1.3\n[initial]\nphi = 2.2\n\
         e = 0.145\ndelta_phi = 0.39\ndelta_e = 0.05\n[times]\nat = [0.0, 1.0]\n[disposal]\ncritical_e = 0.6\n";

    fn load(text: &str) -> Result<Sweep, InputError> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("base.toml"), BASE).unwrap();
        std::fs::write(folder.path().join("satellite.toml"), SATELLITE).unwrap();
        let path = folder.path().join("sweep.toml");
        std::fs::write(&path, text).unwrap();
        Sweep::load(&path)
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
                (problem.initial.mean_e, (problem.model.radiation * 1e9).round() / 1e9)
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
            (
                vary("\"initial.eccentricity\" = [0.1]"),
                3,
                "not a number of the scenario; what can be varied is disposal.critical_e,",
            ),
            (vary("\"initial.e\" = []"), 3, "names no value"),
            (vary("\"initial.e\" = \"x\""), 3, "a list of numbers"),
            (vary("\"initial.e\" = [1.5]"), 2, "between 0 and 1"),
            (vary("\"initial.e\" = [0.1]\n\"initial.e\" = [0.2]"), 4, "for the second time"),
            (vary("\"initial.e\" = { from = 0.1, to = 0.2, count = 0 }"), 3, "count = 0 leaves no value"),
            (vary("\"initial.e\" = { from = 0.1, to = 0.2, count = 1 }"), 3, "initial.e: to = 0.2 has no effect"),
            (vary("\"initial.e\" = [0.1, 0.2, 0.10]"), 3, "initial.e: takes the value 0.1 twice"),
            (vary("\"initial.phi\" = [0.0, -0.0]"), 3, "twice"),
            (vary("\"initial.e\" = { from = 0.1, to = 0.1, count = 3 }"), 3, "takes the value 0.1 twice"),
            (vary("\"orbit.reflectivity\" = [1]"), 3, "gives its orbit by radiation and oblateness"),
            (vary("\"times.at\" = [1]"), 3, "gives its times by end and step"),
            (vary(""), 2, "names no key"),
            ("scenario = \"none.toml\"\n[vary]\n".into(), 1, "cannot be read"),
        ] {
            let error = load(&text).unwrap_err();
            assert_eq!(error.line, line, "{error}");
            assert!(error.to_string().contains(words), "{error}");
        }
        assert_eq!(load(&vary("\"initial.e\" = { from = 0.1, to = 0.1, count = 1 }")).unwrap().len(), 1);
    }

    #[test]
    fn a_key_that_the_scenario_gives_otherwise_is_refused_with_those_that_it_has() {
        for (key, words) in [
            (
                "orbit.radiation",
                "orbit.radiation: is not in the scenario, which gives its orbit by the satellite; what can be varied is ",
            ),
            ("orbit.oblateness", "initial.phi, orbit.area_to_mass, orbit.reflectivity, orbit.semi_major_axis"),
            ("times.end", "which lists its times in times.at"),
            ("times.at", "a list or in one"),
            ("times.at[1]", "a list or in one"),
            ("name", "not a number of the scenario"),
        ] {
            let error = load(&format!("scenario = \"satellite.toml\"\n[vary]\n\"{key}\" = [1]\n")).unwrap_err();
            assert!(error.line == 3 && error.to_string().contains(words), "{error}");
        }
    }
}

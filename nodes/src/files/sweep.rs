//! Sweep files: one scenario, with some of its values varied, in every combination. A map file is one as well.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::{Spanned, Table, Value};

use crate::files::file_kind::FileKind;
use crate::files::input::{InputError, InputFile, LONGEST_PLAIN_NAME};
use crate::files::plain_number::plain;
use crate::files::scenario_file::{self, AnyScenario};
use crate::files::sweep_values::{MOST_SCENARIOS, Values};

/// The keys that are varied, with their values.
pub(crate) type Varied = BTreeMap<Spanned<String>, Value>;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    scenario: Spanned<PathBuf>,
    vary: Spanned<Varied>,
}

/// The same in a map file, which says besides what is shown: that is for `phasecloud map` alone.
#[derive(Debug, Deserialize)]
struct RawOfMap {
    scenario: Spanned<PathBuf>,
    vary: Spanned<Varied>,
}

/// A key that is varied.
#[derive(Debug)]
struct Axis {
    key: String,
    values: Values,
    /// The place of the key in the sweep file.
    place: Spanned<()>,
}

/// A sweep: its scenarios are made one at a time.
#[derive(Debug)]
pub struct Sweep {
    file: InputFile,
    base: Table,
    base_text: String,
    name: String,
    axes: Vec<Axis>,
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
        if file.expect(FileKind::Map).is_ok() && file.expect(FileKind::Sweep).is_err() {
            let raw: RawOfMap = file.parse()?;
            return Self::varied(file, &raw.scenario, &raw.vary);
        }
        file.expect(FileKind::Sweep)?;
        let raw: Raw = file.parse()?;
        Self::varied(file, &raw.scenario, &raw.vary)
    }

    /// The combinations that a file names: a scenario, and the values of its keys that are varied. The scenario and the
    /// first combination are checked.
    ///
    /// # Errors
    /// [`InputError`] with file, line and key.
    pub(crate) fn varied(
        file: &InputFile,
        scenario: &Spanned<PathBuf>,
        vary: &Spanned<Varied>,
    ) -> Result<Self, InputError> {
        let folder = file.path().parent().unwrap_or(Path::new("."));
        let base_file = InputFile::read(&folder.join(scenario.get_ref()));
        let base_file = base_file.map_err(|error| file.error(scenario, &error.to_string()))?;
        Self::varied_of(file, scenario, vary, &base_file)
    }

    /// The same of a scenario file that has been read.
    ///
    /// # Errors
    /// [`InputError`] with file, line and key.
    pub(crate) fn varied_of(
        file: &InputFile,
        scenario: &Spanned<PathBuf>,
        vary: &Spanned<Varied>,
        base_file: &InputFile,
    ) -> Result<Self, InputError> {
        let in_base = |error: InputError| file.error(scenario, &error.to_string());
        let base = scenario_file::check_cloud(base_file).map_err(in_base)?;
        if vary.get_ref().is_empty() {
            return Err(file.error(vary, "names no key; it must vary at least one number of the scenario"));
        }
        let table: Table = base_file.parse()?;
        let axis =
            |(key, value): (&Spanned<String>, &Value)| axis(&table, key, value).map_err(|why| file.error(key, &why));
        let axes = vary.get_ref().iter().map(axis).collect::<Result<Vec<_>, _>>()?;
        let count = axes.iter().map(|axis| axis.values.count()).fold(1, usize::saturating_mul);
        if count > MOST_SCENARIOS {
            let problem = format!("has {count} combinations; there must be at most {MOST_SCENARIOS}");
            return Err(file.error(vary, &problem));
        }
        let (base_text, name) = (base_file.text().into(), base.name().into());
        let sweep = Self { file: file.clone(), base: table, base_text, name, axes, count };
        sweep.scenario(0)?;
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
        let snapshots = |index| self.scenario(index).ok().map(|scenario| scenario.times().len());
        (0..looked_at).filter_map(snapshots).max().unwrap_or(1)
    }

    /// The keys that are varied, as `TABLE.KEY`.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        self.axes.iter().map(|axis| axis.key.as_str())
    }

    /// The path of the sweep file.
    pub(crate) fn path(&self) -> &Path {
        self.file.path()
    }

    /// The text of the scenario file.
    pub(crate) fn base_text(&self) -> &str {
        &self.base_text
    }

    /// The unit in which a key is varied, if it is not the key's own.
    pub fn unit(&self, key: &str) -> Option<&str> {
        self.axes.iter().find(|axis| axis.key == key)?.values.unit()
    }

    /// How many values each key takes.
    pub fn counts(&self) -> Vec<usize> {
        self.axes.iter().map(|axis| axis.values.count()).collect()
    }

    /// A number of the scenario that is varied, by its key as `TABLE.KEY`.
    pub fn number(&self, index: usize, key: &str) -> Option<f64> {
        let varied = self.keys().zip(self.values(index)).find(|(varied, _)| *varied == key);
        let (name, tables) = split(key)?;
        let given = || tables.iter().try_fold(&self.base, |table, name| table.get(*name)?.as_table())?.get(name);
        varied.map(|(_, value)| value).or_else(|| given()?.as_float().or_else(|| Some(given()?.as_integer()? as f64)))
    }

    /// The value of each key in combination `index`, the last key varying fastest.
    pub fn values(&self, index: usize) -> Vec<f64> {
        let mut rest = index;
        let value = |Axis { values, .. }: &Axis| {
            let count = values.count().max(1);
            let value = values.value(rest % count).unwrap_or(f64::NAN);
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
        let words = |(key, value)| {
            let unit = self.unit(key).map(|unit| format!(" {unit}")).unwrap_or_default();
            format!("{key} = {}{unit}", plain(value))
        };
        self.keys().zip(values).map(words).collect::<Vec<_>>().join(", ")
    }

    /// The name of scenario `index`: `NAME-INDEX`, all of the same length; `NAME` is cut where it is too long for that.
    pub fn name(&self, index: usize) -> String {
        let digits = self.count.saturating_sub(1).to_string().len();
        let stem: String = self.name.chars().take(LONGEST_PLAIN_NAME - digits - 1).collect();
        format!("{stem}-{index:0digits$}")
    }

    /// The index of the scenario that is called `name`.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        let index = name.rsplit_once('-')?.1.parse().ok()?;
        (index < self.count && self.name(index) == name).then_some(index)
    }

    /// Scenario `index`.
    ///
    /// # Errors
    /// If its values are not allowed.
    pub fn scenario(&self, index: usize) -> Result<AnyScenario, InputError> {
        let mut table = self.base.clone();
        for (key, value) in self.keys().zip(self.values(index)) {
            set(&mut table, key, (value, self.unit(key)));
        }
        let name = self.name(index);
        table.insert("name".into(), Value::String(name.clone()));
        let varied = InputFile::from_text(Path::new(&name), &table.to_string());
        scenario_file::check_cloud(&varied).map_err(|error| self.impossible(index, &error))
    }

    /// The error that scenario `index` has no cloud.
    pub(crate) fn without_cloud(&self, index: usize) -> InputError {
        let problem = format!("{} describes a single orbit and no cloud about it", self.name(index));
        self.file.error_in_whole("scenario", &problem)
    }

    /// What is wrong with scenario `index`, at the place of the varied key that makes it so.
    fn impossible(&self, index: usize, InputError { key, problem, .. }: &InputError) -> InputError {
        let table = format!("{}.", key.split('.').next().unwrap_or(key));
        let exactly = self.axes.iter().find(|axis| axis.key == *key);
        let related = || self.axes.iter().find(|axis| axis.key.starts_with(&table));
        // A key of another table may be wrong because of the varied one, as the height of re-entry because of the
        // orbit's.
        let axis = exactly.or_else(related).or(self.axes.first());
        let about = if exactly.is_some() { String::new() } else { format!("{key}: ") };
        let told = format!("{about}{problem}, in {} ({})", self.name(index), self.combination(index));
        match axis {
            Some(axis) => self.file.error(&axis.place, &told),
            None => self.file.error_in_whole("vary", &told),
        }
    }
}

/// A key that can be varied, with its values.
///
/// # Errors
/// What is wrong and what would be right.
fn axis(scenario: &Table, key: &Spanned<String>, value: &Value) -> Result<Axis, String> {
    let name = key.get_ref();
    if let (Some(of_scenario @ Value::Table(_)), Value::Table(_)) = (scenario.get(name), value) {
        let whole = whole_key(name.clone(), of_scenario, value);
        return Err(format!("the whole key needs quotation marks under [vary]: \"{whole}\" = ..."));
    }
    if !numbers(scenario).contains(name) {
        return Err(not_varied(scenario, name));
    }
    Ok(Axis { key: name.clone(), values: Values::read(value)?, place: Spanned::new(key.span(), ()) })
}

/// The key that is meant by one that was written without quotation marks, so that it reads as tables.
fn whole_key(name: String, of_scenario: &Value, value: &Value) -> String {
    let (Value::Table(table), Value::Table(inner)) = (of_scenario, value) else { return name };
    let Some((key, value)) = inner.iter().next() else { return format!("{name}.KEY") };
    table.get(key).map_or(format!("{name}.{key}"), |within| whole_key(format!("{name}.{key}"), within, value))
}

/// The numbers of a scenario, as `TABLE.KEY`; those of a table within a table as `TABLE.TABLE.KEY`.
fn numbers(scenario: &Table) -> Vec<String> {
    // A text is a number with a unit; the values that a sweep gives it are in the key's own unit.
    let has_unit = |text: &str| text.trim_start().starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    let is_number = |value: &Value| value.is_float() || value.is_integer() || value.as_str().is_some_and(has_unit);
    let of_key = |table: &str, key: &str, value: &Value| match value {
        Value::Table(inner) => inner
            .iter()
            .filter(|(_, value)| is_number(value))
            .map(|(name, _)| format!("{table}.{key}.{name}"))
            .collect(),
        value if is_number(value) => vec![format!("{table}.{key}")],
        _ => Vec::new(),
    };
    let of_table = |(name, value): (&String, &Value)| {
        let keys = value.as_table().into_iter().flatten();
        keys.flat_map(|(key, value)| of_key(name, key, value)).collect::<Vec<_>>()
    };
    scenario.iter().flat_map(of_table).collect()
}

/// The name of a key, and the tables that it is in, the outermost first; `None` if it is in no table.
fn split(key: &str) -> Option<(&str, Vec<&str>)> {
    let (tables, name) = key.rsplit_once('.')?;
    Some((name, tables.split('.').collect()))
}

/// Why `key` cannot be varied, and what can.
fn not_varied(scenario: &Table, key: &str) -> String {
    let why = given_otherwise(scenario, key).unwrap_or("is not a number of the scenario");
    format!("{why}; what can be varied is {}", numbers(scenario).join(", "))
}

/// Orbit and times can each be given in two ways. This is the message about a key of the way that the scenario does
/// not use.
fn given_otherwise(scenario: &Table, key: &str) -> Option<&'static str> {
    let has = |table: &str, key: &str| scenario.get(table).is_some_and(|table| table.get(key).is_some());
    match key {
        "orbit.radiation" | "orbit.oblateness" | "orbit.sun" | "orbit.moon" if has("orbit", "area_to_mass") => {
            Some("is not in the scenario, which gives its orbit by the satellite")
        }
        "orbit.semi_major_axis" | "orbit.altitude" | "orbit.area_to_mass" | "orbit.reflectivity"
            if !has("orbit", "area_to_mass") =>
        {
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

fn set(scenario: &mut Table, key: &str, (value, unit): (f64, Option<&str>)) {
    let Some((name, tables)) = split(key) else { return };
    let innermost = tables.iter().try_fold(scenario, |table, name| table.get_mut(*name)?.as_table_mut());
    if let Some(table) = innermost {
        let value = unit.map_or(Value::Float(value), |unit| Value::String(format!("{value:?} {unit}")));
        table.insert(name.into(), value);
    }
}

#[cfg(test)]
mod tests;

//! The `[[propagator]]` tables of a launch file: one per case.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use bridge::plan::HOME;
use kit::limits::MOST_CASES;
use kit::shard::{MOST_SHARDS, Shard};
use messages::reporter::Reporter;
use messages::service::Service;
use nodes::files::input::{InputError, InputFile};
use nodes::files::unknown_key::{self, UnknownKey, nearest};
use nodes::methods::{BuiltIn, Misfit};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer, ValueDeserializer};

use crate::plan::checks::{check_name, checked_seconds};
use crate::plan::hosts::{self, Hosts};

/// One case: a propagator under a label.
#[derive(Debug, Clone)]
pub struct Case {
    /// The label.
    pub label: String,
    /// What runs.
    pub runs: Runs,
    /// How many processes share its work.
    pub shards: u32,
    /// Whether each process reduces its samples before it sends them.
    pub reduce: bool,
    /// The hosts on which the processes run, in turn; empty if they run at home.
    pub hosts: Vec<String>,
    /// Seconds of wall-clock time that the case may take for a scenario, if there is a limit.
    pub most_seconds: Option<f64>,
}

impl Case {
    /// The names of its processes, and which part of the case each computes.
    pub fn members(&self) -> impl Iterator<Item = (String, Shard)> {
        Shard::all(self.shards).map(|shard| (shard.process_of(&self.label).to_string(), shard))
    }

    /// Its processes.
    pub fn processes(&self) -> impl Iterator<Item = Reporter> {
        Shard::all(self.shards).map(|shard| shard.process_of(&self.label))
    }

    /// The host on which a shard runs.
    pub fn host_of(&self, shard: Shard) -> &str {
        let turn = shard.index as usize % self.hosts.len().max(1);
        self.hosts.get(turn).map_or(HOME, String::as_str)
    }
}

/// What a case runs.
#[derive(Debug, Clone)]
pub enum Runs {
    /// A propagator that comes with phasecloud.
    BuiltIn {
        /// Its name.
        node: String,
        /// Its settings.
        settings: BuiltIn,
    },
    /// Any program: command and arguments.
    Command(Vec<String>),
    /// A player of what was sent in the run that this file recorded.
    Recorded(PathBuf),
}

/// The keys of every propagator's table, besides its settings.
pub const KEYS: [&str; 7] = ["label", "node", "command", "shards", "reduce", "hosts", "most_seconds"];

/// What every propagator's table has besides its settings.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct RawCase {
    #[schemars(with = "String")]
    label: Spanned<String>,
    #[schemars(with = "Option<String>")]
    node: Option<Spanned<String>>,
    #[schemars(with = "Option<Vec<String>>")]
    command: Option<Spanned<Vec<String>>>,
    #[schemars(with = "Option<i64>")]
    shards: Option<Spanned<i64>>,
    #[schemars(with = "Option<bool>")]
    reduce: Option<Spanned<bool>>,
    #[schemars(with = "Option<Vec<String>>")]
    hosts: Option<Spanned<Vec<Spanned<String>>>>,
    #[schemars(with = "Option<f64>")]
    most_seconds: Option<Spanned<f64>>,
}

/// The schema of a case without its settings.
pub(super) fn case_schema(generator: &mut SchemaGenerator) -> Schema {
    RawCase::json_schema(generator)
}

/// All cases, in the file's order; `bins` are those of the comparison grid.
///
/// # Errors
/// [`InputError`] with file, line and key.
pub(crate) fn cases(
    file: &InputFile,
    propagators: Option<Spanned<DeValue<'_>>>,
    hosts: Option<&Hosts>,
    bins: (usize, usize),
) -> Result<Vec<Case>, InputError> {
    let Some(propagators) = propagators else {
        return Err(file.error_in_whole("propagator", "there is no [[propagator]] table; a run needs at least one"));
    };
    let span = propagators.span();
    let DeValue::Array(tables) = propagators.into_inner() else {
        return Err(file.error(&Spanned::new(span, ()), "must be written as [[propagator]], one table per case"));
    };
    let mut labels = BTreeSet::new();
    let mut cases = Vec::new();
    let mut propagators = 0;
    for table in tables {
        let (label, case) = case(file, table, hosts, bins)?;
        propagators += case.shards as usize;
        if propagators > MOST_PROPAGATORS {
            let problem = format!("more than {MOST_PROPAGATORS} processes in one run, with the shards of all cases");
            return Err(file.error(&label, &problem));
        }
        if !labels.insert(case.label.clone()) {
            let problem = format!("a second propagator with the label \"{}\"; labels must differ", case.label);
            return Err(file.error(&label, &problem));
        }
        if labels.len() > MOST_CASES {
            return Err(file.error(&label, &format!("more than {MOST_CASES} propagators in one run")));
        }
        cases.push(case);
    }
    if cases.is_empty() {
        return Err(file.error(&Spanned::new(span, ()), "is empty; a run needs at least one propagator"));
    }
    Ok(cases)
}

/// Most processes of a run that propagate.
const MOST_PROPAGATORS: usize = 128;
/// Longest name of a process.
const LONGEST_NAME: usize = 31;
/// The launcher's name where processes are named; no case may have it, or the name of a service, as its label.
pub const LAUNCHER: &str = "launcher";

fn case(
    file: &InputFile,
    table: Spanned<DeValue<'_>>,
    hosts: Option<&Hosts>,
    bins: (usize, usize),
) -> Result<(Spanned<String>, Case), InputError> {
    let span = table.span();
    let DeValue::Table(mut settings) = table.into_inner() else {
        return Err(file.error(&Spanned::new(span, ()), "must be written as [[propagator]], one table per case"));
    };
    let mut head = DeTable::new();
    for key in KEYS {
        if let Some((key, value)) = settings.remove_entry(key) {
            head.insert(key, value);
        }
    }
    if let Some(misspelt) = misspelt(file, &head, &settings) {
        return Err(misspelt);
    }
    let raw =
        RawCase::deserialize(Deserializer::from(Spanned::new(span.clone(), head))).map_err(|e| file.toml_error(&e))?;
    check_name(file, &raw.label)?;
    let label = raw.label.get_ref().clone();
    if label == LAUNCHER || Service::named(&label).is_some() {
        return Err(file.error(&raw.label, &format!("\"{label}\" is the name of one of phasecloud's own processes")));
    }
    let runs = match (raw.node, raw.command) {
        (Some(node), None) => built_in(file, &node, Spanned::new(span, settings), bins)?,
        (None, Some(command)) => {
            if let Some((key, _)) = settings.into_iter().next() {
                return Err(file.error(&key, &beside_command(key.get_ref())));
            }
            if command.get_ref().first().is_none_or(String::is_empty) {
                return Err(file.error(&command, "is empty; it must be a program and its arguments"));
            }
            Runs::Command(command.get_ref().clone())
        }
        _ => return Err(file.error(&raw.label, "needs either node or command, and not both")),
    };
    let shards = raw.shards.as_ref().map_or(Ok(1), |shards| checked_shards(file, shards, &label, &runs))?;
    if let (Some(reduce), Runs::BuiltIn { settings, .. }) = (&raw.reduce, &runs)
        && *reduce.get_ref()
    {
        settings.check_reduce().map_err(|problem| file.error(reduce, &problem))?;
    }
    let hosts = raw.hosts.as_ref().map_or(Ok(Vec::new()), |named| hosts::placement(file, named, hosts))?;
    let reduce = raw.reduce.is_some_and(Spanned::into_inner);
    let most_seconds = raw.most_seconds.as_ref().map(|most| checked_seconds(file, most)).transpose()?;
    Ok((raw.label, Case { label, runs, shards, reduce, hosts, most_seconds }))
}

/// The problem of a key that is not allowed beside `command`.
fn beside_command(key: &str) -> String {
    let advice = "give a program its settings as arguments";
    match nearest(key, KEYS) {
        Some(_) => format!("{}; {advice}", unknown_key::told(key, &[(KEYS.to_vec(), OF_EVERY_CASE)])),
        None => format!("is not allowed beside command; {advice}"),
    }
}

/// What [`KEYS`] are called in messages.
const OF_EVERY_CASE: &str = "of every case";

/// The error about a misspelt key that a case needs: this says more than that the key is missing.
fn misspelt(file: &InputFile, head: &DeTable<'_>, settings: &DeTable<'_>) -> Option<InputError> {
    let runs = ["node", "command"];
    let has_none = |keys: &[&str]| keys.iter().all(|key| !head.contains_key(*key));
    let needed = [&["label"][..], &runs[..]].into_iter().filter(|keys| has_none(keys)).flatten().copied();
    let needed: Vec<&str> = needed.collect();
    let is_meant = |key: &str| nearest(key, needed.iter().copied()).is_some() && !is_setting(key);
    let key = settings.keys().find(|key| is_meant(key.get_ref()))?;
    Some(file.error(key, &unknown_key::told(key.get_ref(), &[(KEYS.to_vec(), OF_EVERY_CASE)])))
}

/// Whether a key is a setting of any built-in propagator.
fn is_setting(key: &str) -> bool {
    let nameless = || toml::Table::from_iter([(String::new(), toml::Value::Boolean(true))]);
    let knows = |name: &&str| {
        let answer = BuiltIn::from_settings(name, nameless()).and_then(Result::err);
        answer.and_then(|error| UnknownKey::told_by(error.message())).is_some_and(|unknown| unknown.is_beside(key))
    };
    BuiltIn::NAMES.iter().any(knows)
}

/// An error about the command of case number `index`, counted from 0, at its place in the file.
pub fn command_error(file: &InputFile, index: usize, problem: &str) -> InputError {
    case_error(file, index, "command", problem)
}

/// An error about case number `index`, counted from 0, at the place of its label in the file.
pub fn label_error(file: &InputFile, index: usize, problem: &str) -> InputError {
    case_error(file, index, "label", problem)
}

fn case_error(file: &InputFile, index: usize, key: &str, problem: &str) -> InputError {
    let place = || {
        let table = file.table().ok()?;
        let DeValue::Array(cases) = table.get_ref().get("propagator")?.get_ref() else { return None };
        let DeValue::Table(case) = cases.get(index)?.get_ref() else { return None };
        Some(Spanned::new(case.get(key)?.span(), ()))
    };
    match place() {
        Some(place) => file.error(&place, problem),
        None => file.error_in_whole(&format!("propagator.{key}"), problem),
    }
}

fn checked_shards(file: &InputFile, shards: &Spanned<i64>, label: &str, runs: &Runs) -> Result<u32, InputError> {
    let refused = |problem: &str| Err(file.error(shards, problem));
    let count = match u32::try_from(*shards.get_ref()) {
        Ok(count) if (1..=MOST_SHARDS).contains(&count) => count,
        _ => return refused(&format!("{} is not allowed, it must be 1 to {MOST_SHARDS}", shards.get_ref())),
    };
    let longest = Shard { index: count - 1, count }.process_of(label).to_string().len();
    match runs {
        _ if count == 1 => Ok(count),
        _ if longest > LONGEST_NAME => refused(&format!(
            "the processes are called \"{label}/0\" and so on, which is longer than {LONGEST_NAME} characters; take a shorter \
             label"
        )),
        Runs::BuiltIn { settings, .. } => settings.check_shards(count).map_or_else(|why| refused(&why), |()| Ok(count)),
        _ => Ok(count),
    }
}

fn built_in(
    file: &InputFile,
    node: &Spanned<String>,
    settings: Spanned<DeTable<'_>>,
    bins: (usize, usize),
) -> Result<Runs, InputError> {
    let name = node.get_ref();
    let places: BTreeMap<String, Spanned<()>> =
        settings.get_ref().keys().map(|key| (key.get_ref().to_string(), Spanned::new(key.span(), ()))).collect();
    let table = Spanned::new(settings.span(), DeValue::Table(settings.into_inner()));
    match BuiltIn::from_settings(name, ValueDeserializer::from(table)) {
        Some(Ok(settings)) => {
            // An error in a default is reported where the propagator is named.
            let misfit = |Misfit { key, problem }: Misfit| match places.get(key) {
                Some(place) => file.error(place, &problem),
                None => file.error(node, &format!("{key}: {problem}")),
            };
            settings.check().and_then(|()| settings.check_bins(bins)).map_err(misfit)?;
            Ok(Runs::BuiltIn { node: name.clone(), settings })
        }
        Some(Err(error)) => {
            let told = file.toml_error(&error);
            Err(match UnknownKey::told_by(error.message()) {
                Some(unknown) => {
                    let problem = unknown.problem_beside(&format!("settings of {name}"), &KEYS, OF_EVERY_CASE);
                    InputError { problem, ..told }
                }
                None => told,
            })
        }
        None => {
            let problem = format!("\"{name}\" is unknown; it must be one of {}", BuiltIn::NAMES.join(", "));
            Err(file.error(node, &problem))
        }
    }
}

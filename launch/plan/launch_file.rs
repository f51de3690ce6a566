//! Launch files: which cases are run on which scenarios, and with which references they are compared.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use bridge::plan::HOME;
use density::trust::TOLERANCE;
use kit::limits::MOST_BINS;
use nodes::files::file_kind::FileKind;
use nodes::files::hosts_table::HostsTable;
use nodes::files::input::{InputError, InputFile};
use nodes::files::plain_number::plain;
use nodes::files::toml_words::choice;
use nodes::methods::accuracy::AccuracySetting;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;
use serde::de::IgnoredAny;
use toml::Spanned;
use toml::de::Deserializer;

use super::baseline;
use super::built_in;
use super::checks::{check_name, checked_seconds};
use super::programs;
use super::references::{References, checked_label, checked_references};
use super::scenario_inputs::{ScenarioInput, named_scenarios};
use crate::plan::cases::{self, Case, Runs};
use crate::plan::hosts::Hosts;

/// A checked launch file.
#[derive(Debug, Clone)]
pub struct Launch {
    /// The file's text, for the record.
    pub text: String,
    /// Its name.
    pub name: String,
    /// The scenarios, in order.
    pub scenarios: Vec<ScenarioInput>,
    /// Labels of the references: all are compared with the first that states a quantity and has not failed. At least
    /// one.
    pub references: Vec<String>,
    /// Label of the case in whose effort that of all is measured, if there is one.
    pub baseline: Option<String>,
    /// What methods are judged against: a share of one.
    pub tolerance: f64,
    /// Bins of the comparison grid in `phi` and `e`.
    pub bins: (usize, usize),
    /// Seconds without any sign of life after which a case is given up.
    pub patience: f64,
    /// Whether a process that dies is started again.
    pub restart: Restart,
    /// The cases.
    pub cases: Vec<Case>,
    /// What runs in place of phasecloud's own estimator or comparator; only replays have substitutes.
    pub substitutes: BTreeMap<String, Runs>,
    /// The other hosts, if there are any.
    pub hosts: Option<Hosts>,
}

/// When a process that has ended before the run did is started again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Restart {
    /// Not at all.
    Never,
    /// When it was killed or ended with an exit code other than 0, a few times per scenario.
    #[default]
    OnFailure,
}

/// The schema of a launch file without its cases.
pub(super) fn top_schema(generator: &mut SchemaGenerator) -> Schema {
    Raw::json_schema(generator)
}

/// The file's top level, without the propagators.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Raw {
    #[schemars(with = "String")]
    name: Spanned<String>,
    #[schemars(with = "Vec<PathBuf>")]
    scenarios: Spanned<Vec<Spanned<PathBuf>>>,
    #[schemars(with = "References")]
    reference: Spanned<References>,
    #[schemars(with = "Option<String>")]
    baseline: Option<Spanned<String>>,
    #[schemars(with = "Option<f64>")]
    tolerance: Option<Spanned<f64>>,
    #[schemars(with = "Option<[u16; 2]>")]
    bins: Option<Spanned<toml::Value>>,
    #[schemars(with = "Option<f64>")]
    patience: Option<Spanned<f64>>,
    #[serde(default, deserialize_with = "choice")]
    restart: Restart,
    hosts: Option<HostsTable>,
    /// The accuracy of the built-in cases that do not set their own.
    #[schemars(with = "Option<AccuracySetting>")]
    accuracy: Option<Spanned<AccuracySetting>>,
    /// The cases are read on their own; this field is here so that the message about an unknown key names them, too.
    #[serde(rename = "propagator")]
    #[schemars(skip)]
    _propagators: Option<IgnoredAny>,
}

impl Launch {
    /// Leaves the other hosts out: everything runs at home.
    pub fn stay_home(&mut self) {
        self.hosts = None;
        self.cases.iter_mut().for_each(|case| case.hosts.clear());
    }

    /// The processes that run on other hosts, and where.
    pub fn away(&self) -> BTreeMap<String, String> {
        let hosts = |case: &Case| {
            let of = |(name, shard)| (name, case.host_of(shard).to_owned());
            case.members().map(of).collect::<Vec<_>>()
        };
        self.cases.iter().flat_map(hosts).filter(|(_, host)| host != HOME).collect()
    }

    /// The most snapshots of any of its scenarios.
    pub fn most_snapshots(&self) -> usize {
        self.scenarios.iter().map(|scenario| scenario.content.times().len()).max().unwrap_or(1)
    }

    /// The most variables of the cloud of any of its scenarios.
    pub fn most_variables(&self) -> usize {
        self.scenarios.iter().map(|scenario| scenario.content.variables()).max().unwrap_or(2)
    }

    /// How many processes propagate.
    pub fn propagators(&self) -> usize {
        self.cases.iter().map(|case| case.shards as usize).sum()
    }

    /// Reads a launch file, or one that is built in, by its name or if none is named; `scenario` replaces the scenarios
    /// it names.
    ///
    /// # Errors
    /// [`InputError`] with file, line and key.
    pub fn load(path: Option<&Path>, scenario: Option<&Path>) -> Result<Self, InputError> {
        match (built_in::launch_file(path), path) {
            (Some(file), _) => Self::check(&file, None, scenario),
            (None, None) => Err(InputError {
                file: PathBuf::new(),
                line: 0,
                key: String::new(),
                problem: "name a launch file".into(),
            }),
            (None, Some(path)) => {
                let file = InputFile::read(path).map_err(|error| built_in::with_names(error, path))?;
                Self::check(&file, Some(path), scenario)
            }
        }
    }

    /// The same as [`Launch::load`] for a caller that will start the programs that the file names: they must be there.
    ///
    /// # Errors
    /// The same problems for which [`Launch::load`] refuses a file.
    pub fn load_to_start(path: Option<&Path>, scenario: Option<&Path>) -> Result<Self, InputError> {
        let launch = Self::load(path, scenario)?;
        let file = InputFile::from_text(path.unwrap_or(Path::new("")), &launch.text);
        match programs::problems(&file, &launch.cases).into_iter().next() {
            None => Ok(launch),
            Some(problem) => Err(problem),
        }
    }

    /// Checks a launch file that has been read from `path`, or is built in; `scenario` as for [`Launch::load`].
    ///
    /// # Errors
    /// [`InputError`] with file, line and key.
    pub fn check(file: &InputFile, path: Option<&Path>, scenario: Option<&Path>) -> Result<Self, InputError> {
        Self::check_with(file, |raw| named_scenarios(file, path, &raw.scenarios, scenario))
    }

    /// Reads a launch file and its scenarios, each a name and a text, as they were recorded.
    pub fn from_record(text: &str, recorded: &[(String, String)]) -> Result<Self, InputError> {
        let file = InputFile::from_text(Path::new("the recorded launch file"), text);
        let input =
            |(name, text): &(String, String)| ScenarioInput::check(&InputFile::from_text(Path::new(name), text));
        Self::check_with(&file, |_| recorded.iter().map(input).collect())
    }

    /// Lets hosts talk without encryption, if `insecure`, and checks whether they can talk at all.
    ///
    /// # Errors
    /// What is missing.
    pub fn open_to_hosts(&mut self, insecure: bool) -> Result<(), String> {
        self.hosts.as_mut().map_or(Ok(()), |hosts| hosts.open(insecure))
    }

    fn check_with(
        file: &InputFile,
        scenarios: impl FnOnce(&Raw) -> Result<Vec<ScenarioInput>, InputError>,
    ) -> Result<Self, InputError> {
        file.expect(FileKind::Launch)?;
        let mut top = file.table()?;
        let propagators = top.get_mut().remove("propagator");
        let raw = Raw::deserialize(Deserializer::from(top)).map_err(|e| file.toml_error(&e))?;
        let folder = file.path().parent().unwrap_or(Path::new("."));
        let hosts = raw.hosts.as_ref().map(|raw| Hosts::check(file, raw, folder)).transpose()?;
        let bins = raw.bins.as_ref().map_or(Ok((100, 100)), |bins| checked_bins(file, bins))?;
        let mut cases = cases::cases(file, propagators, hosts.as_ref(), bins)?;
        set_accuracy(file, raw.accuracy.as_ref(), &mut cases)?;
        check_name(file, &raw.name)?;
        let references = checked_references(file, &raw.reference, &cases)?;
        let baseline = match &raw.baseline {
            Some(label) => Some(checked_label(file, label, label.get_ref(), &cases)?),
            None => baseline::among(cases.iter().map(|case| case.label.as_str())).map(str::to_owned),
        };
        Ok(Self {
            text: file.text().into(),
            name: raw.name.get_ref().clone(),
            scenarios: scenarios(&raw)?,
            references,
            baseline,
            tolerance: raw.tolerance.as_ref().map_or(Ok(TOLERANCE), |tolerance| checked_tolerance(file, tolerance))?,
            bins,
            patience: raw.patience.as_ref().map_or(Ok(600.0), |patience| checked_seconds(file, patience))?,
            restart: raw.restart,
            cases,
            substitutes: BTreeMap::new(),
            hosts,
        })
    }
}

fn checked_tolerance(file: &InputFile, tolerance: &Spanned<f64>) -> Result<f64, InputError> {
    let share = *tolerance.get_ref();
    if share > 0.0 && share <= 1.0 {
        return Ok(share);
    }
    Err(file
        .error(tolerance, &format!("{} is not allowed, it must be a share greater than 0 and at most 1", plain(share))))
}

fn checked_bins(file: &InputFile, bins: &Spanned<toml::Value>) -> Result<(usize, usize), InputError> {
    let numbers: Option<Vec<i64>> = match bins.get_ref() {
        toml::Value::Array(values) => values.iter().map(toml::Value::as_integer).collect(),
        _ => None,
    };
    let Some([phi, e]) = numbers.as_deref() else {
        let problem = format!(
            "{} is not allowed, it must be two whole numbers, the bins in phi and in e: bins = [100, 100]",
            bins.get_ref()
        );
        return Err(file.error(bins, &problem));
    };
    let allowed = 1..=MOST_BINS as i64;
    if allowed.contains(phi) && allowed.contains(e) {
        return Ok((*phi as usize, *e as usize));
    }
    Err(file.error(bins, &format!("[{phi}, {e}] is not allowed, both must be between 1 and {MOST_BINS}")))
}

/// Gives the file's accuracy to the built-in cases that do not set their own.
fn set_accuracy(
    file: &InputFile,
    accuracy: Option<&Spanned<AccuracySetting>>,
    cases: &mut [Case],
) -> Result<(), InputError> {
    let mut has_effect = false;
    for case in cases {
        if let Runs::BuiltIn { settings, .. } = &mut case.runs {
            has_effect |= settings.accuracy_mut().is_none();
            settings.accuracy_mut().get_or_insert(accuracy.map_or_else(AccuracySetting::default, |set| *set.get_ref()));
        }
    }
    match accuracy {
        Some(accuracy) if !has_effect => {
            let problem =
                "has no effect: no case runs a built-in propagator without an accuracy of its own; leave it out";
            Err(file.error(accuracy, problem))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;

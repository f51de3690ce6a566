//! Launch files: which cases are run on which scenarios, and compared with which.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use bridge::endpoint::End;
use bridge::plan::HOME;
use nodes::accuracy::AccuracySetting;
use nodes::input::{InputError, InputFile, PLAIN_NAME, is_plain_name};
use nodes::scenario_file::{self, ScenarioFile};
use nodes::screen::MOST_BINS;
use serde::Deserialize;
use toml::Spanned;
use toml::de::Deserializer;

use crate::cases::{self, Case, Runs};
use crate::hosts::{Hosts, RawHosts, WITHOUT_HOSTS};

/// The launch file that `phasecloud run` takes when none is named, and the scenario it names.
const DEFAULT: (&str, &str) = (include_str!("scenario-1.toml"), include_str!("scenarios/scenario-1.toml"));

/// A checked launch file.
#[derive(Debug, Clone)]
pub struct Launch {
    /// The file's text, for the record.
    pub text: String,
    /// Its name.
    pub name: String,
    /// The scenarios, in order.
    pub scenarios: Vec<ScenarioInput>,
    /// Label of the case that all are compared with.
    pub reference: String,
    /// Bins of the comparison grid in `phi` and `e`.
    pub bins: (usize, usize),
    /// Seconds without any sign of life after which a case is given up.
    pub patience: f64,
    /// Whether a process that dies is started again.
    pub restart: Restart,
    /// The cases.
    pub cases: Vec<Case>,
    /// What runs in place of phasecloud's own estimator or comparator; only replays have such.
    pub substitutes: BTreeMap<String, Runs>,
    /// The other hosts, if there are any.
    pub hosts: Option<Hosts>,
}

/// When a process that has ended before the run did is started again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Restart {
    /// Not at all.
    Never,
    /// When it was killed or ended with an exit code other than 0, a few times a scenario.
    #[default]
    OnFailure,
}

/// A scenario with the file it came from.
#[derive(Debug, Clone)]
pub struct ScenarioInput {
    /// The file; empty for the scenario built into the program.
    pub text: String,
    /// What it says.
    pub content: ScenarioFile,
}

/// The file's top level, without the propagators.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    name: Spanned<String>,
    scenarios: Spanned<Vec<Spanned<PathBuf>>>,
    reference: Spanned<String>,
    bins: Option<Spanned<(i64, i64)>>,
    patience: Option<Spanned<f64>>,
    #[serde(default)]
    restart: Restart,
    hosts: Option<RawHosts>,
    /// Of the built-in cases that do not set their own.
    #[serde(default)]
    accuracy: AccuracySetting,
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

    /// How many processes propagate.
    pub fn propagators(&self) -> usize {
        self.cases.iter().map(|case| case.shards as usize).sum()
    }

    /// Reads a launch file, or the one built in; `scenario` replaces the scenarios it names.
    ///
    /// # Errors
    /// [`InputError`] with file, line and key.
    pub fn load(path: Option<&Path>, scenario: Option<&Path>) -> Result<Self, InputError> {
        let file = match path {
            Some(path) => InputFile::read(path)?,
            None => InputFile::from_text(Path::new("launch/scenario-1.toml"), DEFAULT.0),
        };
        Self::check(&file, path, scenario)
    }

    /// Checks a launch file that has been read from `path`, or the one built in; `scenario` as for [`Launch::load`].
    ///
    /// # Errors
    /// [`InputError`] with file, line and key.
    pub fn check(file: &InputFile, path: Option<&Path>, scenario: Option<&Path>) -> Result<Self, InputError> {
        Self::check_with(file, |raw| scenarios(file, path, raw, scenario))
    }

    /// Reads a launch file and its scenarios as they were recorded, name and text.
    pub fn from_record(text: &str, recorded: &[(String, String)]) -> Result<Self, InputError> {
        let file = InputFile::from_text(Path::new("the recorded launch file"), text);
        let input = |(name, text): &(String, String)| scenario(InputFile::from_text(Path::new(name), text));
        Self::check_with(&file, |_| recorded.iter().map(input).collect())
    }

    /// Says that hosts may talk without encryption, if `insecure`, and checks whether they can talk at all.
    ///
    /// # Errors
    /// What is missing.
    pub fn open_to_hosts(&mut self, insecure: bool) -> Result<(), String> {
        match &mut self.hosts {
            Some(hosts) if cfg!(feature = "hosts") => {
                hosts.access.insecure = insecure;
                hosts.access.check(End::Listens).map_err(|why| format!("hosts.listen: {why}"))
            }
            Some(_) => Err(format!("hosts: {WITHOUT_HOSTS}")),
            None => Ok(()),
        }
    }

    fn check_with(
        file: &InputFile,
        scenarios: impl FnOnce(&Raw) -> Result<Vec<ScenarioInput>, InputError>,
    ) -> Result<Self, InputError> {
        let mut top = file.table()?;
        let propagators = top.get_mut().remove("propagator");
        let raw = Raw::deserialize(Deserializer::from(top)).map_err(|e| file.toml_error(&e))?;
        let folder = file.path().parent().unwrap_or(Path::new("."));
        let hosts = raw.hosts.as_ref().map(|raw| Hosts::check(file, raw, folder)).transpose()?;
        let mut cases = cases::cases(file, propagators, hosts.as_ref())?;
        for case in &mut cases {
            if let Runs::BuiltIn { settings, .. } = &mut case.runs {
                settings.accuracy_mut().get_or_insert(raw.accuracy);
            }
        }
        check_name(file, &raw.name)?;
        let reference = raw.reference.get_ref();
        if !cases.iter().any(|case| case.label == *reference) {
            let labels: Vec<_> = cases.iter().map(|case| case.label.as_str()).collect();
            let problem = format!("no propagator has the label \"{reference}\"; there are {}", labels.join(", "));
            return Err(file.error(&raw.reference, &problem));
        }
        Ok(Self {
            text: file.text().into(),
            name: raw.name.get_ref().clone(),
            scenarios: scenarios(&raw)?,
            reference: reference.clone(),
            bins: raw.bins.as_ref().map_or(Ok((100, 100)), |bins| checked_bins(file, bins))?,
            patience: raw.patience.as_ref().map_or(Ok(600.0), |patience| checked_seconds(file, patience))?,
            restart: raw.restart,
            cases,
            substitutes: BTreeMap::new(),
            hosts,
        })
    }
}

pub(crate) fn check_name(file: &InputFile, name: &Spanned<String>) -> Result<(), InputError> {
    if is_plain_name(name.get_ref()) {
        return Ok(());
    }
    Err(file.error(name, &format!("\"{}\" is not allowed, {PLAIN_NAME}", name.get_ref())))
}

fn checked_bins(file: &InputFile, bins: &Spanned<(i64, i64)>) -> Result<(usize, usize), InputError> {
    let allowed = 1..=MOST_BINS as i64;
    let (phi, e) = *bins.get_ref();
    if allowed.contains(&phi) && allowed.contains(&e) {
        return Ok((phi as usize, e as usize));
    }
    Err(file.error(bins, &format!("[{phi}, {e}] is not allowed, both must be between 1 and {MOST_BINS}")))
}

/// Longest time that a launch file may give \[s\].
const LONGEST: f64 = 1e9;

pub(crate) fn checked_seconds(file: &InputFile, value: &Spanned<f64>) -> Result<f64, InputError> {
    let seconds = *value.get_ref();
    if seconds > 0.0 && seconds <= LONGEST {
        return Ok(seconds);
    }
    let problem =
        format!("{seconds} is not allowed, it must be a number of seconds greater than 0 and at most {LONGEST}");
    Err(file.error(value, &problem))
}

/// The scenarios that a launch file names, relative to its folder, or the one that replaces them.
fn scenarios(
    file: &InputFile,
    path: Option<&Path>,
    raw: &Raw,
    replacement: Option<&Path>,
) -> Result<Vec<ScenarioInput>, InputError> {
    if let Some(replacement) = replacement {
        return Ok(vec![scenario(InputFile::read(replacement)?)?]);
    }
    let Some(path) = path else {
        return Ok(vec![scenario(InputFile::from_text(Path::new("launch/scenarios/scenario-1.toml"), DEFAULT.1))?]);
    };
    let folder = path.parent().unwrap_or(Path::new("."));
    let named = raw.scenarios.get_ref();
    if named.is_empty() {
        return Err(file.error(&raw.scenarios, "names no scenario; it must name at least one file"));
    }
    let mut names = BTreeSet::new();
    let mut inputs = Vec::new();
    for relative in named {
        let content =
            InputFile::read(&folder.join(relative.get_ref())).map_err(|e| file.error(relative, &e.to_string()))?;
        let input = scenario(content)?;
        if !names.insert(input.content.name.clone()) {
            let problem = format!("a second scenario with the name \"{}\"; names must differ", input.content.name);
            return Err(file.error(relative, &problem));
        }
        inputs.push(input);
    }
    Ok(inputs)
}

fn scenario(file: InputFile) -> Result<ScenarioInput, InputError> {
    Ok(ScenarioInput { content: scenario_file::check(&file)?, text: file.text().into() })
}

#[cfg(test)]
mod tests {
    use density::flow::Accuracy;

    use super::*;

    fn load(text: &str) -> Result<Launch, InputError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("l.toml");
        std::fs::write(folder.path().join("s.toml"), DEFAULT.1).unwrap();
        std::fs::write(&path, text).unwrap();
        Launch::load(Some(&path), None)
    }

    const GOOD: &str = "name = \"l\"\nscenarios = [\"s.toml\"]\nreference = \"mc\"\n\
        [[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 10\n\
        [[propagator]]\nlabel = \"mine\"\ncommand = [\"./mine\", \"-x\"]\n";

    #[test]
    fn the_launch_files_of_the_project_are_good() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("launch");
        for entry in std::fs::read_dir(folder).unwrap().flatten() {
            if entry.path().extension().is_some_and(|e| e == "toml") {
                Launch::load(Some(&entry.path()), None).unwrap();
            }
        }
        assert_eq!(Launch::load(None, None).unwrap().cases.len(), 5);
    }

    #[test]
    fn accuracy_is_that_of_the_file_unless_a_case_has_its_own() {
        let accuracy = |text: &str| match load(text).unwrap().cases.remove(0).runs {
            Runs::BuiltIn { mut settings, .. } => settings.accuracy_mut().unwrap().0,
            other => panic!("{other:?}"),
        };
        let of_file = GOOD.replace("[[propagator]]\nlabel = \"mc\"", "accuracy = 1e-9\n[[propagator]]\nlabel = \"mc\"");
        assert_eq!(accuracy(GOOD), Accuracy::Fine);
        assert_eq!(accuracy(&of_file), Accuracy::Medium);
        assert_eq!(accuracy(&of_file.replace("samples = 10", "accuracy = 1e-6")), Accuracy::Coarse);
    }

    #[test]
    fn every_mistake_is_told_with_line_and_key() {
        let cases = [
            ("samples = 10", "samples = 0", 7, "propagator.samples", "at least 1"),
            (
                "samples = 10",
                "sample = 10",
                7,
                "propagator.sample",
                "unknown field `sample`, expected one of `samples`, `seed`",
            ),
            ("samples = 10", "samples = \"x\"", 7, "propagator.samples", "invalid type: string \"x\""),
            ("node = \"mc\"", "node = \"nc\"", 6, "propagator.node", "one of mc, dee, gmm-ut, exact"),
            ("label = \"mine\"", "label = \"mc\"", 9, "propagator.label", "labels must differ"),
            ("label = \"mine\"", "label = \"../mine\"", 9, "propagator.label", "letters, digits"),
            ("label = \"mine\"", "label = \"recorder\"", 9, "propagator.label", "own processes"),
            ("reference = \"mc\"", "reference = \"md\"", 3, "reference", "there are mc, mine"),
            ("reference = \"mc\"", "referense = \"mc\"", 3, "referense", "unknown field"),
            ("s.toml", "t.toml", 2, "scenarios", "cannot be read"),
            ("[\"./mine\", \"-x\"]", "[]", 10, "propagator.command", "is empty"),
            ("node = \"mc\"\n", "", 5, "propagator.label", "either node or command"),
            ("reference = \"mc\"", "reference = \"mc\"\naccuracy = 1e-7", 4, "accuracy", "1e-6, 1e-9 or 1e-12"),
            ("samples = 10", "accuracy = 0.1", 7, "propagator.accuracy", "1e-6, 1e-9 or 1e-12"),
            ("reference = \"mc\"", "reference = \"mc\"\nbins = [0, 5]", 4, "bins", "between 1 and 2000"),
            ("samples = 10", "reduce = 1", 7, "propagator.reduce", "invalid type: integer"),
            ("samples = 10", "replicates = 2\nreduce = true", 8, "propagator.reduce", "standard errors of replicates"),
            (
                "node = \"mc\"\nsamples = 10",
                "node = \"dee\"\nreduce = true",
                7,
                "propagator.reduce",
                "only the samples of mc",
            ),
            ("samples = 10", "most_seconds = 0.0", 7, "propagator.most_seconds", "greater than 0"),
            ("samples = 10", "most_seconds = nan", 7, "propagator.most_seconds", "greater than 0"),
            ("samples = 10", "most_seconds = \"5\"", 7, "propagator.most_seconds", "invalid type: string"),
            ("samples = 10", "shards = 0", 7, "propagator.shards", "1 to 64"),
            ("samples = 10", "shards = 65", 7, "propagator.shards", "1 to 64"),
            ("samples = 10", "shards = 2.5", 7, "propagator.shards", "invalid type: floating point"),
            ("samples = 10", "samples = 10\nshards = 11", 8, "propagator.shards", "too many for 10 rows"),
            ("node = \"mc\"\nsamples = 10", "node = \"exact\"\nshards = 2", 7, "propagator.shards", "cannot be split"),
            ("node = \"mc\"\nsamples = 10", "node = \"gmm-ut\"\nshards = 2", 7, "propagator.shards", "cannot be split"),
            (
                "label = \"mine\"",
                "label = \"a-label-of-thirty-characters-xy\"\nshards = 2",
                10,
                "propagator.shards",
                "a shorter label",
            ),
            (
                "samples = 10",
                "shards = 64\n[[propagator]]\nlabel = \"b\"\nnode = \"mc\"\nshards = 64",
                13,
                "propagator.label",
                "more than 128 processes",
            ),
            ("reference = \"mc\"", "reference = \"mc\"\nrestart = \"ever\"", 4, "restart", "`never` or `on-failure`"),
        ];
        for (from, to, line, key, words) in cases {
            assert!(GOOD.contains(from), "{from}");
            let error = load(&GOOD.replace(from, to)).unwrap_err();
            assert_eq!((error.line, error.key.as_str()), (line, key), "{error}");
            assert!(error.to_string().contains(words), "{error}");
        }
        load(GOOD).unwrap();
    }
}

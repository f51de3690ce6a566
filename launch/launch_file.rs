//! Launch files: which cases are run on which scenarios, and compared with which.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use bridge::endpoint::End;
use bridge::plan::HOME;
use density::trust::TOLERANCE;
use nodes::accuracy::AccuracySetting;
use nodes::file_kind::FileKind;
use nodes::input::{InputError, InputFile, PLAIN_NAME, is_plain_name};
use nodes::plain_number::plain;
use nodes::scenario_file::{self, ScenarioFile};
use nodes::screen::MOST_BINS;
use nodes::toml_words::choice;
use serde::Deserialize;
use serde::de::IgnoredAny;
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
    /// Labels of the cases that all are compared with: the first that states a quantity and has not failed. At least one.
    pub references: Vec<String>,
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

/// `reference = "exact"`, or `reference = ["exact", "mc"]`.
#[derive(Debug)]
struct References(Vec<String>);

impl<'de> Deserialize<'de> for References {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;

        impl<'de> serde::de::Visitor<'de> for Visitor {
            type Value = References;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("the label of a case, or a list of labels")
            }

            fn visit_str<E: serde::de::Error>(self, label: &str) -> Result<References, E> {
                Ok(References(vec![label.into()]))
            }

            fn visit_seq<A: serde::de::SeqAccess<'de>>(self, mut list: A) -> Result<References, A::Error> {
                let mut labels = Vec::new();
                while let Some(label) = list.next_element()? {
                    labels.push(label);
                }
                Ok(References(labels))
            }
        }

        deserializer.deserialize_any(Visitor)
    }
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
    reference: Spanned<References>,
    tolerance: Option<Spanned<f64>>,
    bins: Option<Spanned<toml::Value>>,
    patience: Option<Spanned<f64>>,
    #[serde(default, deserialize_with = "choice")]
    restart: Restart,
    hosts: Option<RawHosts>,
    /// Of the built-in cases that do not set their own.
    accuracy: Option<Spanned<AccuracySetting>>,
    /// Read on their own; here so that the answer to a key that is not known names them too.
    #[serde(rename = "propagator")]
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
        self.scenarios.iter().map(|scenario| scenario.content.problem.times.len()).max().unwrap_or(1)
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
        FileKind::Launch.expect(file)?;
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
        Ok(Self {
            text: file.text().into(),
            name: raw.name.get_ref().clone(),
            scenarios: scenarios(&raw)?,
            references,
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

pub(crate) fn check_name(file: &InputFile, name: &Spanned<String>) -> Result<(), InputError> {
    if is_plain_name(name.get_ref()) {
        return Ok(());
    }
    Err(file.error(name, &format!("\"{}\" is not allowed, {PLAIN_NAME}", name.get_ref())))
}

fn checked_references(
    file: &InputFile,
    reference: &Spanned<References>,
    cases: &[Case],
) -> Result<Vec<String>, InputError> {
    let References(labels) = reference.get_ref();
    if labels.is_empty() {
        return Err(file.error(reference, "names no case; it must name at least one"));
    }
    if labels.iter().collect::<BTreeSet<_>>().len() < labels.len() {
        return Err(file.error(reference, &format!("\"{}\" names a case twice", labels.join("\", \""))));
    }
    match labels.iter().find(|label| !cases.iter().any(|case| case.label == **label)) {
        None => Ok(labels.clone()),
        Some(unknown) => {
            let there: Vec<_> = cases.iter().map(|case| case.label.as_str()).collect();
            let problem = format!("no propagator has the label \"{unknown}\"; there are {}", there.join(", "));
            Err(file.error(reference, &problem))
        }
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

/// Longest time that a launch file may give \[s\].
const LONGEST: f64 = 1e9;

pub(crate) fn checked_seconds(file: &InputFile, value: &Spanned<f64>) -> Result<f64, InputError> {
    let seconds = *value.get_ref();
    if seconds > 0.0 && seconds <= LONGEST {
        return Ok(seconds);
    }
    let seconds = plain(seconds);
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
        let another = "[[propagator]]\nlabel = \"dee\"\nnode = \"dee\"\n";
        let both = of_file.replace("samples = 10", "accuracy = 1e-6") + another;
        assert_eq!(accuracy(&both), Accuracy::Coarse);
    }

    #[test]
    fn all_are_compared_with_one_case_or_with_the_first_of_several_that_knows() {
        assert_eq!((load(GOOD).unwrap().references, load(GOOD).unwrap().tolerance), (vec!["mc".to_owned()], 0.01));
        let several = GOOD.replace("reference = \"mc\"", "reference = [\"mine\", \"mc\"]\ntolerance = 0.05");
        let several = load(&several).unwrap();
        assert_eq!((several.references, several.tolerance), (vec!["mine".to_owned(), "mc".to_owned()], 0.05));
    }

    #[test]
    fn an_accuracy_that_no_case_uses_is_refused() {
        let own = GOOD.replace("samples = 10", "samples = 10\naccuracy = 1e-6");
        let error = load(&own.replace("reference = \"mc\"", "reference = \"mc\"\naccuracy = 1e-9")).unwrap_err();
        assert_eq!((error.line, error.key.as_str()), (4, "accuracy"), "{error}");
        assert!(error.to_string().contains("has no effect"), "{error}");
        load(&own).unwrap();
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
                "is unknown, did you mean `samples`? There may be `samples`, `seed`, `draws`, `replicates`, `accuracy` \
                 (settings of mc); `label`, `node`, `command`, `shards`, `reduce`, `hosts`, `most_seconds` (of every case)",
            ),
            (
                "samples = 10",
                "shard = 2",
                7,
                "propagator.shard",
                "is unknown, did you mean `shards`? There may be `samples`, ",
            ),
            ("samples = 10", "most_second = 2", 7, "propagator.most_second", "did you mean `most_seconds`?"),
            ("samples = 10", "lable = \"x\"", 7, "propagator.lable", "did you mean `label`?"),
            ("samples = 10", "colour = 3", 7, "propagator.colour", "is unknown; there may be `samples`, "),
            (
                "label = \"mc\"",
                "lable = \"mc\"",
                5,
                "propagator.lable",
                "did you mean `label`? There may be `label`, `node`,",
            ),
            ("node = \"mc\"", "nod = \"mc\"", 6, "propagator.nod", "did you mean `node`?"),
            ("command = ", "shard = 2\ncommand = ", 10, "propagator.shard", "did you mean `shards`?"),
            ("command = ", "samples = 2\ncommand = ", 10, "propagator.samples", "is not allowed beside command"),
            (
                "samples = 10",
                "samples = \"x\"",
                7,
                "propagator.samples",
                "\"x\" is not allowed, it must be a whole number",
            ),
            (
                "samples = 10",
                "samples = 2000.0",
                7,
                "propagator.samples",
                "a whole number, without a decimal point: 2000",
            ),
            (
                "samples = 10",
                "draws = true",
                7,
                "propagator.draws",
                "one of \"independent\", \"antithetic\", \"sobol\"",
            ),
            (
                "node = \"mc\"\nsamples = 10",
                "node = \"dee\"\nsamples = 3",
                7,
                "propagator.samples",
                "3 are too few for a mesh; it needs at least 4",
            ),
            ("[\"s.toml\"]", "\"s.toml\"", 2, "scenarios", "\"s.toml\" is not allowed, it must be a list"),
            ("[\"s.toml\"]", "[1]", 2, "scenarios", "1 is not allowed, it must be text, in quotation marks"),
            ("node = \"mc\"", "node = \"nc\"", 6, "propagator.node", "one of mc, dee, gmm-ut, exact"),
            ("label = \"mine\"", "label = \"mc\"", 9, "propagator.label", "labels must differ"),
            ("label = \"mine\"", "label = \"../mine\"", 9, "propagator.label", "letters, digits"),
            ("label = \"mine\"", "label = \"recorder\"", 9, "propagator.label", "own processes"),
            ("reference = \"mc\"", "reference = \"md\"", 3, "reference", "there are mc, mine"),
            ("reference = \"mc\"", "reference = [\"mc\", \"md\"]", 3, "reference", "\"md\"; there are mc, mine"),
            ("reference = \"mc\"", "reference = [\"mc\", \"mc\"]", 3, "reference", "names a case twice"),
            ("reference = \"mc\"", "reference = []", 3, "reference", "names no case"),
            ("reference = \"mc\"", "reference = 1", 3, "reference", "the label of a case, or a list of labels"),
            ("reference = \"mc\"", "reference = \"mc\"\ntolerance = 0", 4, "tolerance", "greater than 0 and at most 1"),
            (
                "reference = \"mc\"",
                "reference = \"mc\"\ntolerance = nan",
                4,
                "tolerance",
                "greater than 0 and at most 1",
            ),
            (
                "reference = \"mc\"",
                "referense = \"mc\"",
                3,
                "referense",
                "is unknown, did you mean `reference`? There may be `name`, `scenarios`, `reference`, ",
            ),
            ("s.toml", "t.toml", 2, "scenarios", "cannot be read"),
            ("[\"./mine\", \"-x\"]", "[]", 10, "propagator.command", "is empty"),
            ("node = \"mc\"\n", "", 5, "propagator.label", "either node or command"),
            ("reference = \"mc\"", "reference = \"mc\"\naccuracy = 1e-7", 4, "accuracy", "1e-6, 1e-9 or 1e-12"),
            ("samples = 10", "accuracy = 0.1", 7, "propagator.accuracy", "1e-6, 1e-9 or 1e-12"),
            ("reference = \"mc\"", "reference = \"mc\"\nbins = [0, 5]", 4, "bins", "between 1 and 2000"),
            ("samples = 10", "reduce = 1", 7, "propagator.reduce", "1 is not allowed, it must be true or false"),
            ("samples = 10", "replicates = 2\nreduce = true", 8, "propagator.reduce", "standard errors of replicates"),
            (
                "node = \"mc\"\nsamples = 10",
                "node = \"dee\"\nreduce = true",
                7,
                "propagator.reduce",
                "only the samples of mc",
            ),
            ("samples = 10", "seed = -1", 7, "propagator.seed", "-1 is not allowed, it must be at least 0"),
            ("samples = 10", "seed = 9223372036854775808", 7, "propagator.seed", "whole numbers lie between"),
            ("samples = 10", "most_seconds = 0.0", 7, "propagator.most_seconds", "greater than 0"),
            ("samples = 10", "most_seconds = nan", 7, "propagator.most_seconds", "greater than 0"),
            (
                "samples = 10",
                "most_seconds = \"5\"",
                7,
                "propagator.most_seconds",
                "\"5\" is not allowed, it must be a number",
            ),
            ("samples = 10", "shards = 0", 7, "propagator.shards", "1 to 64"),
            ("samples = 10", "shards = 65", 7, "propagator.shards", "1 to 64"),
            ("samples = 10", "shards = 2.5", 7, "propagator.shards", "2.5 is not allowed, it must be a whole number"),
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
            (
                "reference = \"mc\"",
                "reference = \"mc\"\nrestart = \"ever\"",
                4,
                "restart",
                "it must be \"never\" or \"on-failure\"",
            ),
            (
                "reference = \"mc\"",
                "reference = \"mc\"\nrestart = true",
                4,
                "restart",
                "true is not allowed, it must be \"never\" or \"on-failure\"",
            ),
            ("[[propagator]]", "[propagator]", 8, "propagator", "write [[propagator]] above each, in double brackets"),
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

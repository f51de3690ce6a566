//! `phasecloud validate`: checks launch, scenario and sweep files, and that the programs they name can be started.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use nodes::files::file_kind::FileKind;
use nodes::files::input::InputFile;
use nodes::files::map_file::MapFile;
use nodes::files::plain_number::plain;
use nodes::files::scenario_file::{self, AnyScenario};
use nodes::files::sweep::Sweep;

use crate::exit::BAD_INPUT;
use crate::plan::hosts::{Hosts, WITHOUT_HOSTS};
use crate::plan::launch_file::Launch;
use crate::plan::{built_in, programs, refusals};

/// Most combinations of a sweep that are checked, counted from the first.
const MOST_COMBINATIONS: usize = 10_000;
/// Most problems of a sweep that are printed one by one.
const FEW: usize = 5;

/// Checks files and prints for each what it is, or what is wrong with it.
pub fn run(files: &[PathBuf]) -> ExitCode {
    let mut code = ExitCode::SUCCESS;
    for file in files {
        match validate(file) {
            Ok(good) => say!("{}: good, {good}", file.display()),
            Err(problems) => {
                problems.iter().for_each(|problem| remark!("error: {problem}"));
                code = ExitCode::from(BAD_INPUT);
            }
        }
    }
    code
}

/// What a good file is, or all that is wrong with it.
fn validate(path: &Path) -> Result<String, Vec<String>> {
    if let Some(file) = built_in::launch_file(Some(path)) {
        return launch(&file, None);
    }
    let file = InputFile::read(path).map_err(|e| vec![built_in::with_names(e, path).to_string()])?;
    file.table().map_err(|e| vec![e.to_string()])?;
    match file.kind() {
        Some(FileKind::Scenario) => scenario(&file),
        Some(FileKind::Sweep) => sweep(&file),
        Some(FileKind::Map) => map(&file),
        Some(FileKind::Launch) => launch(&file, Some(path)),
        None => Err(vec![format!(
            "{}: has no key that says whether it is a launch, a scenario, a sweep or a map file, or keys of several kinds; a launch file \
             has [[propagator]] tables, a scenario file [orbit], [initial], [times] and [disposal], a sweep file scenario and [vary], a map file [quantity] as well",
            path.display()
        )]),
    }
}

fn scenario(file: &InputFile) -> Result<String, Vec<String>> {
    let described = |name: &str, times: &[f64], lines: Vec<String>| {
        let end = plain(times.last().copied().unwrap_or(0.0));
        format!("scenario {name} with {} snapshots to {end} yr\n  {}", times.len(), lines.join("\n  "))
    };
    Ok(match scenario_file::check_any(file).map_err(|e| vec![e.to_string()])? {
        AnyScenario::InPlane { scenario, .. } => {
            let mut lines = super::derived::of(&scenario.problem).lines();
            lines.extend(scenario.spread.map(super::derived::in_words));
            described(&scenario.name, &scenario.problem.times, lines)
        }
        AnyScenario::InSpace(scenario) => {
            described(&scenario.name, &scenario.times, super::derived::lines_in_space(&scenario))
        }
    })
}

fn sweep(file: &InputFile) -> Result<String, Vec<String>> {
    let sweep = Sweep::check(file).map_err(|e| vec![e.to_string()])?;
    let checked = sweep.len().min(MOST_COMBINATIONS);
    let wrong: Vec<String> = (0..checked).filter_map(|index| Some(sweep.scenario(index).err()?.to_string())).collect();
    let of =
        if checked < sweep.len() { format!("the first {checked} of {}", sweep.len()) } else { sweep.len().to_string() };
    if wrong.is_empty() {
        return Ok(format!("sweep of {of} scenarios over {}", sweep.keys().collect::<Vec<_>>().join(", ")));
    }
    let path = file.path().display();
    let summary = format!("{path}: {} of {of} combinations are impossible", wrong.len());
    Err(wrong.into_iter().take(FEW).chain([summary]).collect())
}

fn map(file: &InputFile) -> Result<String, Vec<String>> {
    let map = MapFile::check(file).map_err(|e| vec![e.to_string()])?;
    let folder = file.path().parent().unwrap_or(Path::new("."));
    let hosts = map.hosts.as_ref().map(|table| Hosts::check(file, table, folder)).transpose();
    let hosts = of_hosts(hosts.map_err(|e| vec![e.to_string()])?.as_ref()).map_err(|e| vec![e])?;
    Ok(format!("map of the {} at {} points over {}{hosts}", map.label(), map.sweep.len(), map.axes.join(" and ")))
}

/// What is to be said of other hosts: that the way to them needs a word of the user, or that this build cannot reach
/// them.
fn of_hosts(hosts: Option<&Hosts>) -> Result<String, String> {
    let Some(hosts) = hosts else { return Ok(String::new()) };
    let lacking = (!cfg!(feature = "hosts")).then(|| WITHOUT_HOSTS.to_owned());
    Ok(hosts.look()?.into_iter().chain(lacking).flat_map(|remark| ["; but ".to_owned(), remark]).collect())
}

/// A launch file; one that is built in has no path.
fn launch(file: &InputFile, path: Option<&Path>) -> Result<String, Vec<String>> {
    let launch = Launch::check(file, path, None).map_err(|e| vec![e.to_string()])?;
    let programs = programs::problems(file, &launch.cases).into_iter();
    let hosts = of_hosts(launch.hosts.as_ref());
    let problems = programs.chain(refusals::problems(file, &launch)).map(|problem| problem.to_string());
    let problems: Vec<String> = problems.chain(hosts.as_ref().err().cloned()).collect();
    if problems.is_empty() {
        let counted = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
        let (cases, scenarios) = (launch.cases.len(), launch.scenarios.len());
        let hosts = hosts.unwrap_or_default();
        return Ok(format!("{} on {}{hosts}", counted(cases, "case"), counted(scenarios, "scenario")));
    }
    Err(problems)
}

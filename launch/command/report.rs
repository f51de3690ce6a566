//! `phasecloud report`: makes the page and the figures of results folders anew.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use density::model::registry::Planar;
use figures::report::{self, FIGURES, PAGE, Subject};
use figures::scene::Scenario;
use nodes::files::scenario_file;
use nodes::services::recorder::description::in_plane;
use results::description::{self, Description};
use results::files::SCENARIOS;

use crate::exit::BAD_INPUT;
use crate::record::{checksums, manifest};
use clap::Args;

/// Arguments of `phasecloud report`.
#[derive(Debug, Args)]
#[command(after_help = "One folder: writes DIR/report.html and DIR/figures/*.svg, or only one page with --out.\n\
    Several folders: writes one page with one column per run to --out, or to report.html in the current folder.\n\n\
    Examples:\n  phasecloud report results/paper\n  phasecloud report results/before results/after --out compared.html")]
pub struct ReportArguments {
    /// Results folders
    #[arg(required = true, value_name = "DIR")]
    pub folders: Vec<PathBuf>,
    /// The page to write
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Makes the report of one folder, or lays several side by side.
pub fn run(arguments: &ReportArguments) -> ExitCode {
    if let Err(problem) =
        arguments.folders.iter().filter(|folder| folder.is_dir()).try_for_each(|folder| one_run(folder))
    {
        remark!("error: {problem}");
        return ExitCode::from(BAD_INPUT);
    }
    let made = match arguments.folders.as_slice() {
        [folder] if arguments.out.is_none() => {
            let sealed = |missing| manifest::seal(folder).map(|()| (folder.join(PAGE), missing));
            make(folder).and_then(sealed)
        }
        folders => {
            let page = arguments.out.clone().unwrap_or_else(|| PathBuf::from(PAGE));
            let inside = |problem| format!("{problem}, or leave out --out to make the folder's own page anew");
            outside_of_results(&page)
                .map_err(inside)
                .and_then(|()| side_by_side(folders, &page))
                .map(|missing| (page, missing))
        }
    };
    match made {
        Ok((page, missing)) => {
            say!("Report: {}", page.display());
            warn(&missing);
            ExitCode::SUCCESS
        }
        Err(problem) => {
            remark!("error: {problem}");
            ExitCode::from(BAD_INPUT)
        }
    }
}

/// Makes the report of a folder. Returns the figures that could not be drawn, and why.
///
/// # Errors
/// What is wrong with the folder.
pub fn make(folder: &Path) -> Result<Vec<String>, String> {
    report::write(&subject(folder)?).map_err(|e| e.to_string())
}

/// Refuses the folder of a sweep or of a service, which holds results folders.
///
/// # Errors
/// Which folder it could be instead.
pub fn one_run(folder: &Path) -> Result<(), String> {
    let is_results = |path: &Path| path.join(results::files::MOMENTS).is_file();
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let first = entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| is_results(path)).min();
    match first {
        Some(first) if !is_results(folder) => Err(format!(
            "{}: it holds the results folders of several scenarios; name one of them, as {}",
            folder.display(),
            first.display()
        )),
        _ => Ok(()),
    }
}

/// Removes a report that could not be completed.
pub fn remove(folder: &Path) {
    let _ = std::fs::remove_file(folder.join(PAGE));
    let _ = std::fs::remove_dir_all(folder.join(FIGURES));
}

/// Warns of the figures that are missing.
pub fn warn(missing: &[String]) {
    for figure in missing {
        remark!("warning: not drawn: {figure}");
    }
}

/// Refuses a new file in a results folder: it would not belong there, and the checksums would not fit any more.
///
/// # Errors
/// Where the file would lie.
pub fn outside_of_results(page: &Path) -> Result<(), String> {
    let folder = page.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = folder.canonicalize().map_err(|e| format!("{}: {e}", folder.display()))?;
    match folder.ancestors().find(|folder| checksums::is_sealed(folder)) {
        None => Ok(()),
        Some(sealed) => Err(format!(
            "{}: that is in the results folder {}, whose files are sealed; name a place outside",
            page.display(),
            sealed.display()
        )),
    }
}

fn side_by_side(folders: &[PathBuf], page: &Path) -> Result<Vec<String>, String> {
    let subjects: Vec<Subject> = folders.iter().map(|folder| subject(folder)).collect::<Result<_, _>>()?;
    report::write_side_by_side(&subjects, page).map_err(|e| e.to_string())
}

/// The folder with its scenarios, in the order of their names.
fn subject(folder: &Path) -> Result<Subject, String> {
    let mut described = description::read(folder).map_err(|e| e.to_string())?;
    described.sort_by_key(|description| file_name(&description.name));
    let scenarios = match described.is_empty() {
        true => scenarios_in_plane(folder)?,
        false => described.into_iter().map(|description| scenario(folder, description)).collect::<Result<_, _>>()?,
    };
    let name =
        folder.file_name().map_or_else(|| folder.display().to_string(), |name| name.to_string_lossy().into_owned());
    Ok(Subject { folder: folder.into(), name, scenarios })
}

fn file_name(scenario: &str) -> String {
    format!("{scenario}.toml")
}

/// A scenario with its problem, if its model is one in the plane and all its parameters are certain.
fn scenario(folder: &Path, description: Description) -> Result<Scenario, String> {
    let file = folder.join(SCENARIOS).join(file_name(&description.name));
    let is_planar = Planar::ALL.iter().any(|(name, _)| *name == description.model);
    let plane = is_planar.then(|| scenario_file::load(&file).map_err(|e| e.to_string())).transpose()?;
    let certain = plane.filter(|content| content.spread.is_none());
    Ok(Scenario { description, plane: certain.map(|content| content.problem) })
}

/// The scenarios of a folder of an earlier version, which has no descriptions: all are in the plane.
fn scenarios_in_plane(folder: &Path) -> Result<Vec<Scenario>, String> {
    let scenarios = folder.join(SCENARIOS);
    let unreadable = |e: std::io::Error| {
        format!("{}: cannot be read ({e}); name a folder that `phasecloud run` wrote", scenarios.display())
    };
    let entries = std::fs::read_dir(&scenarios).and_then(Iterator::collect::<Result<Vec<_>, _>>).map_err(unreadable)?;
    let mut files: Vec<PathBuf> = entries.into_iter().map(|entry| entry.path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "toml"));
    files.sort();
    let load = |file: &PathBuf| {
        let content = scenario_file::load(file).map_err(|e| e.to_string())?;
        Ok(Scenario { description: in_plane(&content.name, &content.problem), plane: Some(content.problem) })
    };
    files.iter().map(load).collect()
}

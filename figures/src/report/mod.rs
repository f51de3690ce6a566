//! The report: one page that loads nothing from elsewhere, and the figures as files beside it.

mod answer;
mod blocks;
mod numbers;
mod page;
mod run;
mod tables;

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::atlas::{self, Group};
use crate::densities::{self, Densities};
use crate::scene::{Scenario, Scene};
use results::{FolderError, Results};

/// Name of the page in a results folder.
pub const PAGE: &str = "report.html";
/// Name of the folder of the figures in a results folder.
pub const FIGURES: &str = "figures";

/// A results folder to be reported on, and its scenarios in the order of the report.
#[derive(Debug, Clone)]
pub struct Subject {
    /// The folder.
    pub folder: PathBuf,
    /// Its name where several runs are shown.
    pub name: String,
    /// Its scenarios.
    pub scenarios: Vec<Scenario>,
}

/// A run with all its figures.
struct Drawn<'a> {
    name: &'a str,
    results: &'a Results,
    scenes: Vec<DrawnScene<'a>>,
    across: Group,
}

/// A scenario with all its figures.
struct DrawnScene<'a> {
    /// The scenario in its first pair of variables.
    scene: Scene<'a>,
    /// The same in its other pairs.
    further: Vec<Scene<'a>>,
    groups: Vec<Group>,
}

impl<'a> Drawn<'a> {
    fn new(subject: &'a Subject, (results, densities): &'a (Results, Densities)) -> Self {
        let several = subject.scenarios.len() > 1;
        let scene = |scenario: &'a Scenario, pair| Scene::new(scenario, results, densities, pair, several);
        let scenes: Vec<Scene<'a>> = subject.scenarios.iter().map(|scenario| scene(scenario, 0)).collect();
        let across = atlas::of_run(&scenes);
        let scenes = scenes.into_par_iter().zip(&subject.scenarios).map(|(main, scenario)| {
            let further: Vec<Scene<'a>> =
                (1..scenario.description.pairs().count()).map(|pair| scene(scenario, pair)).collect();
            let mut groups = atlas::of_scene(&main);
            groups.extend(further.iter().flat_map(atlas::of_pair));
            DrawnScene { scene: main, further, groups }
        });
        Self { name: &subject.name, results, scenes: scenes.collect(), across }
    }

    fn groups(&self) -> impl Iterator<Item = &Group> {
        self.scenes.iter().flat_map(|drawn| &drawn.groups).chain([&self.across])
    }
}

/// Writes the figures and the page of a results folder into it. Returns which figures could not be drawn, and why.
///
/// # Errors
/// [`FolderError`] names the file that is missing, damaged or cannot be written.
pub fn write(subject: &Subject) -> Result<Vec<String>, FolderError> {
    let read = read(subject)?;
    let drawn = Drawn::new(subject, &read);
    let folder = subject.folder.join(FIGURES);
    std::fs::create_dir_all(&folder).map_err(|e| FolderError::new(&folder, e))?;
    let figures: Vec<_> = drawn.groups().flat_map(|group| &group.figures).collect();
    figures
        .par_iter()
        .try_for_each(|figure| write_file(&folder.join(format!("{}.svg", figure.name)), &figure.to_file()))?;
    write_file(&subject.folder.join(PAGE), &page::of_one(&drawn).into_string())?;
    Ok(missing(&drawn))
}

/// Writes one page that shows several runs side by side. Returns which figures could not be drawn, and why.
///
/// # Errors
/// [`FolderError`] names the file that is missing, damaged or cannot be written.
pub fn write_side_by_side(subjects: &[Subject], page: &Path) -> Result<Vec<String>, FolderError> {
    let read: Vec<_> = subjects.iter().map(read).collect::<Result<_, _>>()?;
    let drawn: Vec<Drawn<'_>> = subjects.iter().zip(&read).map(|(subject, read)| Drawn::new(subject, read)).collect();
    write_file(page, &page::of_several(&drawn).into_string())?;
    Ok(drawn.iter().flat_map(missing).collect())
}

/// The tables and the densities of a folder.
fn read(subject: &Subject) -> Result<(Results, Densities), FolderError> {
    let results = Results::read(&subject.folder)?;
    let described = subject.scenarios.iter().map(|scenario| &scenario.description);
    let densities = densities::read(&subject.folder, described, &results.moments)?;
    Ok((results, densities))
}

fn missing(drawn: &Drawn<'_>) -> Vec<String> {
    drawn.groups().flat_map(|group| &group.missing).cloned().collect()
}

/// Writes a file either whole or not at all: if the disk is full, a file that existed before stays as it was.
fn write_file(path: &Path, text: &str) -> Result<(), FolderError> {
    let path = &path.canonicalize().unwrap_or_else(|_| path.into()); // the file that a link leads to, not the link
    if path.exists() && !path.is_file() {
        return std::fs::write(path, text).map_err(|e| FolderError::new(path, e)); // a pipe, a device
    }
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".partial");
    let draft = path.with_file_name(name);
    let written = std::fs::write(&draft, text).and_then(|()| std::fs::rename(&draft, path));
    written.map_err(|e| {
        let _ = std::fs::remove_file(&draft);
        FolderError::new(path, e)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_cannot_be_written_leaves_no_part_of_it_and_the_old_one_as_it_was() {
        let folder = std::env::temp_dir().join(format!("phasecloud-page-{}", std::process::id()));
        std::fs::create_dir(&folder).unwrap();
        let page = folder.join(PAGE);
        write_file(&page, "old").unwrap();
        std::os::unix::fs::symlink("/dev/full", folder.join("report.html.partial")).unwrap();
        let error = write_file(&page, "new").unwrap_err();
        assert!(error.to_string().contains("report.html: No space left on device"), "{error}");
        assert_eq!(std::fs::read_to_string(&page).unwrap(), "old");
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}

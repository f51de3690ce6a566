//! The report: one page without any reference to the outside, and the figures as files beside it.

mod blocks;
mod numbers;
mod page;
mod run;
mod tables;

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::atlas::{self, Group};
use crate::results::{FolderError, Results};
use crate::scene::{Scenario, Scene};

/// Name of the page in a results folder.
pub const PAGE: &str = "report.html";
/// Name of the folder of the figures in a results folder.
pub const FIGURES: &str = "figures";

/// A results folder to report on, and the science of its scenarios, in the order of the report.
#[derive(Debug, Clone)]
pub struct Subject {
    /// The folder.
    pub folder: PathBuf,
    /// What it is called where several runs are shown.
    pub name: String,
    /// Its scenarios.
    pub scenarios: Vec<Scenario>,
}

/// A run with all its figures.
struct Drawn<'a> {
    name: &'a str,
    results: &'a Results,
    scenes: Vec<(Scene<'a>, Vec<Group>)>,
    across: Group,
}

impl<'a> Drawn<'a> {
    fn new(subject: &'a Subject, results: &'a Results) -> Self {
        let several = subject.scenarios.len() > 1;
        let scenes: Vec<Scene<'a>> =
            subject.scenarios.iter().map(|scenario| Scene::new(scenario, results, several)).collect();
        let across = atlas::of_run(&scenes);
        let scenes = scenes.into_par_iter().map(|scene| {
            let groups = atlas::of_scene(&scene);
            (scene, groups)
        });
        Self { name: &subject.name, results, scenes: scenes.collect(), across }
    }

    fn groups(&self) -> impl Iterator<Item = &Group> {
        self.scenes.iter().flat_map(|(_, groups)| groups).chain([&self.across])
    }
}

/// Writes the figures and the page of a results folder into it. Returns which figures could not be drawn, and why.
///
/// # Errors
/// [`FolderError`] names the file that is missing, damaged or cannot be written.
pub fn write(subject: &Subject) -> Result<Vec<String>, FolderError> {
    let results = Results::read(&subject.folder)?;
    let drawn = Drawn::new(subject, &results);
    let folder = subject.folder.join(FIGURES);
    std::fs::create_dir_all(&folder).map_err(|e| FolderError::new(&folder, e))?;
    let figures: Vec<_> = drawn.groups().flat_map(|group| &group.figures).collect();
    figures
        .par_iter()
        .try_for_each(|figure| write_file(&folder.join(format!("{}.svg", figure.name)), &figure.to_file()))?;
    write_file(&subject.folder.join(PAGE), &page::of_one(&drawn).into_string())?;
    Ok(missing(&drawn))
}

/// Writes one page that lays several runs side by side. Returns which figures could not be drawn, and why.
///
/// # Errors
/// [`FolderError`] names the file that is missing, damaged or cannot be written.
pub fn write_side_by_side(subjects: &[Subject], page: &Path) -> Result<Vec<String>, FolderError> {
    let results: Vec<Results> =
        subjects.iter().map(|subject| Results::read(&subject.folder)).collect::<Result<_, _>>()?;
    let drawn: Vec<Drawn<'_>> =
        subjects.iter().zip(&results).map(|(subject, results)| Drawn::new(subject, results)).collect();
    write_file(page, &page::of_several(&drawn).into_string())?;
    Ok(drawn.iter().flat_map(missing).collect())
}

fn missing(drawn: &Drawn<'_>) -> Vec<String> {
    drawn.groups().flat_map(|group| &group.missing).cloned().collect()
}

fn write_file(path: &Path, text: &str) -> Result<(), FolderError> {
    std::fs::write(path, text).map_err(|e| FolderError::new(path, e))
}

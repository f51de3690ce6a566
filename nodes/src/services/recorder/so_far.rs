//! The results of a scenario as far as they have come, for whoever watches a run.

use std::fs;
use std::path::Path;

use kit::assignment::Assignment;
use kit::failure::Failure;
use kit::screen::{Screened, screen};
use messages::port::Message;
use messages::topic::{Comparison, Density, Passage, Scenario};
use results::FolderError;
use results::files::SCENARIOS;

use super::Recording;
use super::tables::{scenario_text, write_tables};
use crate::services::roster::Roster;

/// The messages of one scenario that have arrived. Messages that the recorder would refuse are passed over: the
/// recorder says why.
#[derive(Debug)]
pub struct SoFar {
    run_id: u64,
    recording: Recording,
    roster: Roster,
}

impl SoFar {
    /// Nothing yet of the scenario that `message` asks for.
    ///
    /// # Errors
    /// [`Failure`] if the message does not describe a scenario.
    pub fn new(message: &Message<Scenario>) -> Result<Self, Failure> {
        let recording = Recording::new(Assignment::read(message)?);
        Ok(Self { run_id: message.header().run_id, recording, roster: Roster::default() })
    }

    /// Names the run.
    pub fn run_id(&self) -> u64 {
        self.run_id
    }

    /// Position of the scenario in the run.
    pub fn scenario(&self) -> u32 {
        self.recording.assignment.description.scenario
    }

    fn accepts<T: Screened>(&self, message: &Message<T>) -> bool {
        screen(self.run_id, message).is_ok()
    }

    /// Adds a density.
    pub fn take_density(&mut self, message: &Message<Density>) {
        if self.accepts(message) {
            self.recording.take_density(*message.header(), message.items());
        }
    }

    /// Adds a first-passage curve.
    pub fn take_passage(&mut self, message: &Message<Passage>) {
        if self.accepts(message) {
            self.recording.take_passage(*message.header(), message.items());
        }
    }

    /// Adds a comparison.
    pub fn take_comparison(&mut self, message: &Message<Comparison>) {
        if self.accepts(message) {
            self.recording.take_comparison(*message.header(), message.items());
        }
    }

    /// Sets which cases take part, and which have failed.
    pub fn set_roster(&mut self, roster: Roster) {
        self.roster = roster;
    }

    /// The scenario's name.
    pub fn name(&self) -> &str {
        &self.recording.assignment.description.name
    }

    /// Which cases take part, and which have failed.
    pub fn roster(&self) -> &Roster {
        &self.roster
    }

    /// The labels of the cases of which all snapshots have arrived.
    pub fn complete_cases(&self) -> Vec<&str> {
        let labels = self.roster.cases.iter().map(|(label, _)| label.as_str());
        labels.filter(|label| self.recording.case(label).is_some()).collect()
    }

    /// Writes the tables and the densities of these cases into an empty folder. Methods are judged against `tolerance`.
    ///
    /// # Errors
    /// What cannot be written.
    pub fn write(&self, folder: &Path, tolerance: f64) -> Result<(), FolderError> {
        write_tables(&self.recording, &self.roster, folder, tolerance)?;
        let scenarios = folder.join(SCENARIOS);
        let file = scenarios.join(format!("{}.toml", self.name()));
        fs::create_dir_all(&scenarios).map_err(|e| FolderError::new(&scenarios, e))?;
        fs::write(&file, scenario_text(&self.recording.assignment)).map_err(|e| FolderError::new(&file, e))
    }
}

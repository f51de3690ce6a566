//! What a page about a run under way shows, from what the topics say.

use messages::observe::Observer;
use messages::port::{Inlet, PortError};
use messages::topic::{Comparison, Density, Passage, Roster as RosterTopic, Scenario};
use nodes::services::recorder::SoFar;
use nodes::services::roster::Roster;
use serde_json::{Value, json};

use super::partial;
use super::server::Server;
use crate::live::progress::{NodeState, Progress};

/// Follows the topics of a run for a page.
pub struct Feed<'a> {
    server: &'a Server,
    title: String,
    scenarios: Inlet<Scenario>,
    rosters: Inlet<RosterTopic>,
    densities: Inlet<Density>,
    passages: Inlet<Passage>,
    comparisons: Inlet<Comparison>,
    /// The last roster, which may come before the scenario.
    roster: Roster,
    so_far: Option<SoFar>,
    /// The scenario and the number of its cases that the report shows.
    reported: (String, usize),
    problem: Option<String>,
}

impl<'a> Feed<'a> {
    /// Subscribes to the topics of the run called `title`.
    ///
    /// # Errors
    /// [`PortError`] if a topic cannot be read.
    pub fn open(observer: &Observer, server: &'a Server, title: String) -> Result<Self, PortError> {
        Ok(Self {
            server,
            title,
            scenarios: observer.inlet()?,
            rosters: observer.inlet()?,
            densities: observer.inlet()?,
            passages: observer.inlet()?,
            comparisons: observer.inlet()?,
            roster: Roster::default(),
            so_far: None,
            reported: (String::new(), 0),
            problem: None,
        })
    }

    /// Takes in what has arrived, and shows it.
    ///
    /// # Errors
    /// [`PortError`] if a topic cannot be read.
    pub fn update(&mut self, progress: Option<&Progress>) -> Result<(), PortError> {
        self.begin()?;
        while let Some(message) = self.densities.receive()? {
            self.follow(message.header().scenario)?;
            self.so_far.iter_mut().for_each(|so_far| so_far.take_density(&message));
        }
        while let Some(message) = self.passages.receive()? {
            self.follow(message.header().scenario)?;
            self.so_far.iter_mut().for_each(|so_far| so_far.take_passage(&message));
        }
        while let Some(message) = self.comparisons.receive()? {
            self.follow(message.header().scenario)?;
            self.so_far.iter_mut().for_each(|so_far| so_far.take_comparison(&message));
        }
        while let Some(message) = self.rosters.receive()? {
            self.roster = Roster::new(message.header(), message.items());
            self.so_far.iter_mut().for_each(|so_far| so_far.set_roster(self.roster.clone()));
        }
        self.report();
        self.server.set_state(self.state(progress));
        Ok(())
    }

    /// A scenario is asked for before anything is said of it: if something is, the question has arrived.
    fn follow(&mut self, scenario: u32) -> Result<(), PortError> {
        match &self.so_far {
            Some(so_far) if so_far.scenario() >= scenario => Ok(()),
            _ => self.begin(),
        }
    }

    fn begin(&mut self) -> Result<(), PortError> {
        while let Some(message) = self.scenarios.receive()? {
            // Whoever cannot use a scenario says so on the status topic.
            if let Ok(mut begun) = SoFar::new(&message) {
                begun.set_roster(self.roster.clone());
                self.so_far = Some(begun);
            }
        }
        Ok(())
    }

    /// Makes the report anew if a further case has arrived.
    fn report(&mut self) {
        let Some(so_far) = &self.so_far else { return };
        let arrived = (so_far.name().to_owned(), so_far.complete_cases().len());
        if arrived.1 == 0 || arrived == self.reported {
            return;
        }
        match partial::report(so_far) {
            Ok(page) => self.server.set_report(page),
            Err(problem) => self.problem = Some(problem),
        }
        self.reported = arrived;
    }

    fn state(&self, progress: Option<&Progress>) -> Value {
        let node =
            |node: &NodeState| json!({"name": node.shown(), "phase": node.phase, "done": node.done, "of": node.of});
        let failures = self.so_far.iter().flat_map(|so_far| &so_far.roster().reasons);
        json!({
            "title": self.title,
            "scenario": self.so_far.as_ref().map(SoFar::name),
            "nodes": progress.map(|progress| progress.nodes().iter().map(node).collect::<Vec<_>>()),
            "failures": failures.map(|(case, why)| format!("{case}: {why}")).collect::<Vec<_>>(),
            "problem": self.problem,
            "over": false,
        })
    }
}

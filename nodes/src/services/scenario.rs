//! The scenario node: publishes one problem after the other, each when the recorder has finished the previous one.

use std::path::PathBuf;

use messages::port::Inlet;
use messages::report::{Event, Report};
use messages::text::unpack;
use messages::topic::{Request, Scenario, Status};

use crate::assigning::Assigning;
use crate::files::scenario_file::{self, AnyScenario};
use crate::files::sweep::Sweep;
use crate::services::request::read_request;
use crate::services::roomy::Roomy;
use kit::failure::Failure;
use kit::session::Session;

/// What the scenario node publishes.
#[derive(Debug, Clone)]
pub struct ScenarioSettings {
    /// Where the scenarios come from.
    pub source: Source,
    /// Position in the run of the first one to publish; those before it are done.
    pub first: u32,
    /// Bins of the comparison grid, in `phi` and `e`.
    pub bins: (usize, usize),
    /// Most snapshots of a scenario that the run has room for.
    pub most_snapshots: usize,
}

/// Where scenarios come from.
#[derive(Debug, Clone)]
pub enum Source {
    /// These files, in order. One that cannot be done ends the run.
    Files(Vec<PathBuf>),
    /// A sweep file. A scenario that cannot be done is reported and left out.
    Sweep(PathBuf),
    /// Requests that arrive. One that cannot be done is reported.
    Requests,
}

/// Publishes all scenarios, then stays until asked to stop.
///
/// # Errors
/// [`Failure::Stopped`] is the normal end.
pub fn run(session: &Session, settings: &ScenarioSettings) -> Result<(), Failure> {
    let mut publisher = Publisher {
        session,
        reports: session.domain.inlet()?,
        scenarios: None,
        bins: settings.bins,
        most_snapshots: settings.most_snapshots,
        first: settings.first,
        position: 0,
        count: 0,
        most: None,
    };
    match &settings.source {
        Source::Files(files) => {
            publisher.count = files.len() as u32;
            publisher.most = Some(publisher.count);
            session.ready()?;
            for file in files {
                let scenario = scenario_file::load_cloud(file).map_err(|e| Failure::Refused(e.to_string()))?;
                publisher.publish(&scenario, None)?;
            }
        }
        Source::Sweep(file) => {
            let sweep = Sweep::load(file).map_err(|e| Failure::Refused(e.to_string()))?;
            publisher.most = Some(sweep.len() as u32);
            session.ready()?;
            for index in 0..sweep.len() {
                let scenario = sweep.scenario(index).map_err(|e| Failure::Refused(e.to_string()));
                let published = scenario.and_then(|scenario| {
                    let combination = |why: Failure| why.about(&sweep.combination(index));
                    publisher.publish(&scenario, None).map_err(combination)
                });
                publisher.report_refusal(published, &combination_name(index), None)?;
            }
        }
        Source::Requests => publisher.serve_requests()?,
    }
    session.report(publisher.position, Event::Total)?;
    publisher.stay()
}

/// The name of a combination of a sweep in the report that it is refused.
pub fn combination_name(index: usize) -> String {
    format!("scenario {index} of the sweep")
}

struct Publisher<'a> {
    session: &'a Session,
    reports: Inlet<Status>,
    scenarios: Option<Roomy<Scenario>>,
    bins: (usize, usize),
    most_snapshots: usize,
    first: u32,
    /// Position of the next scenario.
    position: u32,
    /// Scenarios in the run; 0 if the number is not known.
    count: u32,
    /// The most that there can be, if that is known: combinations of a sweep may turn out to be impossible.
    most: Option<u32>,
}

impl Publisher<'_> {
    /// Publishes a scenario, which the request of that number may have asked for, unless that is done already, and
    /// waits until it is recorded.
    fn publish(&mut self, scenario: &AnyScenario, request: Option<u32>) -> Result<(), Failure> {
        let snapshots = scenario.times().len();
        if snapshots > self.most_snapshots {
            return Err(Failure::Refused(format!(
                "it has {snapshots} snapshots, there is room for {}; start the service with a larger --most-snapshots",
                self.most_snapshots
            )));
        }
        let position = self.position;
        let assigning = Assigning { run_id: self.session.run_id, place: (position, self.count), bins: self.bins };
        let (name, assignment) = (scenario.name(), assigning.assignment(scenario)?);
        self.position += 1;
        if position < self.first {
            return Ok(());
        }
        let (header, items) = assignment.to_parts()?;
        let outlet = Roomy::with_room(&mut self.scenarios, &self.session.domain, items.len())?;
        outlet.send_items(header, &items)?;
        self.session.report(position, Event::Accepted { name: name.into(), of: self.most, request })?;
        while !is_recorded(&self.reports, position)? {
            self.session.wait(&[&self.reports, outlet])?;
        }
        Ok(())
    }

    /// Reports that the scenario `name` cannot be done, if so; the node then goes on with the next one.
    fn report_refusal(&self, published: Result<(), Failure>, name: &str, request: Option<u32>) -> Result<(), Failure> {
        match published {
            Err(failure @ (Failure::Stopped | Failure::Port(_))) => Err(failure),
            Err(failure) => {
                let refused = Event::Refused { name: name.into(), why: failure.to_string(), request };
                self.session.report(self.position, refused)
            }
            Ok(()) => Ok(()),
        }
    }

    fn serve_requests(&mut self) -> Result<(), Failure> {
        let requests = self.session.domain.inlet::<Request>()?;
        self.session.ready()?;
        self.position = self.first;
        loop {
            while let Some(request) = requests.receive()? {
                let (name, number) = (unpack(&request.header().name), Some(request.header().scenario));
                let scenario = read_request(request.header(), request.items());
                drop(request);
                let published = scenario.and_then(|scenario| self.publish(&scenario, number));
                self.report_refusal(published, &name, number)?;
            }
            while self.reports.receive()?.is_some() {}
            match &self.scenarios {
                Some(scenarios) => self.session.wait(&[&requests, &self.reports, &scenarios.outlet])?,
                None => self.session.wait(&[&requests, &self.reports])?,
            }
        }
    }

    /// Keeps the last scenario for late readers until asked to stop.
    fn stay(self) -> Result<(), Failure> {
        loop {
            while self.reports.receive()?.is_some() {}
            match &self.scenarios {
                Some(scenarios) => self.session.wait(&[&self.reports, &scenarios.outlet])?,
                None => self.session.wait(&[&self.reports])?,
            }
        }
    }
}

/// Whether the recorder has reported that it is done with `scenario`.
fn is_recorded(reports: &Inlet<Status>, scenario: u32) -> Result<bool, Failure> {
    while let Some(report) = reports.receive()? {
        let report = Report::from_parts(report.header(), report.items());
        if report.is_ok_and(|report| report.is_end_of(scenario)) {
            return Ok(true);
        }
    }
    Ok(false)
}

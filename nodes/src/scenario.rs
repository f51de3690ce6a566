//! The scenario node: publishes one problem after the other, the next when the recorder has finished the last.

use std::path::PathBuf;

use density::flow::Flow;
use density::grid::comparison_grids;
use density::problem::Problem;
use messages::layout::phase;
use messages::port::Inlet;
use messages::text::unpack;
use messages::topic::{Scenario, Status};

use crate::assignment::Assignment;
use crate::failure::Failure;
use crate::roomy::Roomy;
use crate::scenario_file;
use crate::session::Session;

/// The recorder's node name: its `done` ends a scenario.
pub const RECORDER: &str = "recorder";

/// What the scenario node publishes.
#[derive(Debug, Clone)]
pub struct Settings {
    /// The scenario files, in order.
    pub files: Vec<PathBuf>,
    /// Position in the run of the first one to publish; those before it are done.
    pub first: u32,
    /// Bins of the comparison grid, in `phi` and `e`.
    pub bins: (usize, usize),
}

/// Publishes all scenarios, then stays until asked to stop.
///
/// # Errors
/// [`Failure::Stopped`] is the normal end.
pub fn run(session: &Session, settings: &Settings) -> Result<(), Failure> {
    let reports = session.domain.inlet::<Status>()?;
    let mut slot: Option<Roomy<Scenario>> = None;
    session.ready()?;
    for (position, file) in (0..).zip(&settings.files).skip(settings.first as usize) {
        let scenario = scenario_file::load(file).map_err(|e| Failure::Refused(e.to_string()))?;
        let (header, items) =
            assignment(session.run_id, position, settings, &scenario.name, scenario.problem)?.to_parts();
        let outlet = Roomy::with_room(&mut slot, &session.domain, items.len())?;
        outlet.send_items(header, &items)?;
        while !is_recorded(&reports, position)? {
            session.wait(&[&reports, outlet])?;
        }
    }
    loop {
        while reports.receive()?.is_some() {}
        match &slot {
            Some(scenarios) => session.wait(&[&reports, &scenarios.outlet])?,
            None => session.wait(&[&reports])?,
        }
    }
}

/// Whether the recorder has reported that it is done with `scenario`.
fn is_recorded(reports: &Inlet<Status>, scenario: u32) -> Result<bool, Failure> {
    while let Some(report) = reports.receive()? {
        let header = report.header();
        if header.phase == phase::DONE && header.scenario == scenario && unpack(&header.node) == RECORDER {
            return Ok(true);
        }
    }
    Ok(false)
}

fn assignment(
    run_id: u64,
    position: u32,
    settings: &Settings,
    name: &str,
    problem: Problem,
) -> Result<Assignment, Failure> {
    let grids = comparison_grids(&problem, &Flow::new(problem.force), settings.bins.0, settings.bins.1)?;
    Ok(Assignment {
        run_id,
        name: name.into(),
        scenario: position,
        scenarios: settings.files.len() as u32,
        problem,
        grids,
    })
}

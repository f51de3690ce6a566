//! The scenario node: publishes one problem after the other, the next when the recorder has finished the last.

use std::path::PathBuf;

use density::flow::Flow;
use density::grid::comparison_grids;
use density::problem::Problem;
use messages::layout::phase;
use messages::text::unpack;
use messages::topic::{Scenario, Status};

use crate::assignment::Assignment;
use crate::failure::Failure;
use crate::scenario_file;
use crate::screen::receive;
use crate::session::Session;

/// The recorder's node name: its `done` ends a scenario.
pub const RECORDER: &str = "recorder";

/// What the scenario node publishes.
#[derive(Debug, Clone)]
pub struct Settings {
    /// The scenario files, in order.
    pub files: Vec<PathBuf>,
    /// Bins of the comparison grid, in `phi` and `e`.
    pub bins: (usize, usize),
}

/// Publishes all scenarios until asked to stop.
///
/// # Errors
/// [`Failure::Stopped`] is the normal end.
pub fn run(session: &Session, settings: &Settings) -> Result<(), Failure> {
    let assignments = settings
        .files
        .iter()
        .enumerate()
        .map(|(position, file)| {
            let scenario = scenario_file::load(file).map_err(|e| Failure::Refused(e.to_string()))?;
            assignment(session.run_id, position, settings, &scenario.name, scenario.problem)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let longest = assignments.iter().map(|a| a.to_parts().1.len()).max().unwrap_or(0);
    let outlet = session.domain.outlet::<Scenario>(longest)?;
    let reports = session.domain.inlet::<Status>()?;
    session.ready()?;
    for assignment in &assignments {
        let (header, items) = assignment.to_parts();
        outlet.send_items(header, &items)?;
        let mut finished = false;
        while !finished {
            session.wait(&[&reports, &outlet])?;
            while let Some(report) = receive(session, &reports)? {
                let header = report.header();
                finished |= header.phase == phase::DONE
                    && header.scenario == assignment.scenario
                    && unpack(&header.node) == RECORDER;
            }
        }
    }
    loop {
        session.wait(&[&outlet])?;
    }
}

fn assignment(
    run_id: u64,
    position: usize,
    settings: &Settings,
    name: &str,
    problem: Problem,
) -> Result<Assignment, Failure> {
    let grids = comparison_grids(&problem, &Flow::new(problem.force), settings.bins.0, settings.bins.1)?;
    Ok(Assignment {
        run_id,
        name: name.into(),
        scenario: position as u32,
        scenarios: settings.files.len() as u32,
        problem,
        grids,
    })
}

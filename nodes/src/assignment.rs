//! The problem as it arrives on the scenario topic, checked and in the terms of science; and the way back.

use density::dynamics::Force;
use density::first_passage::curve_times;
use density::grid::{Axis, Grid};
use density::problem::{InitialGaussian, Problem};
use messages::layout::{MOST_SNAPSHOTS, PASSAGE_TIMES, SCENARIO_COLUMNS, ScenarioHeader};
use messages::port::Message;
use messages::text::{pack, unpack};
use messages::topic::Scenario;

use crate::failure::Failure;
use crate::input::{PLAIN_NAME, is_plain_name};
use crate::scenario_file::{self, ScenarioFile};
use crate::screen::MOST_BINS;

/// A scenario to work on.
#[derive(Debug, Clone, PartialEq)]
pub struct Assignment {
    /// Names the run.
    pub run_id: u64,
    /// The scenario's name.
    pub name: String,
    /// Position of the scenario in the run.
    pub scenario: u32,
    /// Scenarios in the run.
    pub scenarios: u32,
    /// The problem.
    pub problem: Problem,
    /// The common comparison grid of each snapshot.
    pub grids: Vec<Grid>,
}

impl Assignment {
    /// Reads a message.
    ///
    /// # Errors
    /// [`Failure::Refused`] says which field is wrong.
    pub fn read(message: &Message<Scenario>) -> Result<Self, Failure> {
        Self::from_parts(message.header(), message.items()).map_err(|why| Failure::Refused(format!("scenario: {why}")))
    }

    /// The times of its first-passage curves \[yr\].
    pub fn passage_times(&self) -> Vec<f64> {
        curve_times(self.problem.times.last().copied().unwrap_or(0.0), PASSAGE_TIMES)
    }

    /// Reads a header and its items.
    ///
    /// # Errors
    /// Which field is wrong.
    pub(crate) fn from_parts(header: &ScenarioHeader, items: &[f64]) -> Result<Self, String> {
        let snapshots = header.snapshots as usize;
        if !(1..=MOST_SNAPSHOTS).contains(&snapshots) || items.len() != snapshots * SCENARIO_COLUMNS {
            return Err(format!("{} numbers for {snapshots} snapshots of at most {MOST_SNAPSHOTS}", items.len()));
        }
        if ![header.phi_bins, header.e_bins].iter().all(|bins| (1..=MOST_BINS).contains(&(*bins as usize))) {
            return Err(format!("a grid of {} x {} bins", header.phi_bins, header.e_bins));
        }
        if header.scenarios > 0 && header.scenario >= header.scenarios {
            return Err(format!("scenario {} of {}", header.scenario, header.scenarios));
        }
        if !items.iter().all(|value| value.is_finite()) {
            return Err("a number that is not finite".into());
        }
        let rows = || items.chunks_exact(SCENARIO_COLUMNS);
        let grid = |row: &[f64]| Grid {
            phi: Axis { low: row[1], high: row[2], bins: header.phi_bins as usize },
            e: Axis { low: row[3], high: row[4], bins: header.e_bins as usize },
        };
        if !rows().all(|row| row[1] < row[2] && row[3] < row[4]) {
            return Err("grids without extent".into());
        }
        Ok(Self {
            run_id: header.run_id,
            name: unpack(&header.name),
            scenario: header.scenario,
            scenarios: header.scenarios,
            problem: problem(header, rows().map(|row| row[0]).collect())?,
            grids: rows().map(grid).collect(),
        })
    }

    /// The message's header and items.
    pub fn to_parts(&self) -> (ScenarioHeader, Vec<f64>) {
        let Problem { model: force, initial, times, critical_e } = &self.problem;
        let header = ScenarioHeader {
            run_id: self.run_id,
            radiation: force.radiation,
            oblateness: force.oblateness,
            mean_phi: initial.mean_phi,
            mean_e: initial.mean_e,
            sigma_phi: initial.sigma_phi,
            sigma_e: initial.sigma_e,
            critical_e: *critical_e,
            scenario: self.scenario,
            scenarios: self.scenarios,
            snapshots: times.len() as u32,
            reserved: 0,
            phi_bins: self.grids.first().map_or(0, |grid| grid.phi.bins as u32),
            e_bins: self.grids.first().map_or(0, |grid| grid.e.bins as u32),
            name: pack(&self.name),
        };
        let items = times
            .iter()
            .zip(&self.grids)
            .flat_map(|(&time, grid)| [time, grid.phi.low, grid.phi.high, grid.e.low, grid.e.high])
            .collect();
        (header, items)
    }
}

/// The problem that a header states, with snapshots at `times`.
///
/// # Errors
/// What is wrong, by the key that a scenario file has for it.
fn problem(header: &ScenarioHeader, times: Vec<f64>) -> Result<Problem, String> {
    let force = Force { radiation: header.radiation, oblateness: header.oblateness };
    let initial = InitialGaussian {
        mean_phi: header.mean_phi,
        mean_e: header.mean_e,
        sigma_phi: header.sigma_phi,
        sigma_e: header.sigma_e,
    };
    let problem = Problem::new(force, initial, times, header.critical_e);
    problem.map_err(|error| format!("{}: {}", scenario_file::key(error.field), error.problem()))
}

/// The problem that a request is about.
///
/// # Errors
/// [`Failure::Refused`] says what is wrong.
pub fn read_request(header: &ScenarioHeader, times: &[f64]) -> Result<ScenarioFile, Failure> {
    let name = unpack(&header.name);
    if !is_plain_name(&name) {
        return Err(Failure::Refused(format!("a request's name must be plain: {PLAIN_NAME}")));
    }
    let refused = |why: &str| Failure::Refused(format!("request {name}: {why}"));
    if !scenario_file::is_right_number_of_times(times.len()) {
        return Err(refused(&format!("times.at: must be 2 to {MOST_SNAPSHOTS} times")));
    }
    let problem = problem(header, times.to_vec()).map_err(|why| refused(&why))?;
    Ok(ScenarioFile { name, problem })
}

/// The header and the times of a request to work on a scenario; `number` is what the answer will carry.
pub fn request(ScenarioFile { name, problem }: &ScenarioFile, number: u32) -> (ScenarioHeader, Vec<f64>) {
    let assignment = Assignment {
        run_id: 0,
        name: name.clone(),
        scenario: number,
        scenarios: 0,
        problem: problem.clone(),
        grids: Vec::new(),
    };
    (assignment.to_parts().0, problem.times.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Assignment {
        Assignment {
            run_id: 7,
            name: "scenario-1".into(),
            scenario: 0,
            scenarios: 1,
            problem: Problem {
                model: Force { radiation: 0.15, oblateness: 0.4 },
                initial: InitialGaussian { mean_phi: 2.0, mean_e: 0.1, sigma_phi: 0.1, sigma_e: 0.01 },
                times: vec![0.0, 0.5],
                critical_e: 0.6,
            },
            grids: vec![
                Grid { phi: Axis { low: 1.0, high: 2.0, bins: 3 }, e: Axis { low: 0.0, high: 0.2, bins: 4 } };
                2
            ],
        }
    }

    #[test]
    fn a_scenario_survives_the_way_through_a_message() {
        let (header, items) = example().to_parts();
        assert_eq!(Assignment::from_parts(&header, &items), Ok(example()));
    }

    #[test]
    fn a_request_is_checked_as_a_file_is() {
        let Assignment { name, problem, .. } = example();
        let scenario = ScenarioFile { name, problem };
        let (header, times) = request(&scenario, 3);
        assert_eq!(read_request(&header, &times).unwrap(), scenario);
        let refused = |header, times: &[f64], words: &str| {
            let error = read_request(&header, times).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        };
        refused(ScenarioHeader { mean_e: 1.5, ..header }, &times, "initial.e");
        refused(ScenarioHeader { radiation: f64::NAN, ..header }, &times, "orbit.radiation");
        refused(ScenarioHeader { name: pack("../x"), ..header }, &times, "plain");
        refused(header, &[0.0], "times.at");
    }

    #[test]
    fn a_message_that_cannot_be_right_is_refused() {
        let (header, items) = example().to_parts();
        assert!(Assignment::from_parts(&header, &items[1..]).is_err());
        assert!(Assignment::from_parts(&ScenarioHeader { sigma_e: 0.0, ..header }, &items).is_err());
        assert!(Assignment::from_parts(&ScenarioHeader { radiation: f64::NAN, ..header }, &items).is_err());
        assert!(Assignment::from_parts(&ScenarioHeader { phi_bins: 0, ..header }, &items).is_err());
        let backwards: Vec<f64> = items.chunks(SCENARIO_COLUMNS).rev().flatten().copied().collect();
        assert!(Assignment::from_parts(&header, &backwards).is_err());
    }
}

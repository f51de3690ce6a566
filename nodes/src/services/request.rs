//! A request to work on a scenario, as it travels to the scenario node of a service.

use kit::failure::Failure;
use kit::planar_problem;
use kit::space_problem;
use messages::scenario::{Description, MOST_SNAPSHOTS, ScenarioHeader};

use crate::files::input::{PLAIN_NAME, is_plain_name};
use crate::files::scenario_file::{self, AnyScenario, ScenarioFile, ScenarioInSpace};

/// The problem that a request is about.
///
/// # Errors
/// [`Failure::Refused`] says what is wrong.
pub fn read_request(header: &ScenarioHeader, items: &[f64]) -> Result<AnyScenario, Failure> {
    let name = messages::text::unpack(&header.name);
    if !is_plain_name(&name) {
        return Err(Failure::Refused(format!("a request's name must be plain: {PLAIN_NAME}")));
    }
    let refused = |why: &str| Failure::Refused(format!("request {name}: {why}"));
    if !scenario_file::is_right_number_of_times(header.snapshots as usize) {
        return Err(refused(&format!("times.at: must be 2 to {MOST_SNAPSHOTS} times")));
    }
    let said = Description::decode(header, items).map_err(|why| refused(&why))?;
    if !said.projections.is_empty() {
        return Err(refused("projections: a request has none, the service chooses them"));
    }
    if let Some(problem) = space_problem::problem(&said) {
        let problem = problem.map_err(|why| refused(&why))?;
        return Ok(AnyScenario::InSpace(ScenarioInSpace::of_cloud(name, problem)));
    }
    let (problem, spread) = planar_problem::problem(&said).map_err(|why| refused(&why))?;
    Ok(AnyScenario::InPlane { scenario: ScenarioFile { name, problem, spread, epoch: None }, semi_major_axis: None })
}

/// The header and the numbers of a request to work on a scenario; `number` is what the answer will carry.
///
/// # Errors
/// If there is more of something than a message holds.
pub fn request(scenario: &AnyScenario, number: u32) -> Result<(ScenarioHeader, Vec<f64>), Failure> {
    let said = match scenario {
        AnyScenario::InPlane { scenario: ScenarioFile { name, problem, spread, .. }, .. } => {
            planar_problem::described(name, problem, *spread, |_| Vec::new())
        }
        AnyScenario::InSpace(ScenarioInSpace { name, cloud: Some(problem), .. }) => {
            space_problem::described(name, problem, &[])
        }
        AnyScenario::InSpace(ScenarioInSpace { name, cloud: None, .. }) => {
            return Err(Failure::Refused(format!("{name} describes an orbit without a cloud about it")));
        }
    };
    Description { scenario: number, ..said }.encode().map_err(Failure::Refused)
}

#[cfg(test)]
mod tests {
    use super::*;
    use density::uncertain::{Distribution, Spread};
    use kit::assignment::Plane;
    use messages::text::pack;

    #[test]
    fn a_request_is_checked_as_a_file_is() {
        let Plane { problem, .. } = kit::example::assignment().plane.unwrap();
        let in_plane = |scenario| AnyScenario::InPlane { scenario, semi_major_axis: None };
        let scenario = ScenarioFile { name: "scenario-1".into(), problem, spread: None, epoch: None };
        let (header, items) = request(&in_plane(scenario.clone()), 3).unwrap();
        assert_eq!(read_request(&header, &items).unwrap(), in_plane(scenario.clone()));
        let spread = Spread { relative: 0.05, distribution: Distribution::LogNormal };
        let uncertain = ScenarioFile { spread: Some(spread), ..scenario };
        let (with_three, three) = request(&in_plane(uncertain.clone()), 4).unwrap();
        let found = read_request(&with_three, &three).unwrap().in_plane().unwrap().clone();
        assert_eq!(found.problem, uncertain.problem);
        let relative = found.spread.map_or(0.0, |spread| spread.relative);
        assert!((relative / 0.05 - 1.0).abs() < 1e-12, "{relative}");
        let refused = |header: ScenarioHeader, items: &[f64], words: &str| {
            let error = read_request(&header, items).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        };
        let with = |index: usize, value: f64| {
            let mut items = items.clone();
            items[index] = value;
            items
        };
        refused(header, &with(1, 1.5), "initial.e");
        refused(header, &with(1, f64::NAN), "not finite");
        refused(header, &with(3, 1.1e-3), "initial.correlation: 1.1");
        let mut unset = header;
        unset.parameters[0].value = f64::NAN;
        refused(unset, &items, "radiation");
        unset.parameters[0].value = -1.0;
        refused(unset, &items, "orbit.radiation");
        unset.parameters[0].name = pack("drag");
        refused(unset, &items, "has no parameter \"drag\"");
        refused(ScenarioHeader { model: pack("kepler"), ..header }, &items, "no planar model \"kepler\"");
        refused(ScenarioHeader { reentry: 0, ..header }, &items, "variables");
        refused(ScenarioHeader { name: pack("../x"), ..header }, &items, "plain");
        refused(ScenarioHeader { snapshots: 1, ..header }, &items, "times.at");
    }
}

//! Scenario files in the plane whose satellite passes the Earth's shadow.
//!
//! With the shadow there is no Hamiltonian and the semi-major axis changes, so that such a scenario is one of the
//! averaged model in space: without obliquity, in the equator, with the Sun at longitude 0 at first.

use density::in_space::{InitialInSpace, SpaceProblem};
use density::model::space_registry::SpaceModel;
use density::model::vectorial::Vectorial;
use density::problem::InitialGaussian;

use super::disposal::Disposal;
use super::epoch::Epoch;
use super::in_space::{self, ScenarioInSpace};
use super::initial::Initial;
use super::orbit;
use super::refusals::check_name;
use super::{Raw, times};
use crate::files::input::{InputError, InputFile};

/// Checks such a file.
///
/// # Errors
/// [`InputError`] with file, line and key.
pub(super) fn check(file: &InputFile) -> Result<ScenarioInSpace, InputError> {
    let raw: Raw = file.parse()?;
    if let Some(obliquity) = raw.model.as_ref().and_then(|model| model.obliquity.as_ref()) {
        return Err(file.error(obliquity, "has no effect: the planar model has the Sun in the equator; leave it out"));
    }
    check_name(file, &raw.name)?;
    let epoch = raw.epoch.as_ref().map(|table| Epoch::read(file, table)).transpose()?;
    let axis = orbit::semi_major_axis(file, &raw.orbit)?;
    let forces = in_space::forces(file, raw.model.as_ref(), &raw.orbit, axis)?;
    let model = Vectorial { forces, obliquity: 0.0, sun_longitude: 0.0 };
    let InitialGaussian { mean_phi, mean_e, sigma_phi, sigma_e, correlation } = Initial::read(file, &raw.initial)?;
    let initial = InitialInSpace {
        mean: [mean_phi, mean_e, 0.0, 0.0],
        sigma: [sigma_phi, sigma_e, 0.0, 0.0],
        correlation: [correlation, 0.0, 0.0, 0.0, 0.0, 0.0],
    };
    let problem = SpaceProblem {
        model: SpaceModel::Vectorial { model, axis },
        initial,
        spread: Initial::spread(file, &raw.initial)?,
        times: times::read(file, &raw.times, epoch.as_ref())?,
        critical_e: Disposal::read(file, &raw.disposal, axis)?,
        shadow: true,
        reentry_altitude: raw.disposal.get_ref().reentry_altitude(file)?,
    };
    let cloud = problem.checked().map_err(|error| raw.locate(file, &error))?;
    Ok(ScenarioInSpace { epoch, ..ScenarioInSpace::of_cloud(raw.name.get_ref().clone(), cloud) })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::{AnyScenario, check_any};
    use super::*;

    const GOOD: &str = "name = \"mine\"\n[model]\nforces = [\"srp\", \"j2\", \"shadow\"]\n[orbit]\nsemi_major_axis = 2.5\nradiation = 0.15\n\
        [initial]\nphi = 2.2\ne = 0.145\ndelta_phi = 0.39\ndelta_e = 0.05\n[times]\nend = 1.0\nstep = 0.5\n[disposal]\naltitude = 120\n";

    fn cloud(text: &str) -> Result<SpaceProblem, InputError> {
        match check_any(&InputFile::from_text(Path::new("s.toml"), text))? {
            AnyScenario::InSpace(scenario) => Ok(*scenario.cloud.unwrap()),
            AnyScenario::InPlane { .. } => panic!("without the shadow"),
        }
    }

    #[test]
    fn a_planar_file_with_the_shadow_is_a_scenario_in_space_in_the_equator() {
        let problem = cloud(GOOD).unwrap();
        let Vectorial { forces, obliquity, sun_longitude } = problem.model.averaged();
        assert_eq!((obliquity, sun_longitude, problem.model.axis(), problem.shadow), (0.0, 0.0, Some(2.5), true));
        assert_eq!((forces.force.radiation, forces.sun, forces.moon), (0.15, 0.0, 0.0));
        assert!((forces.force.oblateness - 0.409_204).abs() < 1e-6);
        assert_eq!((problem.initial.mean, problem.initial.sigma), ([2.2, 0.145, 0.0, 0.0], [0.195, 0.025, 0.0, 0.0]));
        assert!((problem.reentry_altitude.unwrap() - 120.0 / 6_378.137).abs() < 1e-12);
        assert!((problem.critical_e - 0.592_474).abs() < 1e-6);
    }

    #[test]
    fn the_text_of_such_a_scenario_states_the_same_problem() {
        let problem = cloud(GOOD).unwrap();
        let text = super::super::text_in_space::to_text("mine", &problem);
        let again = cloud(&text).unwrap();
        assert_eq!((again.model, again.initial, again.shadow), (problem.model, problem.initial, problem.shadow));
        let height = |problem: &SpaceProblem| problem.reentry_altitude.unwrap();
        assert!((height(&again) - height(&problem)).abs() < 1e-14);
    }

    #[test]
    fn where_the_hamiltonian_is_needed_the_shadow_is_refused_at_its_place() {
        let error = super::super::check(&InputFile::from_text(Path::new("s.toml"), GOOD)).unwrap_err();
        assert_eq!((error.line, error.key.as_str()), (3, "model.forces"));
        assert!(error.to_string().contains("\"shadow\" takes the Hamiltonian from the planar model"), "{error}");
    }

    #[test]
    fn a_shadow_without_a_semi_major_axis_is_refused() {
        let text =
            GOOD.replace("semi_major_axis = 2.5\n", "oblateness = 0.4\n").replace("altitude = 120", "critical_e = 0.5");
        assert!(cloud(&text).unwrap_err().to_string().contains("\"shadow\" needs the semi-major axis"));
    }
}

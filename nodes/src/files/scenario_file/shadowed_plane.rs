//! Scenario files in the plane whose satellite passes the Earth's shadow.
//!
//! With the shadow there is no Hamiltonian and the semi-major axis changes, so that such a scenario is one of the averaged model in space: without
//! obliquity, in the equator, with the Sun at longitude 0 at first.

use density::in_space::models::SpaceModel;
use density::in_space::{InitialInSpace, SpaceProblem, SpaceProblemError};
use density::model::vectorial::Vectorial;
use density::problem::InitialGaussian;

use super::disposal::Disposal;
use super::epoch::Epoch;
use super::in_space::{self, ModelInSpace, ScenarioInSpace};
use super::initial::Initial;
use super::orbit::{self, Orbit};
use super::{Raw, check_name, times};
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
    let cloud = problem.checked().map_err(|SpaceProblemError { key, problem }| match key.split_once('.') {
        Some(("orbit", key)) => Orbit::locate(&raw.orbit, file, key, &problem),
        Some(("initial", key)) => file.error(&raw.initial, &format!("{key}: {problem}")),
        Some(("disposal", _)) => Disposal::locate(&raw.disposal, file, &problem),
        _ => file.error_in_whole(&key, &problem),
    })?;
    Ok(ScenarioInSpace {
        name: raw.name.get_ref().clone(),
        model: ModelInSpace::Vectorial(model, initial.mean),
        semi_major_axis: axis,
        times: cloud.times.clone(),
        critical_e: Some(cloud.critical_e),
        shadow: true,
        cloud: Some(Box::new(cloud)),
    })
}

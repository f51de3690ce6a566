//! The problem of a scenario in space as its message states it, and the statement of a problem for a message.

use density::grid::Axis;
use density::in_space::acting::SHADOW;
use density::in_space::{InitialInSpace, PAIRS, REENTRY, SpaceProblem, VARIABLES};
use density::model::space_registry::SpaceModel;
use density::problem::STRONGEST_CORRELATION;
use messages::scenario::{Description, Moment, Parameter, Projection};

use crate::planar_problem::{spread, variable};
use crate::problem_key::by_key;

/// The projections on which clouds in space are compared, where an axis has this number of bins: solar angle and
/// eccentricity together, eccentricity and inclination together, and each variable by itself but for the radiation
/// parameter, which does not change.
pub fn projections(bins: &[usize]) -> Vec<Projection> {
    let axis = |k: usize| (k, bins.get(k).copied().unwrap_or(0));
    let one = |k: usize| Projection { first: axis(k), second: None };
    let pair = |a: usize, b: usize| Projection { first: axis(a), second: Some(axis(b)) };
    vec![pair(0, 1), one(0), one(1), pair(1, 2), one(2), one(3)]
}

/// What a message says of a problem in space that is compared on these axes: one list of axes for each snapshot, none
/// in a request.
pub fn described(name: &str, problem: &SpaceProblem, axes: &[Vec<Axis>]) -> Description {
    let (mean, covariance) = problem.moments();
    let parameter =
        |(name, symbol, value): (&str, &str, f64)| Parameter { name: name.into(), symbol: symbol.into(), value };
    let shadow = problem.shadow.then_some((SHADOW, SHADOW, 1.0));
    let altitude = problem.reentry_altitude.map(|altitude| (REENTRY_ALTITUDE, "h", altitude));
    let upper = (0..mean.len()).flat_map(|a| covariance[a][a..].to_vec()).collect();
    let bins: Option<Vec<usize>> = axes.first().map(|axes| axes.iter().map(|axis| axis.bins).collect());
    let projections = bins.map_or(Vec::new(), |bins| projections(&bins));
    let moment = |(index, &time): (usize, &f64)| {
        let of_snapshot = axes.get(index);
        let end = |(k, _): (usize, usize)| of_snapshot.and_then(|axes| axes.get(k)).map(|axis| [axis.low, axis.high]);
        Moment { time, ends: projections.iter().flat_map(Projection::axes).filter_map(end).collect() }
    };
    Description {
        run_id: 0,
        scenario: 0,
        scenarios: 0,
        name: name.into(),
        model: problem.model.name().into(),
        parameters: problem.model.parameters().into_iter().chain(shadow).chain(altitude).map(parameter).collect(),
        variables: problem.variables().iter().map(variable).collect(),
        reentry: REENTRY,
        critical: problem.critical_e,
        mean,
        covariance: upper,
        snapshots: problem.times.iter().enumerate().map(moment).collect(),
        projections,
    }
}

/// The problem in space that a message states; `None` if its model is none in space.
///
/// # Errors
/// What is wrong, by the key that a scenario file has for it.
pub fn problem(said: &Description) -> Option<Result<SpaceProblem, String>> {
    let given = said.parameters.iter().map(|given| (given.name.as_str(), given.value));
    let of_model: Vec<(&str, f64)> = given.filter(|(name, _)| ![SHADOW, REENTRY_ALTITUDE].contains(name)).collect();
    let model = SpaceModel::by_name(&said.model, &of_model)?;
    Some(model.map_err(|error| format!("model: {error}")).and_then(|model| with_model(said, model)))
}

/// Parameters of a scenario that are none of the model's: whether the Earth has a shadow (1 if so), and the height of
/// the pericentre at re-entry \[Earth radii\].
const REENTRY_ALTITUDE: &str = "reentry_altitude";

fn with_model(said: &Description, model: SpaceModel) -> Result<SpaceProblem, String> {
    let count = VARIABLES.len();
    let spread = spread(said, model.forces().force.radiation, count)?;
    let times = said.snapshots.iter().map(|moment| moment.time).collect();
    let all = said.mean.len();
    let expected = all == count + usize::from(spread.is_some());
    let covariance = |a: usize, b: usize| {
        let before: usize = (0..a).map(|row| all - row).sum();
        said.covariance.get(before + b - a).copied().unwrap_or(f64::NAN)
    };
    if !expected {
        return Err(format!(
            "variables: {all} of them, a cloud in space has {count}, or one more for the radiation parameter"
        ));
    }
    if (count..all).any(|last| (0..count).any(|k| covariance(k, last) != 0.0)) {
        return Err("initial: the radiation parameter is independent of all other variables".into());
    }
    // The root of a square is the number itself, to the last bit.
    let sigma: [f64; 4] = std::array::from_fn(|k| covariance(k, k).sqrt());
    let of_pair = |(a, b): (usize, usize)| {
        let covariance = covariance(a, b);
        let correlation = covariance / (sigma[a] * sigma[b]);
        if covariance == 0.0 { 0.0 } else { rounded(correlation) }
    };
    let mean = std::array::from_fn(|k| said.mean[k]);
    let initial = InitialInSpace { mean, sigma, correlation: PAIRS.map(of_pair) };
    let stated = |name: &str| said.parameters.iter().find(|given| given.name == name).map(|given| given.value);
    let shadow = match stated(SHADOW) {
        None | Some(0.0) => false,
        Some(1.0) => true,
        Some(other) => return Err(format!("parameters: {SHADOW} is {other}, it must be 0 or 1")),
    };
    let reentry_altitude = stated(REENTRY_ALTITUDE);
    let critical_e = said.critical;
    let problem = SpaceProblem { model, initial, spread, times, critical_e, shadow, reentry_altitude };
    let problem = problem.checked().map_err(|error| by_key(&error))?;
    let ours: Vec<_> = problem.variables().iter().map(variable).collect();
    match (&said.variables, said.reentry) == (&ours, REENTRY) {
        true => Ok(problem),
        false => Err(format!("variables: they are not those of the model \"{}\"", said.model)),
    }
}

/// A correlation that rounding may have moved beyond the strongest one.
fn rounded(correlation: f64) -> f64 {
    const ROUNDING: f64 = 1e-12;
    let is_strongest = (correlation.abs() - STRONGEST_CORRELATION).abs() < ROUNDING;
    if is_strongest { STRONGEST_CORRELATION.copysign(correlation) } else { correlation }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assignment::Assignment;
    use density::in_space::{example, pilot};
    use density::uncertain::{Distribution, Spread};

    fn assignment(problem: SpaceProblem) -> Assignment {
        let axes = pilot::axes(&problem, &[10, 8, 6, 5]).unwrap();
        Assignment::in_space(7, "in-space", (0, 1), problem, axes)
    }

    #[test]
    fn a_scenario_in_space_survives_the_way_through_a_message() {
        let log_normal = Some(Spread { relative: 0.1, distribution: Distribution::LogNormal });
        for spread in [None, example::problem().spread, log_normal] {
            let sent = assignment(SpaceProblem { spread, ..example::problem() });
            let (header, items) = sent.to_parts().unwrap();
            let read = Assignment::from_parts(&header, &items).unwrap();
            let (ours, theirs) = (read.in_space.as_ref().unwrap(), sent.in_space.as_ref().unwrap());
            assert_eq!((&read.description, &read.axes, ours.model), (&sent.description, &sent.axes, theirs.model));
            let apart = |a: [f64; 6], b: [f64; 6]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-14);
            assert!(apart(ours.initial.correlation, theirs.initial.correlation));
            assert_eq!(ours.initial.sigma, theirs.initial.sigma);
            assert!(read.plane.is_none() && read.plane().unwrap_err().to_string().contains("\"vectorial\""));
        }
    }

    /// The message of a problem, on the axes of the example.
    fn described_by(problem: SpaceProblem) -> (messages::scenario::ScenarioHeader, Vec<f64>) {
        let axes = pilot::axes(&example::problem(), &[10, 8, 6, 5]).unwrap();
        Assignment::in_space(7, "in-space", (0, 1), problem, axes).to_parts().unwrap()
    }

    #[test]
    fn the_shadow_and_the_height_of_reentry_survive_the_way_through_a_message() {
        for (shadow, reentry_altitude) in [(true, None), (false, Some(0.0188)), (true, Some(0.0188))] {
            let (header, items) = described_by(SpaceProblem { shadow, reentry_altitude, ..example::problem() });
            let read = Assignment::from_parts(&header, &items).unwrap().in_space.unwrap();
            assert_eq!((read.shadow, read.reentry_altitude), (shadow, reentry_altitude));
        }
    }

    #[test]
    fn a_message_in_space_that_cannot_be_right_is_refused() {
        let shadowed = SpaceProblem { shadow: true, reentry_altitude: Some(0.02), ..example::problem() };
        let (header, items) = described_by(shadowed);
        let refused = |change: fn(&mut messages::scenario::ScenarioHeader, &mut Vec<f64>), words: &str| {
            let (mut header, mut items) = (header, items.clone());
            change(&mut header, &mut items);
            let why = Assignment::from_parts(&header, &items).unwrap_err();
            assert!(why.contains(words), "{why}");
        };
        refused(|header, _| header.parameter_count = 3, "no value for its parameter moon");
        refused(|header, _| header.variables[2].low = -1.0, "not those of the model");
        refused(|header, _| header.reentry = 0, "not those of the model");
        refused(|header, _| header.parameters[7].value = 2.0, "shadow is 2, it must be 0 or 1");
        refused(|_, items| items[1] = 1.5, "initial.e: 1.5 is not allowed");
        refused(|_, items| items[5 + 4] = 1e-3, "independent of all other variables");
        refused(|_, items| items[4] = 0.2, "the mean of the radiation parameter is 0.2");
    }
}

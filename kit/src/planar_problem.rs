//! The problem of a planar scenario as its message states it, and the statement of a problem for a message.

use density::model::plane::VARIABLES;
use density::model::registry::{ModelError, Planar};
use density::model::{Kind, Model, PlanarHamiltonian, Variable};
use density::problem::{InitialGaussian, Problem};
use density::uncertain::{Distribution, Spread, UncertainProblem};
use messages::scenario::{self, Description, Moment, Parameter, Range};

use crate::problem_key::by_key;

/// What a message says of a problem, whose radiation parameter may be uncertain, without the projections.
pub fn described(
    name: &str,
    problem: &Problem<Planar>,
    spread: Option<Spread>,
    ends: impl Fn(usize) -> Vec<[f64; 2]>,
) -> Description {
    let Problem { model, initial, times, critical_e } = problem;
    let InitialGaussian { mean_phi, mean_e, sigma_phi, sigma_e, .. } = *initial;
    let parameter = |(parameter, value): (density::model::parameter::Parameter, f64)| Parameter {
        name: parameter.name.into(),
        symbol: parameter.symbol.into(),
        value,
    };
    let (mut variables, mut mean) = (VARIABLES.to_vec(), vec![mean_phi, mean_e]);
    let mut covariance = vec![sigma_phi * sigma_phi, initial.covariance(), sigma_e * sigma_e];
    if let Some(spread) = spread {
        let (third, sigma) = UncertainProblem { plane: problem.clone(), spread }.third();
        variables.push(spread.distribution.variable());
        mean.push(third);
        let [phi, cross, e] = [covariance[0], covariance[1], covariance[2]];
        covariance = vec![phi, cross, 0.0, e, 0.0, sigma * sigma];
    }
    Description {
        run_id: 0,
        scenario: 0,
        scenarios: 0,
        name: name.into(),
        model: model.name().into(),
        parameters: model.parameters().into_iter().map(parameter).collect(),
        variables: variables.iter().map(variable).collect(),
        reentry: Planar::REENTRY,
        critical: *critical_e,
        mean,
        covariance,
        projections: Vec::new(),
        snapshots: times.iter().enumerate().map(|(index, &time)| Moment { time, ends: ends(index) }).collect(),
    }
}

/// A variable as a message states it.
pub(crate) fn variable(variable: &Variable) -> scenario::Variable {
    scenario::Variable {
        name: variable.name.into(),
        symbol: variable.symbol.into(),
        unit: variable.unit.into(),
        range: match variable.kind {
            Kind::Circle => Range::Circle,
            Kind::Interval { low, high } => Range::Interval { low, high },
        },
    }
}

/// The problem that a message states, and the spread of its radiation parameter if that is uncertain.
///
/// # Errors
/// What is wrong, by the key that a scenario file has for it.
pub fn problem(said: &Description) -> Result<(Problem<Planar>, Option<Spread>), String> {
    let given: Vec<(&str, f64)> = said.parameters.iter().map(|given| (given.name.as_str(), given.value)).collect();
    let model = Planar::by_name(&said.model, &given).map_err(|error| match error {
        ModelError::Unknown { .. } => format!("model.name: {error}"),
        ModelError::Missing { .. } | ModelError::Superfluous { .. } => format!("orbit: {error}"),
    })?;
    let nowhere = Problem { model, initial: NOWHERE, times: Vec::new(), critical_e: 0.0 };
    let spread = spread(said, model.value("radiation").unwrap_or(0.0), VARIABLES.len())?;
    let ours = described("", &nowhere, spread, |_| Vec::new());
    if (&said.variables, said.reentry) != (&ours.variables, ours.reentry) {
        return Err(format!(
            "variables: they are not those of the model \"{}\": solar angle phi and eccentricity e, and the radiation parameter \
             where it is uncertain",
            said.model
        ));
    }
    let (mean_phi, mean_e, phi_phi, phi_e, e_e) = match (&said.mean[..], &said.covariance[..]) {
        (&[phi, e], &[phi_phi, phi_e, e_e]) => (phi, e, phi_phi, phi_e, e_e),
        (&[phi, e, _], &[phi_phi, phi_e, 0.0, e_e, 0.0, _]) => (phi, e, phi_phi, phi_e, e_e),
        (&[_, _, _], _) => return Err("initial: the radiation parameter is independent of phi and e".into()),
        _ => return Err("initial: a planar cloud has two means and three covariances".into()),
    };
    // The root of a square is the number itself, to the last bit.
    let (sigma_phi, sigma_e) = (phi_phi.sqrt(), e_e.sqrt());
    let correlation = phi_e / (sigma_phi * sigma_e);
    let initial = InitialGaussian { mean_phi, mean_e, sigma_phi, sigma_e, correlation };
    let times = said.snapshots.iter().map(|moment| moment.time).collect();
    let problem = Problem::new(model, initial, times, said.critical);
    let problem = problem.map_err(|error| by_key(&error))?;
    Ok((problem, spread))
}

/// The spread of the radiation parameter. A message states the nominal value among the parameters, and the mean and the
/// variance as those of its last variable, which stands at `place`.
pub(crate) fn spread(said: &Description, radiation: f64, place: usize) -> Result<Option<Spread>, String> {
    const ROUNDING: f64 = 1e-9;
    let (Some(third), Some(&mean), Some(&variance)) =
        (said.variables.get(place), said.mean.get(place), said.covariance.last())
    else {
        return Ok(None);
    };
    let distributions = [Distribution::Gaussian, Distribution::LogNormal];
    let distribution = distributions.into_iter().find(|distribution| distribution.variable().symbol == third.symbol);
    let distribution =
        distribution.ok_or_else(|| format!("variables: {} is none that such a cloud has", third.symbol))?;
    let (relative, right) = match distribution {
        Distribution::Gaussian => (variance.sqrt() / mean, mean),
        Distribution::LogNormal => (variance.exp_m1().sqrt(), (mean + 0.5 * variance).exp()),
    };
    if (right / radiation - 1.0).abs() > ROUNDING || !relative.is_finite() {
        return Err(format!(
            "initial: the mean of the radiation parameter is {right}, but the parameter is {radiation}"
        ));
    }
    Ok(Some(Spread { relative, distribution }))
}

/// A placeholder where the initial Gaussian is not used.
const NOWHERE: InitialGaussian =
    InitialGaussian { mean_phi: 0.0, mean_e: 0.0, sigma_phi: 0.0, sigma_e: 0.0, correlation: 0.0 };

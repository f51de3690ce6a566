//! A cloud in space: what is known of an orbit at first, carried on in any model.
//!
//! The cloud at `t = 0` is a Gaussian over solar angle, eccentricity, inclination and node, some of which may be
//! certain, and over the radiation parameter if that is uncertain, which is then independent of the others. The
//! elements of an orbit are singular in two places, at neither of which the cloud is singular:
//!
//! - `e = 0`: the Gaussian is cut to `0 < e < 1` and scaled to a probability of 1, as in the plane
//!   ([`crate::problem`]);
//! - `i = 0`: an inclination below 0 is one above it with the node on the other side: `(phi, -i, node)` is the orbit
//!   `(phi, i, node + π)`, since the plane turns about the line of nodes and `phi` counts from a direction that turns
//!   with it. So nothing is cut there, and the vectors of the orbit are smooth functions of the Gaussian's variables.
//!
//! `i = π` is singular in `phi` itself; clouds that come near it are refused.
//!
//! Every orbit is drawn by its number from the same shares of probability ([`draws`]), whichever model then moves it,
//! so that clouds in two models differ by the models alone (common random numbers).
//!
//! | file | idea |
//! |---|---|
//! | here | the problem |
//! | [`acting`] | the forces that act |
//! | [`draws`] | the orbits of a cloud by their numbers |
//! | [`cloud`] | orbits on their way, of whichever model |
//! | [`sampled`] | the orbits of a cloud in its own model or in a simpler one |
//! | [`mean_cloud`] | unaveraged orbits, read out as averages over a revolution |
//! | [`fidelity`] | how far simpler models move the figures of a cloud |
//! | [`task`] | the model and the Gaussian for methods that place points themselves |
//! | [`disposal`] | the questions of a disposal designer |
//! | [`pilot`] | the axes on which clouds are compared |

pub mod acting;
pub mod cloud;
pub mod disposal;
pub mod draws;
pub mod fidelity;
pub mod mean_cloud;
pub mod pilot;
pub mod sampled;
pub mod task;

use std::f64::consts::PI;

use crate::gaussian::Gaussian;
use crate::model::model_name::ModelName;
use crate::model::space_registry::SpaceModel;
use crate::model::{Variable, vectorial};
use crate::problem::{STRONGEST_CORRELATION, check_times};
use crate::problem_error::{Field, ProblemError, check};
use crate::uncertain::{self, Distribution, Spread};

/// The variables of a cloud in space, but for the radiation parameter.
pub const VARIABLES: [Variable; 4] = vectorial::VARIABLES;
/// Position of the eccentricity, at whose critical value the satellite re-enters.
pub const REENTRY: usize = 1;

/// The Gaussian at `t = 0` over [`VARIABLES`], before the cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InitialInSpace {
    /// Means.
    pub mean: [f64; 4],
    /// Standard deviations; a variable with 0 is certain.
    pub sigma: [f64; 4],
    /// Correlations of the pairs of variables, in the order of [`PAIRS`].
    pub correlation: [f64; 6],
}

/// The pairs of variables.
pub const PAIRS: [(usize, usize); 6] = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];

/// The names of [`PAIRS`] in scenario files.
pub const PAIR_NAMES: [&str; 6] =
    ["phi_e", "phi_inclination", "phi_node", "e_inclination", "e_node", "inclination_node"];

/// A cloud in space, and what is asked of it.
#[derive(Debug, Clone, PartialEq)]
pub struct SpaceProblem {
    /// The model, with the mean of its radiation parameter.
    pub model: SpaceModel,
    /// The cloud at `t = 0`.
    pub initial: InitialInSpace,
    /// The uncertainty of the radiation parameter, if it is uncertain.
    pub spread: Option<Spread>,
    /// Snapshot times \[yr\], ascending from zero.
    pub times: Vec<f64>,
    /// Eccentricity at which the satellite re-enters.
    pub critical_e: f64,
    /// Whether the Earth has a shadow.
    pub shadow: bool,
    /// Height of the pericentre above the equator at which the satellite re-enters whatever its semi-major axis is then
    /// \[Earth radii\]; where there is none, it re-enters at the critical eccentricity. With a constant semi-major axis
    /// the two say the same.
    pub reentry_altitude: Option<f64>,
}

/// The narrowest Gaussian that is no certainty.
const NARROWEST: f64 = 5e-10;
/// The standard deviations by their names in a scenario file, each with the largest permitted one.
const SIGMAS: [(&str, f64); 4] = [("sigma_phi", PI), ("sigma_e", 0.5), ("sigma_inclination", PI), ("sigma_node", PI)];
/// So many of the variables, from the first, must not be certain.
const MUST_BE_UNCERTAIN: usize = 2;
/// How far from π an inclination stays, also one that is certain \[rad\]. Next to π the solar angle follows from the
/// vectors of the orbit with an error of about 2e-16 divided by the square of the distance.
pub const FROM_PI: f64 = 1e-3;
/// How far from its mean, in standard deviations, an inclination must not reach π.
const REACH: f64 = 6.0;

impl SpaceProblem {
    /// The same problem, if every number is in the range for which the methods are made.
    ///
    /// # Errors
    /// [`ProblemError`] with the first field that is wrong and the values that are allowed.
    pub fn checked(self) -> Result<Self, ProblemError> {
        self.model.check()?;
        self.initial.check()?;
        self.check_spread()?;
        check_times(&self.times)?;
        self.check_shadow()?;
        if let Some(altitude) = self.reentry_altitude {
            let is_right = (-1.0..100.0).contains(&altitude);
            check(Field::ReentryAltitude, altitude, is_right, "above the Earth's centre and below the orbit".into())?;
        }
        let is_right = self.critical_e > 0.0 && self.critical_e < 1.0;
        check(Field::CriticalE, self.critical_e, is_right, "between 0 and 1, both excluded".into())?;
        Ok(self)
    }

    /// Whether it is a problem of the planar model whose satellite passes the Earth's shadow: with the shadow there is
    /// no Hamiltonian, so that it is solved as one in space without obliquity and inclination.
    pub fn is_shadowed_plane(&self) -> bool {
        let Some(model) = self.model.if_averaged() else { return false };
        let InitialInSpace { mean: [_, _, inclination, _], sigma: [_, _, sigma, _], .. } = self.initial;
        self.shadow && model.obliquity == 0.0 && model.sun_longitude == 0.0 && inclination == 0.0 && sigma == 0.0
    }

    /// The model as the author of the scenario names it.
    pub fn model_name(&self) -> ModelName {
        if self.is_shadowed_plane() { ModelName::Planar } else { self.model.model_name() }
    }

    fn check_shadow(&self) -> Result<(), ProblemError> {
        let refused = |problem: &str| Err(ProblemError::misfit(Field::Shadow, problem));
        match (self.shadow, self.model.axis(), self.model.forces().force.radiation) {
            (true, None, _) => refused("\"shadow\" needs the semi-major axis, with which the satellite passes it"),
            (true, _, 0.0) => refused("\"shadow\" has no effect: there is no radiation pressure"),
            _ => Ok(()),
        }
    }

    /// Height of the pericentre above the Earth's centre at which the satellite re-enters \[Earth radii\], if not at a
    /// critical eccentricity.
    pub fn reentry_radius(&self) -> Option<f64> {
        self.reentry_altitude.map(|altitude| 1.0 + altitude)
    }

    fn check_spread(&self) -> Result<(), ProblemError> {
        let Some(Spread { relative, .. }) = self.spread else { return Ok(()) };
        let (low, high) = (uncertain::NARROWEST, uncertain::WIDEST);
        let right = format!("at least {low:e} and at most {high}, a share of the radiation parameter");
        check(Field::SigmaRadiation, relative, (low..=high).contains(&relative), right)?;
        match self.model.forces().force.radiation > 0.0 {
            true => Ok(()),
            false => {
                let problem = "has no effect: there is no radiation pressure, its parameter is 0";
                Err(ProblemError::misfit(Field::SigmaRadiation, problem))
            }
        }
    }

    /// The variables of the cloud.
    pub fn variables(&self) -> Vec<Variable> {
        VARIABLES.into_iter().chain(self.spread.map(|spread| spread.distribution.variable())).collect()
    }

    /// Mean and standard deviation of the radiation parameter, or of its logarithm, if it is uncertain.
    pub fn radiation(&self) -> Option<(f64, f64)> {
        self.spread.map(|spread| spread.parameters(self.model.forces().force.radiation))
    }

    /// Means and covariance of all variables before the cut.
    pub fn moments(&self) -> (Vec<f64>, Vec<Vec<f64>>) {
        let InitialInSpace { mean, .. } = self.initial;
        let (mut means, mut covariance): (Vec<f64>, Vec<Vec<f64>>) =
            (mean.to_vec(), self.initial.covariance().iter().map(|row| row.to_vec()).collect());
        if let Some((mean, sigma)) = self.radiation() {
            means.push(mean);
            covariance.iter_mut().for_each(|row| row.push(0.0));
            covariance.push([vec![0.0; VARIABLES.len()], vec![sigma * sigma]].concat());
        }
        (means, covariance)
    }

    /// Whether `C` is log-normal rather than a Gaussian.
    fn is_logarithmic(&self) -> bool {
        self.spread.is_some_and(|spread| spread.distribution == Distribution::LogNormal)
    }
}

impl InitialInSpace {
    /// The covariance before the cut.
    pub fn covariance(&self) -> [[f64; 4]; 4] {
        let mut covariance = [[0.0; 4]; 4];
        for (k, sigma) in self.sigma.into_iter().enumerate() {
            covariance[k][k] = sigma * sigma;
        }
        for ((a, b), correlation) in PAIRS.into_iter().zip(self.correlation) {
            covariance[a][b] = correlation * self.sigma[a] * self.sigma[b];
            covariance[b][a] = covariance[a][b];
        }
        covariance
    }

    /// The Gaussian before the cut.
    ///
    /// # Errors
    /// [`ProblemError`] if the correlations exclude one another.
    pub fn gaussian(&self) -> Result<Gaussian<4>, ProblemError> {
        Gaussian::with_certain_variables(self.mean, self.covariance()).map_err(|_| contradiction())
    }

    fn check(&self) -> Result<(), ProblemError> {
        let Self { mean: [phi, e, inclination, node], sigma, .. } = *self;
        check(Field::MeanPhi, phi, true, "an angle in radians".into())?;
        check(Field::MeanNode, node, true, "an angle in radians".into())?;
        check(Field::MeanE, e, (0.0..1.0).contains(&e), "at least 0 and below 1".into())?;
        for (k, (name, most)) in SIGMAS.into_iter().enumerate() {
            let is_certain = sigma[k] == 0.0 && k >= MUST_BE_UNCERTAIN;
            let is_right = is_certain || (NARROWEST..=most).contains(&sigma[k]);
            check(Field::Sigma(name), sigma[k], is_right, format!("at least {NARROWEST:e} and at most {most}"))?;
        }
        let most = PI - (REACH * sigma[2]).max(FROM_PI);
        let right = format!(
            "an angle in radians, at least 0 and below {most:.6}: within {REACH} standard deviations of π, and within {FROM_PI} rad, the solar \
             angle is singular"
        );
        check(Field::MeanInclination, inclination, (0.0..most).contains(&inclination), right)?;
        self.check_correlations()
    }

    fn check_correlations(&self) -> Result<(), ProblemError> {
        for ((name, (a, b)), correlation) in PAIR_NAMES.into_iter().zip(PAIRS).zip(self.correlation) {
            let right = format!("between -{STRONGEST_CORRELATION} and {STRONGEST_CORRELATION}");
            let is_right = correlation.abs() <= STRONGEST_CORRELATION;
            check(Field::CorrelationOf(name), correlation, is_right, right)?;
            if correlation != 0.0 && (self.sigma[a] == 0.0 || self.sigma[b] == 0.0) {
                let problem = "is a correlation with a variable that is certain; give its sigma, or leave this out";
                return Err(ProblemError::misfit(Field::CorrelationOf(name), problem));
            }
        }
        self.gaussian().map(|_| ())
    }
}

fn contradiction() -> ProblemError {
    let problem = "no Gaussian has all these correlations: the matrix of correlations is not positive definite";
    ProblemError::misfit(Field::Correlations, problem)
}

pub mod example {
    //! An example for tests: a cloud at two and a half Earth radii, inclined and correlated.
    use super::*;
    use crate::model::planar::SrpJ2;
    use crate::model::registry::Planar;
    use crate::model::sun_moon::SunMoon;
    use crate::model::vectorial::Vectorial;
    use crate::problem::{InitialGaussian, Problem};

    /// The cloud, with an uncertain radiation parameter.
    pub fn problem() -> SpaceProblem {
        let forces =
            SunMoon { force: SrpJ2 { radiation: 0.15, oblateness: 0.409_204 }, sun: 4.7622e-4, moon: 1.037e-3 };
        SpaceProblem {
            model: SpaceModel::Vectorial {
                model: Vectorial { forces, obliquity: 0.409, sun_longitude: 1.0 },
                axis: Some(2.5),
            },
            initial: InitialInSpace {
                mean: [2.2069, 0.145, 0.2, 1.0],
                sigma: [0.1, 0.02, 0.02, 0.1],
                correlation: [0.3, 0.0, 0.0, -0.4, 0.0, 0.0],
            },
            spread: Some(Spread { relative: 0.05, distribution: Distribution::Gaussian }),
            times: vec![0.0, 0.5, 1.0],
            critical_e: 0.6,
            shadow: false,
            reentry_altitude: None,
        }
    }

    /// A cloud in the equator under a Sun in the equator, with this radiation parameter, and the same cloud in the
    /// plane, whose model is right for it.
    pub fn in_the_equator(radiation: f64, spread: Option<Spread>) -> (SpaceProblem, Problem<Planar>) {
        let mut problem = SpaceProblem { spread, critical_e: 0.52, ..problem() };
        let Vectorial { mut forces, sun_longitude, .. } = problem.model.averaged();
        (forces.sun, forces.moon, forces.force.radiation) = (0.0, 0.0, radiation);
        let model = Vectorial { forces, sun_longitude, obliquity: 0.0 };
        problem.model = SpaceModel::Vectorial { model, axis: None };
        let InitialInSpace { mean, sigma, correlation } = &mut problem.initial;
        (mean[2], sigma[2], sigma[3], *correlation) = (0.0, 0.0, 0.0, [0.0; 6]);
        let initial = InitialGaussian {
            mean_phi: mean[0],
            mean_e: mean[1],
            sigma_phi: sigma[0],
            sigma_e: sigma[1],
            correlation: 0.0,
        };
        let model = problem.model.planar();
        let plane = Problem { model, initial, times: problem.times.clone(), critical_e: problem.critical_e };
        (problem, plane)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_key_is_told_with_its_value_and_what_would_be_right() {
        assert!(example::problem().checked().is_ok());
        let refused = |change: fn(&mut SpaceProblem), field: Field, words: &str| {
            let mut problem = example::problem();
            change(&mut problem);
            let error = problem.checked().unwrap_err();
            assert_eq!(error.field, field);
            assert!(error.to_string().contains(words), "{error}");
        };
        refused(|p| p.initial.mean[1] = 1.0, Field::MeanE, "1 is not allowed, it must be at least 0 and below 1");
        refused(|p| p.initial.sigma[0] = 0.0, Field::Sigma("sigma_phi"), "at least 5e-10");
        refused(|p| p.initial.mean[2] = 3.1, Field::MeanInclination, "singular");
        refused(|p| p.initial.mean[3] = f64::NAN, Field::MeanNode, "an angle in radians");
        let correlation = Field::CorrelationOf("e_inclination");
        refused(|p| p.initial.correlation[3] = 1.0, correlation, "between -0.999 and 0.999");
        refused(|p| p.initial.sigma[2] = 0.0, correlation, "a variable that is certain");
        refused(
            |p| p.initial.correlation = [0.9, 0.9, 0.0, -0.9, 0.0, 0.0],
            Field::Correlations,
            "not positive definite",
        );
        refused(|p| p.spread = p.spread.map(|s| Spread { relative: 2.0, ..s }), Field::SigmaRadiation, "at most 1");
        refused(|p| p.critical_e = 0.0, Field::CriticalE, "between 0 and 1");
        refused(
            |p| (p.shadow, p.model) = (true, SpaceModel::Vectorial { model: p.model.averaged(), axis: None }),
            Field::Shadow,
            "\"shadow\" needs the semi-major axis",
        );
        refused(|p| p.times = vec![0.0, 0.0], Field::Times, "times must ascend");
    }
}

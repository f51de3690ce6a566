//! The exact density: no sampling, no interpolation between samples, no mixture, and an error estimate for every
//! number.
//!
//! The motion in the plane is integrable: every orbit of the cloud is closed. A cloud is therefore a family of orbits.
//! Each has a probability that is spread along it and only moves round ([`contour`], [`share`]), and everything that is
//! asked of the cloud is an integral over the family ([`family`]): moments and the probability above the critical
//! eccentricity ([`moments`]), bin averages of the joint density ([`joint`]), the first-passage curve
//! ([`crate::first_passage::exact`]). The terms of these integrals are positive, so an error of the outer integral is
//! never larger than the probability that it concerns. The probability of the whole family must be 1, which shows
//! whether orbits were overlooked.
//!
//! Liouville's theorem gives the density at any point in closed form as well ([`crate::model::plane::density_growth`],
//! [`Exact::density`]).
//!
//! A figure that cannot be computed accurately enough for a yardstick is withheld: it is NaN, and its error estimate
//! says how far the computation came ([`Limits`]). Every snapshot is also checked against orbits that start at random
//! and are carried by the integrator in a separate call, which uses none of the above ([`self_check`]).
//!
//! The marginals are the sums of the joint density's rows and columns, as for every other method: they miss what lies
//! outside the grid, [`ExactSnapshot::mass_outside`].
//!
//! | file | idea |
//! |---|---|
//! | [`axis`] | the point by which each orbit is identified: where it is least eccentric |
//! | [`contour`] | one closed orbit, followed once round |
//! | `trail` | an orbit as points close enough together for cubic interpolation |
//! | `crossings` | where an orbit passes the lines of a grid |
//! | [`measure`] | the initial probability, and the one-form whose circulation measures it |
//! | `share` | how the initial probability is spread along one orbit |
//! | [`hamiltonian_range`] | which orbits are in the cloud |
//! | [`family`] | integrals over all orbits of the cloud |
//! | [`detail`] | how finely these orbits are resolved |
//! | `tolerance` | how accurate a probability is to be |
//! | `rules`, `adaptive` | quadrature rules, and intervals that are halved where the error is largest |
//! | `at_start` | the moments at `t = 0` |
//! | [`moments`] | moments and the probability above the critical eccentricity |
//! | [`joint`] | the joint density as averages over the bins |
//! | `joint_way` | by which of the two ways the joint density is computed |
//! | `by_blocks`, `block`, `chebyshev_curve` | the way by blocks of bins on which the backward flow is one polynomial |
//! | `by_orbits` | the way by orbits, which works however long the cloud has been wound up |
//! | `self_check` | the check against orbits that start at random |
//! | [`over_leaves`] | integrals over an uncertain radiation parameter |
//! | [`leaves`] | the exact density where the radiation parameter is uncertain |
//! | `leaves_density`, `leaves_joint` | its density at points, and its joint density from these |
//! | `bin_averages` | averages over bins of a function that is known at points |

mod adaptive;
mod at_start;
pub(crate) mod axis;
mod bin_averages;
mod block;
mod by_blocks;
mod by_orbits;
mod chebyshev_curve;
pub(crate) mod contour;
mod crossings;
pub(crate) mod detail;
pub(crate) mod family;
pub(crate) mod hamiltonian_range;
pub mod joint;
mod joint_way;
pub mod leaves;
mod leaves_density;
mod leaves_joint;
pub mod measure;
pub mod moments;
pub(crate) mod over_leaves;
mod rules;
mod self_check;
mod share;
mod tolerance;
mod trail;

use crate::angle::Circular;
use crate::estimate::{Estimate, Moments};
use crate::flow::{Escaped, Flow};
use crate::grid::Grid;
use crate::model::parameter::Parameter;
use crate::model::planar::SrpJ2;
use crate::model::plane::{PlanarHamiltonian, State};
use crate::problem::Problem;

pub(crate) use contour::angle_of;
use detail::Detail;
use family::Family;
use joint::Joint;
use measure::Measure;
use moments::SmoothMoments;
pub use self_check::Check;
pub(crate) use tolerance::{PROBABILITY_ERROR, ProbabilityTolerance};

/// Required accuracy of the reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExactSettings {
    /// Target for the error of the moments, in standard deviations (or products of them).
    pub moment_error: f64,
    /// Target for the L1 error of the joint density.
    pub joint_error: f64,
    /// Largest number of orbits for each of the moments, the probability above the critical eccentricity, the joint
    /// density and the first-passage curve. The error reached is reported.
    pub most_orbits: usize,
    /// Error estimates above which figures are withheld.
    pub limits: Limits,
}

impl Default for ExactSettings {
    fn default() -> Self {
        Self { moment_error: 1e-8, joint_error: 2e-4, most_orbits: 30_000, limits: Limits::default() }
    }
}

/// Error estimates above which a quantity is withheld.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Limit for the moments, in standard deviations (or products of them).
    pub moments: f64,
    /// Limit for probabilities.
    pub probability: f64,
    /// Limit for the L1 error of the joint density.
    pub joint: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { moments: 1e-3, probability: 1e-3, joint: 1e-2 }
    }
}

/// What can be wrong with a request.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// An orbit could not be followed.
    #[error(transparent)]
    Escaped(#[from] Escaped),
    /// No such snapshot.
    #[error("there is no snapshot {index}: the problem has {snapshots} times and the comparison {grids} grids")]
    NoSuchSnapshot {
        /// The snapshot that was asked for.
        index: usize,
        /// Number of times of the problem.
        snapshots: usize,
        /// Number of comparison grids given.
        grids: usize,
    },
    /// The eccentricity of the model's orbits does not rise once and fall once in every period.
    #[error(
        "the exact density needs a planar model whose eccentricity grows wherever e sin(phi) > 0, and that with {model} is none: the pull \
         towards the Sun must outweigh all else that drives the eccentricity; mc, dee and gmm-ut have no such limit"
    )]
    EccentricityTurnsBack {
        /// The model's parameters.
        model: String,
    },
    /// The computed density contradicts orbits of the flow.
    #[error("the exact density contradicts a sample of orbits: {0}")]
    Contradicted(Check),
}

/// A number with an estimate of its error.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Estimated {
    /// The number.
    pub value: f64,
    /// Estimate of its absolute error.
    pub error: f64,
}

/// The exact density at one snapshot.
#[derive(Debug, Clone, PartialEq)]
pub struct ExactSnapshot {
    /// Density, marginals and moments; NaN where they are withheld.
    pub estimate: Estimate,
    /// Error estimate of the moments, in standard deviations (or products of them).
    pub moment_error: f64,
    /// Error estimate of the mean of `(cos phi, sin phi)`.
    pub circular_error: f64,
    /// Error estimate of the probability above the critical eccentricity, absolute.
    pub probability_error: f64,
    /// Estimate of the L1 error of the joint density.
    pub joint_error: f64,
    /// Probability outside the comparison grid.
    pub mass_outside: f64,
}

impl ExactSnapshot {
    /// The figures of which the error estimates are within the limits; the others are withheld.
    fn new(grid: Grid, moments: &SmoothMoments, probability: Estimated, joint: Joint, limits: Limits) -> Self {
        let stands = |error: f64, limit: f64| error <= limit;
        let (phi_stands, e_stands) = (stands(moments.error, limits.moments), stands(moments.e_error, limits.moments));
        let or_nan = |stands: bool, value: f64| if stands { value } else { f64::NAN };
        let table = Moments {
            mean_phi: or_nan(phi_stands, moments.mean_phi),
            std_phi: or_nan(phi_stands, moments.std_phi),
            mean_e: or_nan(e_stands, moments.mean_e),
            std_e: or_nan(e_stands, moments.std_e),
            cov_phi_e: or_nan(phi_stands, moments.cov_phi_e),
            prob_above_critical_e: or_nan(stands(probability.error, limits.probability), probability.value),
        };
        let mut circular = moments.circular;
        if !stands(moments.circular_error, limits.moments) {
            (circular.mean, circular.resultant) = (f64::NAN, f64::NAN);
        }
        let mut density = joint.density;
        if !stands(joint.error, limits.joint) {
            density.fill(f64::NAN);
        }
        let estimate = Estimate::from_joint(grid, density, table, circular);
        Self {
            estimate,
            moment_error: if phi_stands { moments.error } else { moments.error.max(moments.e_error) },
            circular_error: moments.circular_error,
            probability_error: probability.error,
            joint_error: joint.error,
            mass_outside: joint.mass_outside,
        }
    }

    /// A snapshot of which everything is withheld.
    fn withheld(grid: Grid) -> Self {
        let moments = Moments::from_array([f64::NAN; 6]);
        let circular = Circular { mean: f64::NAN, resultant: f64::NAN };
        let [moment_error, circular_error, probability_error, joint_error] = [f64::INFINITY; 4];
        let estimate = Estimate::from_joint(grid, vec![f64::NAN; grid.len()], moments, circular);
        Self { estimate, moment_error, circular_error, probability_error, joint_error, mass_outside: 1.0 }
    }
}

/// The exact density of a problem.
#[derive(Debug)]
pub struct Exact<'a, M = SrpJ2> {
    problem: &'a Problem<M>,
    flow: &'a Flow<M>,
    settings: ExactSettings,
    family: Family<M>,
}

impl<'a, M: PlanarHamiltonian> Exact<'a, M> {
    /// The exact density of `problem`, carried by `flow`.
    pub fn new(problem: &'a Problem<M>, flow: &'a Flow<M>, settings: ExactSettings) -> Self {
        let family = Family::new(flow, Measure::new(problem.initial), problem.critical_e, Detail::FINE);
        Self { problem, flow, settings, family }
    }

    /// All figures of snapshot `index`, on its comparison grid.
    ///
    /// # Errors
    /// [`Error`] if there is no such snapshot, or if the result contradicts a sample of orbits. If orbits of the cloud
    /// cannot be followed to the end, as near `e = 1`, everything is withheld.
    pub fn snapshot(&self, grids: &[Grid], index: usize) -> Result<ExactSnapshot, Error> {
        let (snapshots, grids_given) = (self.problem.times.len(), grids.len());
        let missing = Error::NoSuchSnapshot { index, snapshots, grids: grids_given };
        let (Some(&years), Some(grid)) = (self.problem.times.get(index), grids.get(index)) else { return Err(missing) };
        is_possible(&self.flow.model)?;
        // If orbits of the cloud cannot be followed, nothing is known of the cloud.
        let Ok(check) = self_check::Sample::new(self.problem, self.flow, years) else {
            return Ok(ExactSnapshot::withheld(*grid));
        };
        let (moments, probability) = (self.moments(years)?, self.probability_above(self.problem.critical_e, years)?);
        let ExactSettings { joint_error, most_orbits, .. } = self.settings;
        let joint = joint_way::joint(&self.family, grid, years, joint_error, most_orbits);
        let snapshot = ExactSnapshot::new(*grid, &moments, probability, joint, self.settings.limits);
        check.agrees(&snapshot.estimate)?;
        Ok(snapshot)
    }

    /// Moments after `years`.
    ///
    /// # Errors
    /// [`Error`] if the model's orbits do not fit the method.
    pub fn moments(&self, years: f64) -> Result<moments::SmoothMoments, Error> {
        is_possible(&self.flow.model)?;
        if years == 0.0 {
            return Ok(at_start::moments(&self.problem.initial));
        }
        let ExactSettings { moment_error, most_orbits, .. } = self.settings;
        Ok(moments::smooth_moments(&self.family, years, moment_error, most_orbits))
    }

    /// Probability that the eccentricity exceeds `critical_e` after `years`.
    ///
    /// # Errors
    /// [`Error`] if the model's orbits do not fit the method.
    pub fn probability_above(&self, critical_e: f64, years: f64) -> Result<Estimated, Error> {
        is_possible(&self.flow.model)?;
        if years == 0.0 {
            let value = self.problem.initial.probability_above(critical_e);
            return Ok(Estimated { value, error: f64::EPSILON });
        }
        let most_orbits = self.settings.most_orbits;
        let tolerance = ProbabilityTolerance::RareToo(PROBABILITY_ERROR);
        Ok(moments::probability_above(&self.family, critical_e, years, tolerance, most_orbits))
    }

    /// Density at the points `(phi[i], e[i])` after `years` \[1/rad\]. Each point is carried back to `t = 0`. The
    /// density is zero where `e` is outside `0 < e < 1`.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn density(&self, phi: &[f64], e: &[f64], years: f64) -> Vec<f64> {
        assert_eq!(phi.len(), e.len(), "one phi for every e");
        let inside = |e: f64| e > 0.0 && e < 1.0;
        let ends: Vec<State> =
            phi.iter().zip(e).map(|(&phi, &e)| State::from_polar(phi, if inside(e) { e } else { 0.0 })).collect();
        let (mut x1, mut x2): (Vec<f64>, Vec<f64>) = ends.iter().map(|state| (state.x1, state.x2)).unzip();
        self.flow.advance_where_possible(&mut x1, &mut x2, -years);
        let start = |i: usize| State { x1: x1[i], x2: x2[i] };
        let measure = &self.family.measure;
        let at = |i: usize| if inside(e[i]) { measure.density_after(start(i), ends[i]) } else { 0.0 };
        (0..ends.len()).map(at).collect()
    }
}

/// Whether the orbits of a model fit the method of this module.
///
/// # Errors
/// [`Error::EccentricityTurnsBack`] if they do not.
pub fn is_possible(model: &impl PlanarHamiltonian) -> Result<(), Error> {
    if model.eccentricity_follows_x1() {
        Ok(())
    } else {
        let stated = |(parameter, value): (Parameter, f64)| format!("{} = {value}", parameter.symbol);
        let parameters: Vec<String> = model.parameters().into_iter().map(stated).collect();
        Err(Error::EccentricityTurnsBack { model: parameters.join(", ") })
    }
}

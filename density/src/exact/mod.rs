//! The exact density: no sampling, no interpolation between samples, no mixture; every number with an estimate of its error.
//!
//! Liouville's theorem gives the density at any point in closed form from the orbit through it
//! ([`crate::dynamics::density_growth`]), and turns probabilities of regions into integrals along their borders carried
//! back to `t = 0` ([`measure`]). Hence, at any snapshot and independently of all others:
//!
//! - [`Exact::density`]: the density at points;
//! - [`moments`]: moments by adaptive quadrature over the initial Gaussian;
//! - [`pullback`]: the probability above the critical eccentricity, from the circle `e = e_crit` carried back;
//! - [`joint`]: bin averages of the joint density on the comparison grid.
//!
//! The marginals are the sums of the joint's rows and columns, as those of every other method: they miss what lies outside
//! the grid, [`ExactSnapshot::mass_outside`].

mod block;
mod branch_cut;
mod contour;
pub mod joint;
mod kronrod;
pub mod measure;
pub mod moments;
mod panel;
pub mod pullback;

use crate::dynamics::State;
use crate::estimate::{Estimate, Moments};
use crate::flow::{Escaped, Flow};
use crate::grid::Grid;
use crate::problem::Problem;

use measure::{Measure, Side};
use pullback::{Quadrature, circulation_and_turns};

/// How accurate the reference is to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Tolerated error of the moments, in standard deviations (or products of them).
    pub moment_error: f64,
    /// Tolerated L1 error of the joint density.
    pub joint_error: f64,
    /// Orbits that moments, and likewise the joint density, may take at one snapshot; the error reached is reported.
    pub most_orbits: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { moment_error: 1e-8, joint_error: 1e-4, most_orbits: 400_000 }
    }
}

/// What can be wrong with a request.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// An orbit left the domain.
    #[error(transparent)]
    Escaped(#[from] Escaped),
    /// No such snapshot.
    #[error("there is no snapshot {index}: the problem has {snapshots} times and the comparison {grids} grids")]
    NoSuchSnapshot {
        /// The one asked for.
        index: usize,
        /// Times of the problem.
        snapshots: usize,
        /// Comparison grids given.
        grids: usize,
    },
}

/// The exact density at one snapshot.
#[derive(Debug, Clone, PartialEq)]
pub struct ExactSnapshot {
    /// Density, marginals and moments.
    pub estimate: Estimate,
    /// Error estimate of the moments, in standard deviations (or products of them).
    pub moment_error: f64,
    /// Error estimate of the mean of `(cos phi, sin phi)`.
    pub circular_error: f64,
    /// Error estimate of the probability above the critical eccentricity, absolute.
    pub probability_error: f64,
    /// Estimate of the L1 error of the joint density.
    pub joint_error: f64,
    /// Probability outside the comparison grid, from the grid's border.
    pub mass_outside: f64,
}

/// The exact density of a problem.
#[derive(Debug, Clone)]
pub struct Exact<'a> {
    problem: &'a Problem,
    flow: &'a Flow,
    settings: Settings,
    measure: Measure,
}

impl<'a> Exact<'a> {
    /// The exact density of `problem`, carried by `flow`.
    pub fn new(problem: &'a Problem, flow: &'a Flow, settings: Settings) -> Self {
        Self { problem, flow, settings, measure: Measure::new(problem.initial) }
    }

    /// Everything at snapshot `index` on its comparison grid.
    ///
    /// # Errors
    /// [`Error`] if there is no such snapshot, or an orbit of the cloud or the grid's border leaves `e < 1`.
    pub fn snapshot(&self, grids: &[Grid], index: usize) -> Result<ExactSnapshot, Error> {
        let (snapshots, grids_given) = (self.problem.times.len(), grids.len());
        let missing = Error::NoSuchSnapshot { index, snapshots, grids: grids_given };
        let (Some(&years), Some(grid)) = (self.problem.times.get(index), grids.get(index)) else { return Err(missing) };
        let (moments, probability) = (self.moments(years)?, self.probability_above(self.problem.critical_e, years)?);
        let Settings { joint_error, most_orbits, .. } = self.settings;
        let joint = joint::joint(self.flow, &self.measure, grid, years, joint_error, most_orbits)?;
        let table = Moments {
            mean_phi: moments.mean_phi,
            std_phi: moments.std_phi,
            mean_e: moments.mean_e,
            std_e: moments.std_e,
            cov_phi_e: moments.cov_phi_e,
            prob_above_critical_e: probability.value,
        };
        Ok(ExactSnapshot {
            estimate: Estimate::from_joint(*grid, joint.density, table, moments.circular),
            moment_error: moments.error,
            circular_error: moments.circular_error,
            probability_error: probability.error,
            joint_error: joint.error,
            mass_outside: 1.0 - joint.mass_inside.value,
        })
    }

    /// Moments after `years`.
    ///
    /// # Errors
    /// [`Escaped`] if an orbit of the cloud leaves `e < 1`.
    pub fn moments(&self, years: f64) -> Result<moments::SmoothMoments, Escaped> {
        let Settings { moment_error, most_orbits, .. } = self.settings;
        moments::smooth_moments(self.flow, &self.measure, years, moment_error, most_orbits)
    }

    /// Probability that the eccentricity exceeds `critical_e` after `years`.
    ///
    /// # Errors
    /// [`Escaped`] if an orbit of the circle `e = critical_e` cannot be followed back.
    pub fn probability_above(&self, critical_e: f64, years: f64) -> Result<Quadrature, Escaped> {
        let circle = |s: f64| (State::from_polar(s * std::f64::consts::TAU, critical_e), years);
        let (around, turns) = circulation_and_turns(self.flow, &self.measure, Side::Above, circle)?;
        let origin = self.flow.advance_one(State { x1: 0.0, x2: 0.0 }, years)?;
        let winding = f64::from(origin.eccentricity() < critical_e);
        Ok(Quadrature { value: ((1.0 - winding + turns) + around.value).clamp(0.0, 1.0), error: around.error })
    }

    /// Density at the points `(phi[i], e[i])` after `years` \[1/rad\]: each is carried back to `t = 0`. Zero where `e` is
    /// outside `0 < e < 1`.
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
        let at = |i: usize| if inside(e[i]) { self.measure.density_after(start(i), ends[i]) } else { 0.0 };
        (0..ends.len()).map(at).collect()
    }
}

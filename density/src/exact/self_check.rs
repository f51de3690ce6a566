//! A check of the exact density against a sample of orbits.
//!
//! The check shares only the equations of motion with the exact density: the sample is drawn from the initial Gaussian,
//! and the integrator carries every orbit of it to the snapshot.

use std::f64::consts::TAU;
use std::fmt;

use crate::angle::{Circular, nearest};
use crate::estimate::{Estimate, ordered_sum};
use crate::flow::{Escaped, Flow};
use crate::model::plane::{PlanarHamiltonian, State};
use crate::problem::Problem;
use crate::sampling;

/// Number of orbits of the sample.
pub(super) const ORBITS: usize = 2000;
/// Seed of the sample: any would do.
pub(super) const SEED: u64 = 20_220_601;
/// Number of standard errors beyond which a difference is not chance: its probability is 1e-8 in a normal distribution.
const CHANCE: f64 = 6.0;
/// Number of orbits by which the count in a small part of the cloud may be off.
const UNSEEN: f64 = 10.0;

/// A sample of orbits at a snapshot.
pub(super) struct Sample {
    states: Vec<State>,
    critical_e: f64,
}

/// A quantity in which a sample and the exact density differ by more than chance allows.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// What differs.
    pub quantity: &'static str,
    /// The exact value.
    pub exact: f64,
    /// The sample's value.
    pub sampled: f64,
    /// The standard error of the sample's value.
    pub standard_error: f64,
}

/// A quantity, its exact value, the function whose sample mean it is, and how far apart two values of the function can
/// be.
type Comparison<'a> = (&'static str, f64, &'a dyn Fn(&State) -> f64, f64);

impl fmt::Display for Check {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { quantity, exact, sampled, standard_error } = self;
        write!(
            f,
            "{quantity} is {exact}, but a sample of {ORBITS} orbits has {sampled}, with a standard error of {standard_error:.1e}"
        )
    }
}

impl Sample {
    pub(super) fn new<M: PlanarHamiltonian>(problem: &Problem<M>, flow: &Flow<M>, years: f64) -> Result<Self, Escaped> {
        let (mut x1, mut x2) = sampling::draw(&problem.initial, SEED, ORBITS);
        flow.advance(&mut x1, &mut x2, years)?;
        Ok(Self::of(&x1, &x2, problem.critical_e))
    }

    /// Orbits in these states.
    pub(super) fn of(x1: &[f64], x2: &[f64], critical_e: f64) -> Self {
        Self { states: x1.iter().zip(x2).map(|(&x1, &x2)| State { x1, x2 }).collect(), critical_e }
    }

    /// Compares an estimate with the sample; withheld values agree with anything.
    pub(super) fn agrees(&self, found: &Estimate) -> Result<(), super::Error> {
        let moments = found.moments;
        let Circular { mean, resultant } = found.circular;
        let along = |state: &State| (state.solar_angle() - mean).cos();
        let aside = |state: &State| (state.solar_angle() - mean).sin();
        let above = |state: &State| f64::from(state.eccentricity() > self.critical_e);
        let angle = |state: &State| nearest(state.solar_angle(), mean);
        let square = |state: &State| (state.eccentricity() - moments.mean_e).powi(2);
        let direction = if mean.is_nan() { f64::NAN } else { 0.0 };
        let comparisons: [Comparison<'_>; 6] = [
            ("the resultant length of phi", resultant, &along, 2.0),
            ("the mean of sin(phi - circular mean)", direction, &aside, 2.0),
            ("the mean of phi on the branch of its circular mean", moments.mean_phi, &angle, TAU),
            ("the mean of e", moments.mean_e, &|state| state.eccentricity(), 1.0),
            ("the variance of e", moments.std_e.powi(2), &square, 1.0),
            ("the probability above the critical eccentricity", moments.prob_above_critical_e, &above, 1.0),
        ];
        for (quantity, exact, function, range) in comparisons {
            let (sampled, standard_error) = self.mean(function);
            // A few orbits may be missing from a part of the cloud that is too small to show in the standard error.
            if (sampled - exact).abs() > CHANCE * standard_error + range * UNSEEN / ORBITS as f64 {
                let check = Check { quantity, exact, sampled, standard_error };
                return Err(super::Error::Contradicted(check));
            }
        }
        Ok(())
    }

    /// The sample's mean of a function and its standard error.
    fn mean(&self, function: &dyn Fn(&State) -> f64) -> (f64, f64) {
        let values: Vec<f64> = self.states.iter().map(function).collect();
        let count = values.len() as f64;
        let [sum] = ordered_sum(values.len(), |i| [values[i]]);
        let [squares] = ordered_sum(values.len(), |i| [(values[i] - sum / count).powi(2)]);
        (sum / count, (squares / count / count).sqrt())
    }
}

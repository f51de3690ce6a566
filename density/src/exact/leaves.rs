//! The exact density where the radiation parameter is uncertain: means over the parameter of what is exact for each of
//! its values.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::flow::{Accuracy, Flow};
use crate::grid::Grid;
use crate::model::Model;
use crate::model::registry::Planar;
use crate::model::uncertain_radiation::{Scale, UncertainRadiation};
use crate::orbits::Orbits;
use crate::problem::Problem;
use crate::sampling::draw_variables;
use crate::uncertain::{ThirdMoments, UncertainProblem, UncertainTask};

use super::detail::Detail;
use super::family::{Family, Integrals};
use super::measure::Measure;
use super::moments::{self, Centre, FIRST, Noise, SECOND, SmoothMoments};
use super::over_leaves::{LeafPanel, LeafValues, OverLeaves, eased, integrate};
use super::{
    Error, Estimated, Exact, ExactSettings, ExactSnapshot, PROBABILITY_ERROR, ProbabilityTolerance, is_possible,
    leaves_joint, self_check,
};

/// Factor by which moments may be less accurate than without the uncertainty, for the sake of the cost.
const COARSER: f64 = 1_000.0;
/// The same for probabilities.
const COARSER_PROBABILITY: f64 = 10_000.0;
/// Factor by which the centre of the moments may be less accurate than the moments.
const FOR_CENTRE: f64 = 30.0;
/// Factor by which the joint density may be less accurate.
const COARSER_JOINT: f64 = 5.0;
/// Largest number of leaves whose orbits are kept.
const MOST_KEPT: usize = 150;
/// Largest number of leaves for each integral.
const MOST_LEAVES: usize = 1_500;

/// The exact density of a problem with an uncertain radiation parameter.
#[derive(Debug)]
pub struct ExactLeaves {
    problem: UncertainProblem,
    accuracy: Accuracy,
    settings: ExactSettings,
    /// The orbits of the leaves that have been needed, by the bits of their `z`.
    families: Mutex<HashMap<u64, Arc<Family<Planar>>>>,
}

/// The exact density at one snapshot.
#[derive(Debug, Clone, PartialEq)]
pub struct LeavesSnapshot {
    /// Density and moments in `(phi, e)`.
    pub plane: ExactSnapshot,
    /// Moments of the third variable; those with `phi` and `e` are NaN where the moments of `phi` and `e` are withheld.
    pub third: ThirdMoments,
}

impl ExactLeaves {
    /// The exact density of `problem`, with orbits of this accuracy.
    pub fn new(problem: UncertainProblem, accuracy: Accuracy, settings: ExactSettings) -> Self {
        Self { problem, accuracy, settings, families: Mutex::default() }
    }

    /// The problem.
    pub fn problem(&self) -> &UncertainProblem {
        &self.problem
    }

    /// Largest number of orbits of a leaf for each integral.
    pub(crate) fn most_orbits(&self) -> usize {
        self.settings.most_orbits
    }

    /// All figures of snapshot `index`, on its comparison grid.
    ///
    /// # Errors
    /// As [`Exact::snapshot`].
    pub fn snapshot(&self, grids: &[Grid], index: usize) -> Result<LeavesSnapshot, Error> {
        let plane = &self.problem.plane;
        let (snapshots, given) = (plane.times.len(), grids.len());
        let missing = Error::NoSuchSnapshot { index, snapshots, grids: given };
        let (Some(&years), Some(&grid)) = (plane.times.get(index), grids.get(index)) else { return Err(missing) };
        if years == 0.0 {
            // The parameter has not acted yet.
            let flow = Flow { model: plane.model, accuracy: self.accuracy };
            let plane = Exact::new(plane, &flow, self.settings).snapshot(grids, index)?;
            return Ok(LeavesSnapshot { plane, third: ThirdMoments::at_start(&self.problem) });
        }
        let sample = self.problem.perform(Sampled { problem: &self.problem, accuracy: self.accuracy, years });
        let Some(sample) = sample else {
            let unknown =
                ThirdMoments { with_phi: f64::NAN, with_e: f64::NAN, ..ThirdMoments::at_start(&self.problem) };
            return Ok(LeavesSnapshot { plane: ExactSnapshot::withheld(grid), third: unknown });
        };
        let (moments, probability, third) = self.moments(years)?;
        let joint = leaves_joint::joint(&self.problem, &grid, years, COARSER_JOINT * self.settings.joint_error);
        let snapshot = ExactSnapshot::new(grid, &moments, probability, joint, self.settings.limits);
        sample.agrees(&snapshot.estimate)?;
        let or_nan = |value: f64, by: f64| if by.is_nan() { f64::NAN } else { value };
        let stated = snapshot.estimate.moments;
        let third = ThirdMoments {
            with_phi: or_nan(third.with_phi, stated.mean_phi),
            with_e: or_nan(third.with_e, stated.mean_e),
            ..third
        };
        Ok(LeavesSnapshot { plane: snapshot, third })
    }

    /// Moments, the probability above the critical eccentricity, and the moments of the third variable after `years`.
    ///
    /// # Errors
    /// [`Error`] if the model's orbits do not fit the method at any value of the parameter.
    pub fn moments(&self, years: f64) -> Result<(SmoothMoments, Estimated, ThirdMoments), Error> {
        let Self { problem, settings, .. } = self;
        let tolerance = COARSER * settings.moment_error;
        let noise = Noise::of(years, self.accuracy);
        let critical_e = problem.plane.critical_e;
        // The centre about which moments are taken may be off by more: they are corrected for its error.
        let of_centre = FOR_CENTRE * tolerance;
        let first = integrate(
            problem,
            FIRST,
            |leaf, z, density| {
                self.on_leaf(leaf, z, |family| {
                    let sums = moments::first_pass(family, years, eased(of_centre, density), settings.most_orbits);
                    LeafValues { values: sums.values, errors: sums.errors }
                })
            },
            |panel, values| {
                let spread = |first: f64, second: f64| (second - first * first).max(1e-30).sqrt();
                let e = spread(values[3] / values[0], values[4] / values[0]);
                let phi = spread((values[1] * values[1] + values[2] * values[2]).sqrt() / values[0], 1.0).max(1e-6);
                largest_share(panel, &[1.0, phi, phi, e, e].map(|scale| of_centre * scale))
            },
            MOST_LEAVES,
        )?;
        let coarse = as_integrals(&first, FIRST);
        let centre = Centre::of(&coarse.values);
        let third_start = ThirdMoments::at_start(problem);
        let second = integrate(
            problem,
            SECOND + 3,
            |leaf, z, density| {
                self.on_leaf(leaf, z, |family| {
                    let here = (eased(tolerance, density), settings.most_orbits);
                    let Integrals { mut values, mut errors, .. } =
                        moments::second_pass(family, years, centre, family.first_intervals(), here);
                    let off = third_of(problem, z) - third_start.mean;
                    let tolerance =
                        ProbabilityTolerance::Absolute(eased(COARSER_PROBABILITY * PROBABILITY_ERROR, density));
                    let above = moments::probability_above(family, critical_e, years, tolerance, settings.most_orbits);
                    values.extend([off * values[5], off * values[3], above.value]);
                    errors.extend([off.abs() * errors[5], off.abs() * errors[3], above.error]);
                    LeafValues { values, errors }
                })
            },
            |panel, values| {
                let scales = moments::scales(values);
                let third = [scales[5], scales[3]].map(|scale| scale * third_start.deviation);
                let moments = scales.iter().chain(&third).map(|scale| tolerance * scale);
                let tolerances: Vec<f64> = moments.chain([COARSER_PROBABILITY * PROBABILITY_ERROR]).collect();
                largest_share(panel, &tolerances)
            },
            MOST_LEAVES,
        )?;
        let fine = as_integrals(&second, SECOND);
        let values = second.values();
        let mean = |f: usize| values[f] / values[0];
        // The centre of the third variable is its mean.
        let third = ThirdMoments { with_phi: mean(SECOND), with_e: mean(SECOND + 1), ..third_start };
        let above = SECOND + 2;
        let probability = Estimated { value: values[above].clamp(0.0, 1.0), error: second.errors()[above] };
        Ok((moments::finish(&coarse, &fine, centre, noise), probability, third))
    }

    /// What `read` finds of the orbits of a leaf; nothing if they do not fit the method.
    pub(crate) fn on_leaf<T>(
        &self,
        leaf: &Problem<Planar>,
        z: f64,
        read: impl Fn(&Family<Planar>) -> T,
    ) -> Result<Option<T>, Error> {
        if is_possible(&leaf.model).is_err() {
            return is_possible(&self.problem.plane.model).map(|()| None);
        }
        let known = |families: &mut HashMap<u64, Arc<Family<Planar>>>| families.get(&z.to_bits()).cloned();
        let family = self.with_families(known).unwrap_or_else(|| {
            let flow = Flow { model: leaf.model, accuracy: self.accuracy };
            let family = Arc::new(Family::new(&flow, Measure::new(leaf.initial), leaf.critical_e, Detail::COARSE));
            self.with_families(|families| {
                if families.len() < MOST_KEPT {
                    families.insert(z.to_bits(), family.clone());
                }
            });
            family
        });
        Ok(Some(read(&family)))
    }

    fn with_families<T>(&self, read: impl FnOnce(&mut HashMap<u64, Arc<Family<Planar>>>) -> T) -> T {
        read(&mut self.families.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// The value of the third variable at `z`.
fn third_of(problem: &UncertainProblem, z: f64) -> f64 {
    let (mean, sigma) = problem.third();
    mean + sigma * z
}

/// The largest share that a panel has in any tolerated error.
fn largest_share(panel: &LeafPanel, tolerances: &[f64]) -> f64 {
    panel.errors().zip(tolerances).map(|(error, tolerance)| error / tolerance).fold(0.0, f64::max)
}

/// The first `count` integrals, as those over the orbits of one plane.
fn as_integrals(found: &OverLeaves, count: usize) -> Integrals {
    let (mut values, mut errors) = (found.values(), found.errors());
    values.truncate(count);
    errors.truncate(count);
    Integrals { values, errors, lost: usize::from(found.lost() > 0.0), orbits: 0, intervals: Vec::new() }
}

/// Draws orbits with different parameters, carried by the integrator, to check the exact density with.
struct Sampled<'a> {
    problem: &'a UncertainProblem,
    accuracy: Accuracy,
    years: f64,
}

impl UncertainTask for Sampled<'_> {
    type Output = Option<self_check::Sample>;

    fn with<S: Scale>(self, model: UncertainRadiation<S>) -> Self::Output {
        let variables = UncertainRadiation::<S>::VARIABLES;
        let start = draw_variables(&self.problem.gaussian(), variables, self_check::SEED, 0..self_check::ORBITS);
        let mut orbits =
            Orbits::from_variables(Flow { model, accuracy: self.accuracy }, &start.each_ref().map(Vec::as_slice));
        orbits.advance_to(self.years).ok()?;
        let [x1, x2, _] = orbits.columns() else { return None };
        Some(self_check::Sample::of(x1, x2, self.problem.plane.critical_e))
    }
}

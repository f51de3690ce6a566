//! The questions of a disposal designer about a cloud in space, answered by randomised quasi-Monte Carlo.
//!
//! There is no exact curve in space. Every figure is that of the same orbits by their numbers ([`super::draws`]), so
//! that two clouds that differ in a parameter differ by its effect alone (common random numbers), and every figure has
//! a 95 % interval from the spread of replicates that are independent of one another (Owen, *Monte Carlo theory,
//! methods and examples*, 2013, Chapter 17).

use std::num::NonZeroUsize;

use super::draws::{Distributed, Start};
use super::task::SpaceTask;
use super::{InitialInSpace, SpaceProblem};
use crate::disposal::time_of;
use crate::first_passage::empirical::{EmpiricalCurve, curve_of_groups, point, student_quantile};
use crate::flow::{Accuracy, Flow};
use crate::gaussian::Gaussian;
use crate::model::unfolded::{InSpace, Unfolded};
use crate::model::{Coordinates, Model};
use crate::problem_error::ProblemError;
use crate::sampling::{Draws, SamplingPlan, group};
use crate::uncertain::Spread;

/// Independent replicates, from whose spread the intervals follow.
pub const REPLICATES: usize = 16;
/// Least and largest factor on the radiation parameter that is looked at.
pub const FACTORS: (f64, f64) = (0.1, 10.0);

/// How many orbits a figure takes, and which.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Orbits of each replicate; a power of two.
    pub orbits: usize,
    /// Seed of the scrambles.
    pub seed: u64,
}

/// A figure with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounded {
    /// The figure.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// Why there is no figure.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Trouble {
    /// The problem has no answer by these methods.
    #[error("{0}")]
    Problem(#[from] ProblemError),
    /// Orbits that cannot be followed, and have not passed before.
    #[error(
        "{lost} of {orbits} orbits cannot be followed to {years} yr and have not re-entered before, so that nothing is known of them; \
         end the scenario earlier"
    )]
    Lost {
        /// How many.
        lost: usize,
        /// Of how many.
        orbits: usize,
        /// The end \[yr\].
        years: f64,
    },
}

/// The probability of re-entry by each of the ascending `times` \[yr\].
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// The times.
    pub times: Vec<f64>,
    /// The probabilities.
    pub probability: Vec<Bounded>,
}

impl Curve {
    /// The time by which a probability is reached. An end of the interval is infinite where the curve's own interval
    /// leaves open whether the probability is reached at all; `None` if it is not reached.
    pub fn time_of(&self, probability: f64) -> Option<Bounded> {
        let along = |of: fn(&Bounded) -> f64| -> Vec<(f64, f64)> {
            self.times.iter().copied().zip(self.probability.iter().map(of)).collect()
        };
        let value = time_of(&along(|p| p.value), probability)?;
        let low = time_of(&along(|p| p.high), probability).unwrap_or(value);
        let high = time_of(&along(|p| p.low), probability).unwrap_or(f64::INFINITY);
        Some(Bounded { value, low, high })
    }
}

/// The curve of a cloud.
///
/// # Errors
/// [`Trouble`].
pub fn curve(problem: &SpaceProblem, effort: Effort, times: &[f64]) -> Result<Curve, Trouble> {
    let passages = passages(problem, effort, times.last().copied().unwrap_or(0.0))?;
    let points = passages.iter().map(|&passage| point(passage, times));
    let EmpiricalCurve { probability, interval, .. } = curve_of_groups(points, REPLICATES, times);
    let intervals = interval.unwrap_or_default();
    let bounded = |(&value, &(low, high)): (&f64, &(f64, f64))| Bounded { value, low, high };
    Ok(Curve { times: times.to_vec(), probability: probability.iter().zip(&intervals).map(bounded).collect() })
}

/// When each orbit passes \[yr\]; infinite for one that does not within these years.
fn passages(problem: &SpaceProblem, effort: Effort, years: f64) -> Result<Vec<f64>, Trouble> {
    let replicates = NonZeroUsize::new(REPLICATES).unwrap_or(NonZeroUsize::MIN);
    let plan = SamplingPlan { draws: Draws::Sobol, seed: effort.seed, replicates };
    let draw = Distributed::of(problem)?.draw(&plan);
    let starts: Vec<Start> = (0..effort.orbits * REPLICATES).map(draw).collect();
    let found = problem.perform(Watched { starts: &starts, critical: problem.critical_e, years })?;
    let lost = found.iter().filter(|time| time.is_nan()).count();
    match lost {
        0 => Ok(found),
        _ => Err(Trouble::Lost { lost, orbits: starts.len(), years }),
    }
}

/// Orbits that are watched until the end.
struct Watched<'a> {
    starts: &'a [Start],
    critical: f64,
    years: f64,
}

impl SpaceTask for Watched<'_> {
    type Output = Vec<f64>;

    fn with<M: InSpace<N>, const N: usize>(self, model: Unfolded<M, N>, _: Gaussian<N>) -> Vec<f64> {
        let mut columns = vec![Vec::with_capacity(self.starts.len()); M::State::<f64>::COUNT];
        for Start { variables, radiation, .. } in self.starts {
            let state = model.state(0.0, std::array::from_fn(|k| variables.get(k).copied().unwrap_or(*radiation)));
            columns.iter_mut().enumerate().for_each(|(k, column)| column.push(state.component(k)));
        }
        let (mut times, mut lowest) = (vec![f64::INFINITY; self.starts.len()], vec![f64::INFINITY; self.starts.len()]);
        let mut columns: Vec<&mut [f64]> = columns.iter_mut().map(Vec::as_mut_slice).collect();
        let flow = Flow { model, accuracy: Accuracy::Coarse };
        flow.carry_approaching(&mut columns, (0.0, self.years), self.critical, &mut times, &mut lowest);
        times
    }
}

/// The probability of each replicate to pass within these years.
fn shares(problem: &SpaceProblem, effort: Effort, years: f64) -> Result<Vec<f64>, Trouble> {
    let mut counts = vec![0.0; REPLICATES];
    for (row, passage) in passages(problem, effort, years)?.into_iter().enumerate() {
        counts[group(row, REPLICATES)] += f64::from(passage <= years);
    }
    Ok(counts.into_iter().map(|count| count / effort.orbits as f64).collect())
}

/// The mean of figures of the replicates, and half the width of its 95 % interval.
fn mean_of(figures: &[f64]) -> (f64, f64) {
    let count = figures.len() as f64;
    let mean = figures.iter().sum::<f64>() / count;
    let squares: f64 = figures.iter().map(|figure| (figure - mean).powi(2)).sum();
    (mean, student_quantile(figures.len() - 1) * (squares / ((count - 1.0) * count)).sqrt())
}

/// The problem with another mean of the radiation parameter, whose relative spread stays the same.
fn with_radiation(problem: &SpaceProblem, factor: f64) -> SpaceProblem {
    let mut changed = problem.clone();
    changed.model.forces_mut().force.radiation *= factor;
    changed
}

/// The least factor on the radiation parameter, and so on the area-to-mass ratio, with which the probability of
/// re-entry by the last snapshot is `probability`: looked for in [`FACTORS`]; `None` if it is not there, or if there is
/// no radiation pressure. The lower end of [`FACTORS`] means that even less may do. Its interval is that of the
/// probability there, over the slope of the probability; infinite where there is no slope.
///
/// # Errors
/// [`Trouble`].
pub fn factor_for(problem: &SpaceProblem, effort: Effort, probability: f64) -> Result<Option<Bounded>, Trouble> {
    const STEPS: u32 = 16;
    const HALVINGS: u32 = 10;
    const APART: f64 = 0.02;
    if problem.model.forces().force.radiation == 0.0 {
        return Ok(None);
    }
    let years = problem.times.last().copied().unwrap_or(0.0);
    let at = |factor: f64| Ok::<_, Trouble>(mean_of(&shares(&with_radiation(problem, factor), effort, years)?));
    let (least, most) = FACTORS;
    let factor = |k: u32| least * (most / least).powf(f64::from(k) / f64::from(STEPS));
    let mut first = None;
    for k in 0..=STEPS {
        if at(factor(k))?.0 >= probability {
            first = Some(k);
            break;
        }
    }
    let Some(first) = first else { return Ok(None) };
    if first == 0 {
        return Ok(Some(Bounded { value: least, low: 0.0, high: least }));
    }
    let (mut low, mut high) = (factor(first - 1), factor(first));
    for _ in 0..HALVINGS {
        let middle = low.midpoint(high);
        if at(middle)?.0 >= probability { high = middle } else { low = middle }
    }
    let (below, here, above) = (at(high * (1.0 - APART))?, at(high)?, at(high * (1.0 + APART))?);
    let slope = (above.0 - below.0) / (2.0 * APART * high);
    let half = if slope > 0.0 { here.1 / slope } else { f64::INFINITY };
    Ok(Some(Bounded { value: high, low: (low - half).max(0.0), high: high + half }))
}

/// What a small change of the cloud does to the probability of re-entry by the last snapshot.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivity {
    /// What is changed, and by how much: `radiation C + 1 %`.
    pub change: String,
    /// By how much the probability then differs.
    pub effect: Bounded,
}

/// The effect of each small change: one percent of a parameter, a tenth of a standard deviation of a mean, ten percent
/// of a standard deviation; the largest effect first.
///
/// # Errors
/// [`Trouble`].
pub fn sensitivities(problem: &SpaceProblem, effort: Effort) -> Result<Vec<Sensitivity>, Trouble> {
    let years = problem.times.last().copied().unwrap_or(0.0);
    let now = shares(problem, effort, years)?;
    let mut found = Vec::new();
    for (change, changed) in changes(problem) {
        let changed = shares(&changed, effort, years)?;
        let (value, half) = mean_of(&changed.iter().zip(&now).map(|(a, b)| a - b).collect::<Vec<_>>());
        found.push(Sensitivity { change, effect: Bounded { value, low: value - half, high: value + half } });
    }
    found.sort_by(|a, b| b.effect.value.abs().total_cmp(&a.effect.value.abs()));
    Ok(found)
}

/// All small changes, in words.
fn changes(problem: &SpaceProblem) -> Vec<(String, SpaceProblem)> {
    let mut all = Vec::new();
    for (parameter, _) in problem.model.force_parameters().into_iter().filter(|(_, value)| *value > 0.0) {
        let mut changed = problem.clone();
        let forces = changed.model.forces_mut();
        *forces = forces.changed(|other, value| if other == parameter { 1.01 * value } else { value });
        all.push((format!("{} {} + 1 %", parameter.name, parameter.symbol), changed));
    }
    for (k, variable) in super::VARIABLES.iter().enumerate().filter(|(k, _)| problem.initial.sigma[*k] > 0.0) {
        let InitialInSpace { mut mean, mut sigma, .. } = problem.initial;
        mean[k] += 0.1 * sigma[k];
        sigma[k] *= 1.1;
        let with = |initial| SpaceProblem { initial, ..problem.clone() };
        let moved = with(InitialInSpace { mean, ..problem.initial });
        let wider = with(InitialInSpace { sigma, ..problem.initial });
        all.push((format!("mean {} + 0.1 sigma", variable.symbol), moved));
        all.push((format!("sigma {} + 10 %", variable.symbol), wider));
    }
    if let Some(Spread { relative, distribution }) = problem.spread {
        let spread = Some(Spread { relative: 1.1 * relative, distribution });
        all.push(("sigma radiation + 10 %".into(), SpaceProblem { spread, ..problem.clone() }));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::example;
    use super::*;
    use crate::disposal::probabilities;
    use crate::problem::Problem;

    const EFFORT: Effort = Effort { orbits: 256, seed: 3 };

    /// The cloud in the equator, whose exact probabilities are those of the planar model.
    fn flat() -> (SpaceProblem, Problem<crate::model::registry::Planar>) {
        example::in_the_equator(0.1, None)
    }

    #[test]
    fn in_the_equator_the_curve_and_the_factor_are_those_of_the_exact_method() {
        let (problem, plane) = flat();
        let times = [0.0, 0.3, 0.6, 1.0];
        let found = curve(&problem, EFFORT, &times).unwrap();
        let exact = probabilities(&plane, &times).unwrap();
        for (found, exact) in found.probability.iter().zip(&exact) {
            // A 95 % interval, and as much again at either end.
            let half = found.high - found.low;
            assert!((found.value - exact.value).abs() <= half + 1e-6, "{found:?} {exact:?}");
        }
        assert!((0.1..0.9).contains(&exact[3].value), "{exact:?}");
        let wanted = factor_for(&problem, EFFORT, 0.9).unwrap().unwrap();
        let right = crate::disposal::radiation_for(&plane, 0.9).unwrap().unwrap() / 0.1;
        assert!((wanted.value - right).abs() < wanted.high - wanted.low, "{wanted:?} {right}");
        assert!(wanted.high - wanted.low < 0.05, "{wanted:?}");
    }

    #[test]
    fn the_effect_of_more_radiation_is_that_of_the_exact_method() {
        let (problem, plane) = flat();
        let found = sensitivities(&problem, EFFORT).unwrap();
        let exact = crate::disposal::sensitivities(&plane).unwrap();
        for name in ["radiation C + 1 %", "mean e + 0.1 sigma"] {
            let effect = found.iter().find(|found| found.change == name).unwrap().effect;
            let right = exact.iter().find(|exact| exact.change == name).unwrap().effect;
            assert!((effect.value - right).abs() < effect.high - effect.low, "{name}: {effect:?} {right}");
        }
        assert!(
            found.iter().all(|found| ![" i ", "node"].iter().any(|certain| found.change.contains(certain))),
            "certain variables are not changed: {found:?}"
        );
    }
}

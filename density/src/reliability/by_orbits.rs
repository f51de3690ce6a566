//! The radiation parameters with which orbits that start all over the cloud re-enter.
//!
//! Each start of a quasi-random sample is followed with many radiation parameters; where it passes the critical eccentricity with one and not with the next, the
//! border is found by halving. The probability of re-entry for an uncertain parameter is then the mean, over the starts, of the probability of the parameters with
//! which they pass: smooth in everything, so that two thousand starts are enough for an error below 1e-3. Independent replicates of the sample show the error.

use std::num::NonZeroUsize;

use rayon::prelude::*;

use crate::exact::Estimated;
use crate::exact::measure::normal_tail;
use crate::flow::{Accuracy, Flow, Passages};
use crate::model::registry::Planar;
use crate::model::uncertain_radiation::{Linear, UncertainRadiation};
use crate::orbits::Orbits;
use crate::problem::Problem;
use crate::sampling::{Draws, SamplingPlan};
use crate::uncertain::{Distribution, UncertainProblem};

/// Independent samples of starts.
const REPLICATES: usize = 8;
/// Starts of each.
const STARTS: usize = 256;
/// Distance of the parameters of a start, as a factor. A start that re-enters only with parameters between two of them is seen by others, whose
/// parameters lie elsewhere.
const FACTOR: f64 = 1.12;
/// Halvings of the distance in which a border lies.
const HALVINGS: u32 = 12;
/// Years after which the orbits that have passed are left behind.
const SEGMENT: f64 = 0.5;
/// Number of standard errors that an error estimate has.
const STANDARD_ERRORS: f64 = 3.0;

/// The parameters with which a start passes: ascending borders, and whether it passes below the first.
#[derive(Debug, Clone)]
struct Start {
    passes_first: bool,
    borders: Vec<f64>,
}

/// What is known of the starts of a cloud.
#[derive(Debug, Clone)]
pub struct ByOrbits {
    starts: Vec<Start>,
}

/// The error estimate below which this method cannot come: each start stands for a part of the cloud of which nothing else is known.
pub const LEAST_ERROR: f64 = 0.5 / (REPLICATES * STARTS) as f64;

impl ByOrbits {
    /// For radiation parameters between `ends`, and passages within `years`; `None` if an orbit cannot be followed.
    pub fn new(problem: &Problem<Planar>, ends: (f64, f64), years: f64) -> Option<Self> {
        let without = problem.model.with("radiation", 0.0).ok()?;
        let flow = Flow { model: UncertainRadiation::<Linear>::new(without), accuracy: Accuracy::Coarse };
        let cloud = Cloud { flow, starts: starts(problem), critical_e: problem.critical_e, years };
        let (low, high) = ends;
        let parts = ((high / low).ln() / FACTOR.ln()).ceil().max(1.0);
        // Each start has parameters of its own, so that together they are everywhere.
        let parameters = |start: usize| {
            let shift = (0.5 + start as f64 * GOLDEN).fract();
            let inside = (0..parts as u32).map(move |k| low * (high / low).powf((f64::from(k) + shift) / parts));
            [low].into_iter().chain(inside).chain([high])
        };
        let questions: Vec<(usize, f64)> =
            (0..cloud.starts.len()).flat_map(|start| parameters(start).map(move |c| (start, c))).collect();
        let passes = cloud.pass(&questions)?;
        let mut brackets: Vec<(usize, f64, f64, bool)> = Vec::new();
        for (pair, passes) in questions.windows(2).zip(passes.windows(2)) {
            if pair[0].0 == pair[1].0 && passes[0] != passes[1] {
                brackets.push((pair[0].0, pair[0].1, pair[1].1, passes[0]));
            }
        }
        for _ in 0..HALVINGS {
            let middles: Vec<(usize, f64)> =
                brackets.iter().map(|&(s, low, high, _)| (s, low.midpoint(high))).collect();
            let passes = cloud.pass(&middles)?;
            for ((_, low, high, first), ((_, middle), passes)) in brackets.iter_mut().zip(middles.iter().zip(passes)) {
                if passes == *first { *low = *middle } else { *high = *middle }
            }
        }
        let per_start = questions.len() / cloud.starts.len();
        let mut found: Vec<Start> = (0..cloud.starts.len())
            .map(|start| Start { passes_first: passes[start * per_start], borders: Vec::new() })
            .collect();
        for (start, low, high, _) in brackets {
            found[start].borders.push(low.midpoint(high));
        }
        Some(Self { starts: found })
    }

    /// The probability of re-entry for the uncertain parameter of `problem`.
    pub fn probability(&self, problem: &UncertainProblem) -> Estimated {
        let (mean, sigma) = problem.third();
        let lowest = problem.lowest();
        let above = |radiation: f64| {
            let variable = match problem.spread.distribution {
                Distribution::Gaussian => radiation,
                Distribution::LogNormal => radiation.ln(),
            };
            normal_tail(((variable - mean) / sigma).max(lowest))
        };
        let inside = problem.mass_inside();
        let of_start = |start: &Start| {
            // Each border adds or takes away what lies above it.
            let first = if start.passes_first { inside } else { 0.0 };
            let signs = [1.0, -1.0].into_iter().cycle().skip(usize::from(start.passes_first));
            (first + start.borders.iter().zip(signs).map(|(border, sign)| sign * above(*border)).sum::<f64>()) / inside
        };
        let means: Vec<f64> =
            self.starts.chunks(STARTS).map(|part| part.iter().map(of_start).sum::<f64>() / part.len() as f64).collect();
        let mean = means.iter().sum::<f64>() / means.len() as f64;
        let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (means.len() - 1) as f64;
        let standard_error = (variance / means.len() as f64).sqrt();
        Estimated { value: mean.clamp(0.0, 1.0), error: LEAST_ERROR + STANDARD_ERRORS * standard_error }
    }
}

/// The fractional part of the golden ratio, whose multiples are spread evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// The starts of all replicates, as states.
fn starts(problem: &Problem<Planar>) -> Vec<[f64; 2]> {
    let draw = |seed: usize| {
        let plan = SamplingPlan { draws: Draws::Sobol, seed: seed as u64, replicates: NonZeroUsize::MIN };
        let (x1, x2) = plan.draw(&problem.initial, STARTS);
        x1.into_iter().zip(x2).map(|(x1, x2)| [x1, x2]).collect::<Vec<_>>()
    };
    (0..REPLICATES).flat_map(draw).collect()
}

/// Orbits that start in a cloud.
struct Cloud {
    flow: Flow<UncertainRadiation<Linear>>,
    starts: Vec<[f64; 2]>,
    critical_e: f64,
    years: f64,
}

impl Cloud {
    /// Whether each start passes with its radiation parameter; `None` if an orbit cannot be followed.
    fn pass(&self, questions: &[(usize, f64)]) -> Option<Vec<bool>> {
        const CHUNK: usize = 1024;
        let parts: Option<Vec<Vec<bool>>> = questions.par_chunks(CHUNK).map(|part| self.pass_some(part)).collect();
        Some(parts?.concat())
    }

    fn pass_some(&self, questions: &[(usize, f64)]) -> Option<Vec<bool>> {
        let column =
            |f: fn([f64; 2], f64) -> f64| questions.iter().map(|&(start, c)| f(self.starts[start], c)).collect();
        let mut columns: Vec<Vec<f64>> =
            vec![column(|state, _| state[0]), column(|state, _| state[1]), column(|_, c| c)];
        let mut passes = vec![false; questions.len()];
        let mut open: Vec<usize> = (0..questions.len()).collect();
        let segments = (self.years / SEGMENT).ceil().max(1.0) as u32;
        for _ in 0..segments {
            let mut passed = vec![0u8; open.len()];
            let mut orbits = Orbits::from_columns(self.flow, columns);
            let noted = Passages { passages: &mut passed, pending: 0, note: &|_| 1 };
            orbits.advance_watching(self.years / f64::from(segments), self.critical_e, noted).ok()?;
            passed.iter().zip(&open).filter(|(passed, _)| **passed == 1).for_each(|(_, &orbit)| passes[orbit] = true);
            let stays =
                |values: &[f64]| values.iter().zip(&passed).filter(|(_, p)| **p == 0).map(|(x, _)| *x).collect();
            columns = orbits.columns().iter().map(|column| stays(column)).collect();
            open = open.into_iter().zip(&passed).filter(|(_, p)| **p == 0).map(|(orbit, _)| orbit).collect();
            if open.is_empty() {
                break;
            }
        }
        Some(passes)
    }
}

#[cfg(test)]
mod tests {
    use super::super::rows::{Point, evaluate};
    use super::*;
    use crate::model::planar::force_from_orbit;
    use crate::problem::InitialGaussian;
    use crate::reliability::Quantity;
    use crate::uncertain::Spread;

    fn problem(area: f64, years: f64) -> Problem<Planar> {
        let initial = InitialGaussian { mean_phi: 3.0, mean_e: 0.03, sigma_phi: 0.4, sigma_e: 0.008, correlation: 0.0 };
        Problem { model: force_from_orbit(2.5, area, 1.3).into(), initial, times: vec![0.0, years], critical_e: 0.5925 }
    }

    /// Also where part of the cloud re-enters within the years and the rest later.
    #[test]
    fn its_probabilities_are_those_of_the_exact_curve_within_its_errors() {
        for years in [0.9, 4.0] {
            let row: Vec<Point> = [4.0, 6.5, 7.0, 8.0, 12.0, 30.0]
                .into_iter()
                .map(|area| Point {
                    problem: problem(area, years),
                    spread: Some(Spread { relative: 0.06, distribution: Distribution::LogNormal }),
                })
                .collect();
            let exact = evaluate(&row, Quantity::Reentry { within: years }, 1e-4);
            let radiation = |k: usize| row[k].problem.model.value("radiation").unwrap();
            let sampled = ByOrbits::new(&row[0].problem, (0.7 * radiation(0), 1.4 * radiation(5)), years).unwrap();
            for (point, exact) in row.iter().zip(exact) {
                let problem = UncertainProblem { plane: point.problem.clone(), spread: point.spread.unwrap() };
                let found = sampled.probability(&problem);
                let difference = (found.value - exact.value).abs();
                assert!(difference <= found.error + exact.error, "{years} yr: {found:?} {exact:?}");
                assert!(found.error < 3e-3, "{found:?}");
            }
        }
    }
}

//! The questions of a disposal designer where the radiation parameter is uncertain.
//!
//! The probability that a satellite with a *given* parameter re-enters by the end is a function of that parameter
//! alone. It is tabulated once ([`EndProbability`]); for any mean and any spread of the parameter the probability is
//! then an integral over the table.

use rayon::prelude::*;

use crate::exact::leaves::ExactLeaves;
use crate::exact::measure::normal_density;
use crate::exact::{Error, ExactSettings, is_possible};
use crate::first_passage::exact::rough_curve;
use crate::first_passage::over_leaves::{Passed, curve};
use crate::flow::Accuracy;
use crate::problem::Problem;
use crate::uncertain::{Spread, UncertainProblem};

use super::Sensitivity;

/// What is known of the satellite at each of `times` \[yr\].
///
/// # Errors
/// As [`super::probabilities`].
pub fn passed(problem: &UncertainProblem, times: &[f64]) -> Result<Vec<Passed>, Error> {
    curve(&ExactLeaves::new(problem.clone(), Accuracy::Medium, ExactSettings::default()), times)
}

/// The probability of re-entry by the last snapshot as a function of the radiation parameter, linear between values
/// that are close enough together.
#[derive(Debug, Clone)]
pub struct EndProbability {
    /// Logarithms of the parameter, ascending, with the probabilities.
    table: Vec<(f64, f64)>,
}

impl EndProbability {
    /// For parameters from a hundredth to thirty times the mean of `problem`.
    ///
    /// # Errors
    /// As [`super::probabilities`], for the mean of the parameter.
    pub fn new(problem: &UncertainProblem) -> Result<Self, Error> {
        const RANGE: (f64, f64) = (0.01, 30.0);
        const FIRST: u32 = 48;
        const ROUNDS: u32 = 8;
        // Half of the tolerated error of a factor or a sensitivity.
        const TOLERANCE: f64 = 1e-4;
        // The error of a value of the table.
        const OF_VALUE: f64 = 1e-6;
        let plane = &problem.plane;
        let end = [plane.times.last().copied().unwrap_or(0.0)];
        let mean = problem.mean();
        let of = |&log: &f64| -> (f64, f64) {
            let leaf = plane.model.with("radiation", log.exp()).map(|model| Problem { model, ..plane.clone() });
            // Where the pull is too weak or too strong for the exact method, no use is made of the value.
            let found = leaf.ok().and_then(|leaf| rough_curve(&leaf, &end, OF_VALUE).ok());
            (log, found.map_or(f64::NAN, |found| found[0].value))
        };
        is_possible(&plane.model)?;
        let (low, high) = ((RANGE.0 * mean).ln(), (RANGE.1 * mean).ln());
        let first: Vec<f64> = (0..=FIRST).map(|k| low + (high - low) * f64::from(k) / f64::from(FIRST)).collect();
        let mut table: Vec<(f64, f64)> = first.par_iter().map(of).collect();
        table.retain(|(_, probability)| !probability.is_nan());
        let mut settled = vec![false; table.len()];
        for _ in 0..ROUNDS {
            let open: Vec<usize> = (0..table.len().saturating_sub(1)).filter(|&k| !settled[k]).collect();
            let middles: Vec<f64> = open.iter().map(|&k| table[k].0.midpoint(table[k + 1].0)).collect();
            let found: Vec<(f64, f64)> = middles.par_iter().map(of).collect();
            let mut finer = Vec::new();
            let mut fresh = open.iter().zip(found).peekable();
            for k in 0..table.len() {
                let middle = fresh.next_if(|(at, _)| **at == k).map(|(_, middle)| middle);
                let Some(middle) = middle.filter(|(_, probability)| !probability.is_nan()) else {
                    finer.push((table[k], true));
                    continue;
                };
                let linear = table[k].1.midpoint(table[k + 1].1);
                let is_settled = (middle.1 - linear).abs() < TOLERANCE;
                finer.extend([(table[k], is_settled), (middle, is_settled)]);
            }
            (table, settled) = finer.into_iter().unzip();
            if settled.iter().all(|settled| *settled) {
                break;
            }
        }
        Ok(Self { table })
    }

    /// The probability at a given parameter; beyond the table its nearest value.
    fn at(&self, radiation: f64) -> f64 {
        let log = radiation.max(f64::MIN_POSITIVE).ln();
        let k = self.table.partition_point(|(known, _)| *known < log);
        match (self.table.get(k.wrapping_sub(1)), self.table.get(k)) {
            (Some(before), Some(after)) => {
                before.1 + (after.1 - before.1) * (log - before.0) / (after.0 - before.0).max(f64::MIN_POSITIVE)
            }
            (Some(edge), None) | (None, Some(edge)) => edge.1,
            (None, None) => f64::NAN,
        }
    }

    /// The probability for an uncertain parameter with this mean and spread.
    fn for_spread(&self, problem: &UncertainProblem, mean: f64, spread: Spread) -> f64 {
        const STEPS: u32 = 1300;
        const REACH: f64 = 6.5;
        let scaled = UncertainProblem { plane: problem.plane.clone(), spread };
        let lowest = scaled.lowest().max(-REACH);
        let step = (REACH - lowest) / f64::from(STEPS);
        // Both distributions scale with their mean.
        let factor = mean / scaled.mean();
        let term = |k: u32| {
            let z = lowest + step * (f64::from(k) + 0.5);
            let weight = normal_density(z);
            (weight * self.at(factor * scaled.radiation(z)), weight)
        };
        let (sum, total) = (0..STEPS).map(term).fold((0.0, 0.0), |sum, term| (sum.0 + term.0, sum.1 + term.1));
        sum / total
    }

    /// The least mean of the radiation parameter, between a tenth of the present one and ten times as much, with which
    /// the probability is at least `probability`; the relative spread stays the same.
    pub fn radiation_for(&self, problem: &UncertainProblem, probability: f64) -> Option<f64> {
        const STEPS: u32 = 400;
        let suffices = |factor: f64| self.for_spread(problem, factor * problem.mean(), problem.spread) >= probability;
        let factor = |k: u32| 10f64.powf(2.0 * f64::from(k) / f64::from(STEPS) - 1.0);
        let first = (0..=STEPS).find(|&k| suffices(factor(k)))?;
        if first == 0 {
            return Some(0.1 * problem.mean());
        }
        let (mut low, mut high) = (factor(first - 1), factor(first));
        for _ in 0..20 {
            let middle = low.midpoint(high);
            if suffices(middle) { high = middle } else { low = middle }
        }
        Some(high * problem.mean())
    }
}

/// The effect of small changes on the probability of re-entry by the last snapshot, as [`super::sensitivities`], and of
/// the spread of the radiation parameter; the largest first.
///
/// # Errors
/// As [`super::probabilities`].
pub fn sensitivities(problem: &UncertainProblem, table: &EndProbability) -> Result<Vec<Sensitivity>, Error> {
    let end = [problem.plane.times.last().copied().unwrap_or(0.0)];
    let (mean, spread) = (problem.mean(), problem.spread);
    let by_table = table.for_spread(problem, mean, spread);
    let with = |change: &str, effect: f64| Sensitivity { change: change.into(), effect };
    let wider = Spread { relative: 1.1 * spread.relative, ..spread };
    let mut found = vec![
        with("radiation C + 1 %", table.for_spread(problem, 1.01 * mean, spread) - by_table),
        with("sigma radiation + 10 %", table.for_spread(problem, mean, wider) - by_table),
    ];
    let probability =
        |plane: Problem<_>| Ok::<f64, Error>(passed(&UncertainProblem { plane, spread }, &end)?[0].probability.value);
    let now = probability(problem.plane.clone())?;
    for (change, plane) in super::changes(&problem.plane) {
        if !change.starts_with("radiation ") {
            found.push(with(&change, probability(plane)? - now));
        }
    }
    found.sort_by(|a, b| b.effect.abs().total_cmp(&a.effect.abs()));
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::planar::SrpJ2;
    use crate::problem::InitialGaussian;
    use crate::uncertain::Distribution;

    #[test]
    #[ignore = "long; .ci/long runs it"]
    fn a_table_gives_the_probability_of_the_integral_over_leaves() {
        let initial = InitialGaussian { mean_phi: 3.0, mean_e: 0.05, sigma_phi: 0.4, sigma_e: 0.01, correlation: 0.0 };
        let model = SrpJ2 { radiation: 0.124, oblateness: 0.40921 }.into();
        let plane = Problem { model, initial, times: vec![0.0, 1.5], critical_e: 0.6 };
        let spread = Spread { relative: 0.05, distribution: Distribution::LogNormal };
        let problem = UncertainProblem::new(plane, spread).unwrap();
        let table = EndProbability::new(&problem).unwrap();
        let exact = passed(&problem, &[1.5]).unwrap()[0].probability.value;
        let by_table = table.for_spread(&problem, problem.mean(), spread);
        assert!((by_table - exact).abs() < 2e-4, "{by_table} instead of {exact}");
        let wanted = table.radiation_for(&problem, 0.9).unwrap();
        let model = problem.plane.model.with("radiation", wanted).unwrap();
        let there = UncertainProblem { plane: Problem { model, ..problem.plane.clone() }, spread };
        let found = passed(&there, &[1.5]).unwrap()[0].probability.value;
        assert!((found - 0.9).abs() < 1e-3, "{found} at {wanted}");
    }
}

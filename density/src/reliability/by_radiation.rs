//! Figures of a cloud as functions of the radiation parameter: a table that is linear between its values.
//!
//! The table is kept in the variable that is a Gaussian if the parameter is uncertain: `C` itself, or its logarithm.
//! Linear functions of that variable have closed means over any part of a Gaussian,
//!
//! ```text
//! ∫ φ(z) dz = Φ(b) - Φ(a)      ∫ z φ(z) dz = φ(a) - φ(b)      from a to b
//! ```
//!
//! so a mean over the parameter adds no error to that of the table.

use rayon::prelude::*;

use crate::exact::Estimated;
use crate::exact::measure::{normal_density, normal_tail};
use crate::uncertain::{Distribution, UncertainProblem};

use super::UNKNOWN;

/// Most times that a distance between two values is halved.
const ROUNDS: u32 = 10;

/// A value of the table's variable with the figures there; `None` where they cannot be computed.
#[derive(Debug, Clone)]
struct Node {
    at: f64,
    figures: Option<Vec<Estimated>>,
}

/// Figures as functions of the radiation parameter.
#[derive(Debug, Clone)]
pub struct ByRadiation {
    distribution: Distribution,
    count: usize,
    nodes: Vec<Node>,
    /// The error of the linear function between each node and the next, one per figure; none where a node has no
    /// figures.
    bends: Vec<Vec<f64>>,
}

/// What a table must be.
#[derive(Debug, Clone, Copy)]
pub struct Range {
    /// Least and largest radiation parameter.
    pub ends: (f64, f64),
    /// Largest distance of two values, as a share of the smaller one.
    pub coarsest: f64,
    /// Largest error of the linear functions between the values.
    pub tolerance: f64,
    /// The narrowest relative deviation of a parameter whose mean is to be taken; 0 if there is one that is certain. A
    /// distance of values that is narrow against it may have an error that is larger by as much.
    pub narrowest: f64,
}

impl Range {
    /// The largest share of the probability that can lie between two parameters.
    fn largest_share(self, low: f64, high: f64) -> f64 {
        /// The largest density of a Gaussian.
        const PEAK: f64 = 0.4;
        if self.narrowest > 0.0 { (PEAK * (high / low).ln() / self.narrowest).min(1.0) } else { 1.0 }
    }
}

impl ByRadiation {
    /// A table of `count` figures of the radiation parameter in `range`, for a parameter of this distribution.
    pub fn new(
        distribution: Distribution,
        range: Range,
        count: usize,
        figures: impl Fn(f64) -> Option<Vec<Estimated>> + Sync,
    ) -> Self {
        let node = |at: f64| Node { at, figures: figures(radiation(distribution, at)) };
        let (low, high) = range.ends;
        let parts = ((high / low).ln() / range.coarsest.ln_1p()).ceil().max(1.0) as usize;
        let first = |k: usize| variable(distribution, low * (high / low).powf(k as f64 / parts as f64));
        let mut table = Self {
            distribution,
            count,
            nodes: (0..=parts).into_par_iter().map(|k| node(first(k))).collect(),
            bends: Vec::new(),
        };
        table.bends = vec![vec![f64::INFINITY; count]; parts];
        for _ in 0..ROUNDS {
            let open: Vec<usize> = (0..table.bends.len()).filter(|&k| table.is_open(k, range)).collect();
            if open.is_empty() {
                break;
            }
            let middles = open.par_iter().map(|&k| node(table.nodes[k].at.midpoint(table.nodes[k + 1].at))).collect();
            table.insert(&open, middles);
        }
        table
    }

    /// Whether the figures between two nodes are not known well enough, and can be.
    fn is_open(&self, gap: usize, range: Range) -> bool {
        let (before, after) = (&self.nodes[gap], &self.nodes[gap + 1]);
        let [low, high] = [before, after].map(|node| radiation(self.distribution, node.at));
        let share = range.largest_share(low, high);
        before.figures.is_some()
            && after.figures.is_some()
            && self.bends[gap].iter().any(|bend| *bend * share > range.tolerance)
    }

    /// Adds a node in the middle of each of these gaps.
    fn insert(&mut self, gaps: &[usize], middles: Vec<Node>) {
        let mut fresh = gaps.iter().copied().zip(middles).peekable();
        let (mut nodes, mut bends) = (Vec::new(), Vec::new());
        for (k, node) in std::mem::take(&mut self.nodes).into_iter().enumerate() {
            let before = nodes.last().cloned();
            if let (Some((_, middle)), Some(before)) = (fresh.next_if(|(gap, _)| gap + 1 == k), before) {
                let bend = bend(&before, &middle, &node, self.count);
                nodes.push(middle);
                bends.extend([bend.clone(), bend]);
            } else if k > 0 {
                bends.push(std::mem::take(&mut self.bends[k - 1]));
            }
            nodes.push(node);
        }
        (self.nodes, self.bends) = (nodes, bends);
    }

    /// The figures at a radiation parameter; [`UNKNOWN`] beyond the table.
    pub fn at(&self, radiation: f64) -> Vec<Estimated> {
        let at = variable(self.distribution, radiation);
        let gap = self.nodes.partition_point(|node| node.at < at).clamp(1, self.nodes.len() - 1) - 1;
        let (before, after) = (&self.nodes[gap], &self.nodes[gap + 1]);
        let share = (at - before.at) / (after.at - before.at);
        let (Some(a), Some(b), true) = (&before.figures, &after.figures, (-1e-9..=1.0 + 1e-9).contains(&share)) else {
            return vec![UNKNOWN; self.count];
        };
        let figure = |f: usize| Estimated {
            value: a[f].value + share * (b[f].value - a[f].value),
            error: self.bends[gap][f] + a[f].error.max(b[f].error),
        };
        (0..self.count).map(figure).collect()
    }

    /// The means of the figures over the radiation parameter of `problem`. Probability beyond the table counts with the
    /// nearest value, and as an error of its own size times `scale`, the largest difference that a figure can make.
    pub fn means(&self, problem: &UncertainProblem, scale: f64) -> Vec<Estimated> {
        let (mean, sigma) = problem.third();
        let lowest = problem.lowest();
        let z = |k: usize| ((self.nodes[k].at - mean) / sigma).max(lowest);
        let mut sums = vec![Estimated { value: 0.0, error: 0.0 }; self.count];
        let mut known = 0.0;
        for gap in 0..self.bends.len() {
            let (from, to) = (z(gap), z(gap + 1));
            let (Some(a), Some(b)) = (&self.nodes[gap].figures, &self.nodes[gap + 1].figures) else { continue };
            if from >= to {
                continue;
            }
            let mass = normal_tail(from) - normal_tail(to);
            let first = normal_density(from) - normal_density(to);
            known += mass;
            // How much of the value at the right end a point of the gap has, summed over the gap.
            let right = (first - from * mass) / (to - from);
            for f in 0..self.count {
                sums[f].value += a[f].value * (mass - right) + b[f].value * right;
                sums[f].error += mass * (self.bends[gap][f] + a[f].error.max(b[f].error));
            }
        }
        let inside = problem.mass_inside();
        let missing = (1.0 - known / inside).max(0.0);
        let finish = |sum: Estimated| Estimated {
            value: sum.value / known.max(f64::MIN_POSITIVE),
            error: sum.error / inside + missing * scale,
        };
        if known > 0.5 * inside { sums.into_iter().map(finish).collect() } else { vec![UNKNOWN; self.count] }
    }
}

/// The variable that is a Gaussian, at a radiation parameter.
fn variable(distribution: Distribution, radiation: f64) -> f64 {
    match distribution {
        Distribution::Gaussian => radiation,
        Distribution::LogNormal => radiation.ln(),
    }
}

/// The radiation parameter at a value of that variable.
fn radiation(distribution: Distribution, variable: f64) -> f64 {
    match distribution {
        Distribution::Gaussian => variable,
        Distribution::LogNormal => variable.exp(),
    }
}

/// How far the figures in the middle are from the line between the ends.
fn bend(before: &Node, middle: &Node, after: &Node, count: usize) -> Vec<f64> {
    let (Some(a), Some(m), Some(b)) = (&before.figures, &middle.figures, &after.figures) else {
        return vec![f64::INFINITY; count];
    };
    let share = (middle.at - before.at) / (after.at - before.at);
    (0..count).map(|f| (m[f].value - a[f].value - share * (b[f].value - a[f].value)).abs()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::planar::SrpJ2;
    use crate::problem::{InitialGaussian, Problem};
    use crate::uncertain::Spread;

    fn problem(mean: f64, relative: f64, distribution: Distribution) -> UncertainProblem {
        let initial = InitialGaussian { mean_phi: 1.0, mean_e: 0.2, sigma_phi: 0.1, sigma_e: 0.01, correlation: 0.0 };
        let model = SrpJ2 { radiation: mean, oblateness: 0.4 }.into();
        let plane = Problem { model, initial, times: vec![0.0], critical_e: 0.6 };
        UncertainProblem::new(plane, Spread { relative, distribution }).unwrap()
    }

    fn table(distribution: Distribution, figure: fn(f64) -> f64) -> ByRadiation {
        let range = Range { ends: (0.01, 1.0), coarsest: 0.1, tolerance: 1e-5, narrowest: 0.0 };
        ByRadiation::new(distribution, range, 1, |c| Some(vec![Estimated { value: figure(c), error: 0.0 }]))
    }

    #[test]
    fn the_mean_of_a_step_is_the_probability_of_the_parameter_being_above_it() {
        for distribution in [Distribution::Gaussian, Distribution::LogNormal] {
            let table = table(distribution, |c| ((c - 0.124) / 1e-3).clamp(-0.5, 0.5) + 0.5);
            for (mean, relative) in [(0.1, 0.2), (0.124, 0.05), (0.13, 0.02)] {
                let problem = problem(mean, relative, distribution);
                let found = table.means(&problem, 1.0)[0];
                let z = |c: f64| {
                    let (mean, sigma) = problem.third();
                    (variable(distribution, c) - mean) / sigma
                };
                // The ramp is narrow against the spread, so its mean is that of the tails at its points.
                let tails = (0..1000).map(|k| normal_tail(z(0.1235 + 1e-3 * (f64::from(k) + 0.5) / 1000.0)));
                let expected = tails.sum::<f64>() / 1000.0 / problem.mass_inside();
                let difference = (found.value - expected).abs();
                assert!(difference <= found.error + 1e-6, "{difference:e} {found:?}");
                assert!(found.error < 3e-5, "{found:?}");
            }
        }
    }

    #[test]
    fn the_error_estimate_covers_the_error_of_a_bent_function_and_what_lies_beyond_the_table() {
        let table = table(Distribution::Gaussian, |c| (30.0 * c).sin());
        let problem = problem(0.4, 0.1, Distribution::Gaussian);
        // The mean of a sine over a Gaussian.
        let expected = 12f64.sin() * (-0.5 * 1.2f64.powi(2)).exp();
        let found = table.means(&problem, 2.0)[0];
        assert!((found.value - expected).abs() <= found.error && found.error < 2e-5, "{found:?} {expected}");
        let outside = super::tests::problem(0.98, 0.05, Distribution::Gaussian);
        assert!(table.means(&outside, 2.0)[0].error > 0.3);
        assert!(table.at(1.2)[0].value.is_nan() && (table.at(0.3)[0].value - 9f64.sin()).abs() < 2e-5);
    }

    #[test]
    fn where_nothing_can_be_computed_the_probability_there_counts_as_an_error() {
        let range = Range { ends: (0.01, 1.0), coarsest: 0.1, tolerance: 1e-5, narrowest: 0.0 };
        let figure = |c: f64| (c > 0.1).then(|| vec![Estimated { value: 1.0, error: 0.0 }]);
        let table = ByRadiation::new(Distribution::Gaussian, range, 1, figure);
        let found = table.means(&problem(0.12, 0.1, Distribution::Gaussian), 1.0)[0];
        assert!(found.value == 1.0 && found.error > normal_tail(20.0 / 12.0), "{found:?}");
        assert!(table.means(&problem(0.05, 0.1, Distribution::Gaussian), 1.0)[0].value.is_nan());
    }
}

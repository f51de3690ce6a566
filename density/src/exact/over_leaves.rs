//! Integrals over an uncertain radiation parameter.
//!
//! The mean of a function `f` of the leaf ([`crate::uncertain`]) is `∫ f(z) w(z) dz` with the standard normal density
//! `w`, cut where the parameter would be negative. Where `f` is smooth on the scale of the spread, the trapezoidal rule
//! converges faster than any power of its step, for the Gaussian and its derivatives vanish at both ends (Trefethen &
//! Weideman, SIAM Review 56, 2014): 25 to 49 leaves are enough, the same for every integral. Elsewhere, as where a
//! change of the parameter decides whether an orbit passes a saddle, there are Kronrod rules on intervals of `z`, which
//! are halved where the function is rough.

use rayon::prelude::*;

use crate::model::registry::Planar;
use crate::problem::Problem;
use crate::uncertain::UncertainProblem;

use super::adaptive::{Interval, kronrod_error, remove, worst};
use super::measure::normal_density;
use super::rules::POINTS;

/// Standard deviations from the mean beyond which the Gaussian counts as zero: 8e-11 of it lie there.
pub(crate) const REACH: f64 = 6.5;
/// Distance from the mean out to which the trapezoidal rule goes, in standard deviations: 2e-9 of the Gaussian lie
/// beyond.
const EVEN_REACH: f64 = 6.0;
/// Steps of the trapezoidal rule at first, and at most.
const FIRST_STEPS: usize = 12;
const MOST_STEPS: usize = 48;
/// Ends of the first intervals in standard deviations.
const FIRST: [f64; 4] = [-REACH, -2.2, 2.2, REACH];

/// The `z` of a leaf, and its weights in the rule and in the coarser one.
type Node = (f64, f64, f64);

/// What the functions that are integrated are on a leaf.
#[derive(Debug, Clone)]
pub(crate) struct LeafValues {
    /// The values of the functions.
    pub values: Vec<f64>,
    /// Estimates of errors: of each value, or of all of them together.
    pub errors: Vec<f64>,
}

/// An interval of `z` with its part of the integrals.
#[derive(Debug, Clone)]
pub(crate) struct LeafPanel {
    interval: Interval,
    /// By the rule.
    pub values: Vec<f64>,
    /// Differences from the coarser rule.
    pub differences: Vec<f64>,
    /// The integrals of the values' sizes.
    sizes: Vec<f64>,
    /// The integrals of the errors of the leaves.
    inner: Vec<f64>,
    /// The probability of the leaves of which nothing is known.
    lost: f64,
}

impl LeafPanel {
    /// The error estimates of the rule, one for each value.
    pub fn errors(&self) -> impl Iterator<Item = f64> + '_ {
        self.differences.iter().zip(&self.sizes).map(|(&difference, &size)| kronrod_error(difference, size))
    }
}

/// Integrals over all leaves.
#[derive(Debug, Clone)]
pub(crate) struct OverLeaves {
    /// The parts of the integrals, in ascending order of `z`.
    pub panels: Vec<LeafPanel>,
}

impl OverLeaves {
    fn sum(&self, of: impl Fn(&LeafPanel) -> &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.panels.iter().map(|panel| of(panel).len()).max().unwrap_or(0)];
        for panel in &self.panels {
            sum.iter_mut().zip(of(panel)).for_each(|(sum, part)| *sum += part);
        }
        sum
    }

    /// The integrals.
    pub fn values(&self) -> Vec<f64> {
        self.sum(|panel| &panel.values)
    }

    /// The integrals of the leaves' error estimates.
    pub fn inner(&self) -> Vec<f64> {
        self.sum(|panel| &panel.inner)
    }

    /// The error estimate of each value: of the rules, of the leaves, and of those of which nothing is known.
    pub fn errors(&self) -> Vec<f64> {
        let mut errors = self.inner();
        for panel in &self.panels {
            errors.iter_mut().zip(panel.errors()).for_each(|(sum, error)| *sum += error);
        }
        let lost = self.lost();
        errors.iter_mut().for_each(|error| *error += lost);
        errors
    }

    /// The probability of the leaves of which nothing is known.
    pub fn lost(&self) -> f64 {
        self.panels.iter().map(|panel| panel.lost).sum()
    }
}

/// The integrals over all leaves of the `functions` functions that `leaf` computes from a problem and the density of
/// its `z`; `None` if nothing is known of a leaf. They are refined until the shares of the tolerated error that `share`
/// gives to the panels add up to at most 1, or until `most_leaves` have been taken.
pub(crate) fn integrate<E: Send>(
    problem: &UncertainProblem,
    functions: usize,
    leaf: impl Fn(&Problem<Planar>, f64, f64) -> Result<Option<LeafValues>, E> + Sync,
    share: impl Fn(&LeafPanel, &[f64]) -> f64,
    most_leaves: usize,
) -> Result<OverLeaves, E> {
    if let Some(panel) = evenly(problem, functions, &leaf, &share)? {
        return Ok(OverLeaves { panels: vec![panel] });
    }
    let lowest = problem.lowest().max(-REACH);
    let cuts: Vec<f64> = std::iter::once(lowest).chain(FIRST.into_iter().filter(|&cut| cut > lowest)).collect();
    let mut pending: Vec<Interval> = cuts.windows(2).map(|pair| Interval { low: pair[0], high: pair[1] }).collect();
    let mut found = OverLeaves { panels: Vec::new() };
    let mut leaves = 0;
    loop {
        leaves += pending.len() * POINTS;
        let fresh: Vec<LeafPanel> =
            pending.iter().map(|&interval| panel(problem, interval, functions, &leaf)).collect::<Result<_, E>>()?;
        found.panels.extend(fresh);
        found.panels.sort_by(|a, b| a.interval.low.total_cmp(&b.interval.low));
        let values = found.values();
        let shares: Vec<f64> = found.panels.iter().map(|panel| share(panel, &values)).collect();
        let most = most_leaves.saturating_sub(leaves) / (2 * POINTS);
        let worst = worst(&shares, most, |i| found.panels[i].interval.can_be_halved());
        if shares.iter().sum::<f64>() <= 1.0 || worst.is_empty() {
            return Ok(found);
        }
        pending = worst.iter().flat_map(|&i| found.panels[i].interval.halves()).collect();
        remove(&mut found.panels, &worst);
    }
}

/// The tolerance on a leaf of which the density in `z` is `density`: a leaf that counts for little may be less
/// accurate.
pub(crate) fn eased(tolerance: f64, density: f64) -> f64 {
    const PEAK: f64 = 0.4;
    (tolerance * PEAK / density).clamp(tolerance, 1e-2)
}

/// The integrals by the trapezoidal rule, with the difference that the last halving of its step made; `None` if its
/// shares of the tolerated errors are too large, or if the distribution is cut, where the rule would be no better than
/// others.
fn evenly<E: Send>(
    problem: &UncertainProblem,
    functions: usize,
    leaf: &(impl Fn(&Problem<Planar>, f64, f64) -> Result<Option<LeafValues>, E> + Sync),
    share: &impl Fn(&LeafPanel, &[f64]) -> f64,
) -> Result<Option<LeafPanel>, E> {
    if problem.lowest() > -EVEN_REACH {
        return Ok(None);
    }
    let at = |k: usize, steps: usize| EVEN_REACH * (2.0 * (k as f64 / steps as f64) - 1.0);
    let mut steps = FIRST_STEPS;
    let mut leaves = on_leaves(problem, &(0..=steps).map(|k| at(k, steps)).collect::<Vec<_>>(), leaf)?;
    while steps < MOST_STEPS {
        let between: Vec<f64> = (0..steps).map(|k| at(2 * k + 1, 2 * steps)).collect();
        let mut fresh = on_leaves(problem, &between, leaf)?.into_iter();
        leaves = leaves.into_iter().flat_map(|known| [Some(known), fresh.next()]).flatten().collect();
        steps *= 2;
        let step = 2.0 * EVEN_REACH / steps as f64;
        let node = |k: usize| {
            let end = if k == 0 || k == steps { 0.5 } else { 1.0 };
            (at(k, steps), end * step, if k.is_multiple_of(2) { 2.0 * end * step } else { 0.0 })
        };
        let nodes: Vec<(f64, f64, f64)> = (0..=steps).map(node).collect();
        let panel =
            LeafPanel::sum(problem, Interval { low: -EVEN_REACH, high: EVEN_REACH }, functions, (&nodes, &leaves));
        if share(&panel, &panel.values) <= 1.0 {
            return Ok(Some(panel));
        }
    }
    Ok(None)
}

fn panel<E: Send>(
    problem: &UncertainProblem,
    interval: Interval,
    functions: usize,
    leaf: &(impl Fn(&Problem<Planar>, f64, f64) -> Result<Option<LeafValues>, E> + Sync),
) -> Result<LeafPanel, E> {
    let nodes = interval.nodes();
    let leaves = on_leaves(problem, &nodes.map(|(z, ..)| z), leaf)?;
    Ok(LeafPanel::sum(problem, interval, functions, (&nodes, &leaves)))
}

/// What `leaf` finds at these places.
fn on_leaves<E: Send>(
    problem: &UncertainProblem,
    places: &[f64],
    leaf: &(impl Fn(&Problem<Planar>, f64, f64) -> Result<Option<LeafValues>, E> + Sync),
) -> Result<Vec<Option<LeafValues>>, E> {
    let at = |&z: &f64| match problem.leaf(z) {
        Some(plane) => leaf(&plane, z, density(problem, z)),
        None => Ok(None),
    };
    places.par_iter().map(at).collect()
}

/// The density of `z`.
fn density(problem: &UncertainProblem, z: f64) -> f64 {
    normal_density(z) / problem.mass_inside()
}

impl LeafPanel {
    /// From the leaves at the nodes of an interval, given with the weights of the rule and of the coarser one within
    /// it. There may be no leaf of which anything is known.
    fn sum(
        problem: &UncertainProblem,
        interval: Interval,
        functions: usize,
        (nodes, leaves): (&[Node], &[Option<LeafValues>]),
    ) -> Self {
        let zeros = || vec![0.0; functions];
        let (mut values, mut coarser, mut sizes) = (zeros(), zeros(), zeros());
        let (mut inner, mut lost) = (zeros(), 0.0);
        for (&(z, by_rule, by_coarser), leaf) in nodes.iter().zip(leaves) {
            let (weight, coarser_weight) = (by_rule * density(problem, z), by_coarser * density(problem, z));
            let Some(leaf) = leaf else {
                lost += weight;
                continue;
            };
            for (f, value) in leaf.values.iter().enumerate() {
                values[f] += weight * value;
                coarser[f] += coarser_weight * value;
                sizes[f] += weight * value.abs();
            }
            inner.iter_mut().zip(&leaf.errors).for_each(|(sum, error)| *sum += weight * error);
        }
        let differences = values.iter().zip(&coarser).map(|(value, coarser)| value - coarser).collect();
        Self { interval, values, differences, sizes, inner, lost }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::paper;
    use crate::uncertain::{Distribution, Spread};

    /// Moments of a Gaussian that is cut at zero (Johnson, Kotz & Balakrishnan 1994, Sect. 13.10.1), and a step.
    #[test]
    fn means_over_the_parameter_are_those_of_its_distribution() {
        let paper = paper::scenario(1);
        let plane = Problem { model: paper.model.into(), initial: paper.initial, times: paper.times, critical_e: 0.6 };
        for (relative, distribution) in
            [(0.1, Distribution::Gaussian), (0.7, Distribution::Gaussian), (0.4, Distribution::LogNormal)]
        {
            let problem = UncertainProblem::new(plane.clone(), Spread { relative, distribution }).unwrap();
            let leaf = |leaf: &Problem<Planar>, z: f64, _: f64| {
                let radiation = leaf.model.value("radiation").unwrap();
                Ok::<_, ()>(Some(LeafValues { values: vec![1.0, radiation, f64::from(z > 0.3)], errors: vec![0.0; 3] }))
            };
            let share = |panel: &LeafPanel, _: &[f64]| panel.errors().sum::<f64>() / 1e-7;
            let found = integrate(&problem, 3, leaf, share, 3000).unwrap();
            let hazard = normal_density(problem.lowest()) / problem.mass_inside();
            let mean = match distribution {
                Distribution::Gaussian => problem.mean() * (1.0 + relative * hazard),
                Distribution::LogNormal => problem.mean(),
            };
            let step = crate::exact::measure::normal_tail(0.3) / problem.mass_inside();
            for (value, right) in found.values().into_iter().zip([1.0, mean, step]) {
                assert!((value - right).abs() < 1e-7, "{relative}: {value} instead of {right}");
            }
            assert_eq!(found.lost(), 0.0);
        }
    }
    #[test]
    fn leaves_of_which_nothing_is_known_count_as_error_wherever_they_lie() {
        let paper = paper::scenario(1);
        let plane = Problem { model: paper.model.into(), initial: paper.initial, times: paper.times, critical_e: 0.6 };
        let spread = Spread { relative: 0.2, distribution: Distribution::Gaussian };
        let problem = UncertainProblem::new(plane, spread).unwrap();
        // Nothing is known below, or above, or anywhere.
        for (low, high) in [(-0.5, 9.0), (-9.0, 1.0), (8.0, 9.0)] {
            let leaf = |_: &Problem<Planar>, z: f64, _: f64| {
                let known = LeafValues { values: vec![1.0, z], errors: vec![0.0; 2] };
                Ok::<_, ()>((low..high).contains(&z).then_some(known))
            };
            let share = |panel: &LeafPanel, _: &[f64]| panel.errors().sum::<f64>() / 1e-6;
            let found = integrate(&problem, 2, leaf, share, 3000).unwrap();
            let (values, errors) = (found.values(), found.errors());
            assert_eq!((values.len(), errors.len()), (2, 2));
            assert!((values[0] + found.lost() - 1.0).abs() < 1e-6, "{values:?} {}", found.lost());
            assert!(errors.iter().all(|&error| error >= found.lost()), "{errors:?}");
        }
    }
}

//! The first-passage curve of a weighted sample of orbits.

use std::f64::consts::PI;

use crate::sampling::group;

/// 97.5 % quantile of the standard normal distribution.
const QUANTILE: f64 = 1.959_963_984_540_054;

/// `P(T <= t)` estimated from a sample.
#[derive(Debug, Clone, PartialEq)]
pub struct EmpiricalCurve {
    /// Times \[yr\].
    pub times: Vec<f64>,
    /// Share of the weight that has passed at each time.
    pub probability: Vec<f64>,
    /// 95 % interval at each time; only for orbits of equal weight.
    pub interval: Option<Vec<(f64, f64)>>,
}

/// The curve at the ascending `times` from the orbits' first passage times. `None` gives all orbits the same weight;
/// weights need not be normalised.
///
/// # Panics
/// If there is not one weight for every passage time.
pub fn empirical_curve(passages: &[f64], weights: Option<&[f64]>, times: &[f64]) -> EmpiricalCurve {
    assert!(weights.is_none_or(|weights| weights.len() == passages.len()), "one weight for every passage time");
    match weights {
        None => curve_of_points(passages.iter().map(|&passage| point(passage, times)), times),
        Some(weights) => {
            let probability = weighted_shares(passages, weights, times);
            EmpiricalCurve { times: times.to_vec(), probability, interval: None }
        }
    }
}

/// Index of the first of the ascending `times` by which an orbit that passes at `passage` has passed; `times.len()` if
/// there is none.
pub fn point(passage: f64, times: &[f64]) -> usize {
    times.partition_point(|&time| time < passage)
}

/// The curve of orbits of equal weight, from the [`point`] of each orbit.
pub fn curve_of_points(points: impl ExactSizeIterator<Item = usize>, times: &[f64]) -> EmpiricalCurve {
    let orbits = points.len() as u64;
    let mut counts = vec![0; times.len()];
    for point in points {
        if let Some(count) = counts.get_mut(point) {
            *count += 1;
        }
    }
    curve_of_counts(&counts, orbits, times)
}

/// The curve of so many orbits of equal weight, from the number of those that have passed by each time and not by the
/// one before.
pub fn curve_of_counts(counts: &[u64], orbits: u64, times: &[f64]) -> EmpiricalCurve {
    let orbits = orbits as f64;
    let mut passed = 0;
    let share = |count: &u64| {
        passed += count;
        passed as f64 / orbits
    };
    let probability: Vec<f64> = counts.iter().map(share).collect();
    let interval = probability.iter().map(|&p| wilson_interval(p, orbits)).collect();
    EmpiricalCurve { times: times.to_vec(), probability, interval: Some(interval) }
}

/// The curve of weighted orbits, summed in the order of passage.
fn weighted_shares(passages: &[f64], weights: &[f64], times: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..passages.len()).collect();
    order.sort_by(|&a, &b| passages[a].total_cmp(&passages[b]).then(a.cmp(&b)));
    let total: f64 = order.iter().map(|&i| weights[i]).sum();
    let passed: Vec<f64> = order
        .iter()
        .scan(0.0, |sum, &i| {
            *sum += weights[i];
            Some(*sum)
        })
        .collect();
    let share = |time: &f64| match order.partition_point(|&i| passages[i] <= *time) {
        0 => 0.0,
        count => passed[count - 1] / total,
    };
    times.iter().map(share).collect()
}

/// 95 % interval of a binomial probability when a share `p` of `count` trials succeeded: the probabilities whose own
/// normal approximation does not reject the observation (Wilson, J. Am. Stat. Assoc. 22, 1927). Unlike `p ± 2 sigma` it
/// stays within `[0, 1]` and is not empty at `p = 0`. Without trials it is `[0, 1]`.
pub fn wilson_interval(p: f64, count: f64) -> (f64, f64) {
    wilson_within(p, count, QUANTILE)
}

/// The same for so many standard errors.
pub fn wilson_within(p: f64, count: f64, standard_errors: f64) -> (f64, f64) {
    if count <= 0.0 {
        return (0.0, 1.0);
    }
    let z2 = standard_errors * standard_errors / count;
    let centre = (p + 0.5 * z2) / (1.0 + z2);
    let half = standard_errors * (p * (1.0 - p) / count + 0.25 * z2 / count).sqrt() / (1.0 + z2);
    ((centre - half).clamp(0.0, p), (centre + half).clamp(p, 1.0))
}

/// The curve of orbits of equal weight that were drawn in independent groups ([`crate::sampling::group`]), from the
/// [`point`] of each orbit. Its interval follows from the spread of the groups' own curves: with `R` groups it is `±t
/// s/sqrt(R)`, with the 97.5 % quantile `t` of Student's distribution of `R - 1` degrees of freedom (Owen, *Monte Carlo
/// theory, methods and examples*, 2013, Chapter 17). Where fewer than [`FEW`] orbits have passed, or all but as few, a
/// spread says little, and the interval reaches at least as far as Wilson's.
pub fn curve_of_groups(points: impl ExactSizeIterator<Item = usize>, groups: usize, times: &[f64]) -> EmpiricalCurve {
    let points: Vec<usize> = points.collect();
    let orbits = points.len() as f64;
    let mut members = vec![Vec::new(); groups.max(1)];
    points.iter().enumerate().for_each(|(row, &point)| members[group(row, groups.max(1))].push(point));
    let curves: Vec<Vec<f64>> =
        members.into_iter().map(|points| curve_of_points(points.into_iter(), times).probability).collect();
    let whole = curve_of_points(points.into_iter(), times);
    let count = curves.len() as f64;
    let quantile = student_quantile(curves.len().saturating_sub(1).max(1));
    let interval = |(k, &p): (usize, &f64)| {
        let squares: f64 = curves.iter().map(|curve| (curve[k] - p).powi(2)).sum();
        let half = quantile * (squares / ((count - 1.0) * count)).sqrt();
        let (low, high) = ((p - half).clamp(0.0, p), (p + half).clamp(p, 1.0));
        if p.min(1.0 - p) * orbits < FEW {
            let wilson = wilson_interval(p, orbits);
            return (low.min(wilson.0), high.max(wilson.1));
        }
        (low, high)
    };
    let interval = (curves.len() > 1).then(|| whole.probability.iter().enumerate().map(interval).collect());
    EmpiricalCurve { interval, ..whole }
}

/// So few orbits that the spread of groups says little of a count.
pub const FEW: f64 = 50.0;

/// The 97.5 % quantile of Student's distribution, by bisection of its distribution function (Abramowitz & Stegun 26.7.3
/// and 26.7.4).
pub(crate) fn student_quantile(freedom: usize) -> f64 {
    let (mut low, mut high) = (0.0, 0.5 * PI);
    for _ in 0..60 {
        let middle: f64 = 0.5 * (low + high);
        if within(middle, freedom) < 0.95 { low = middle } else { high = middle }
    }
    low.tan() * (freedom as f64).sqrt()
}

/// Probability that a variable of Student's distribution lies within `±sqrt(freedom) tan(angle)`.
fn within(angle: f64, freedom: usize) -> f64 {
    let (sin, cos) = angle.sin_cos();
    let is_odd = freedom % 2 == 1;
    let (mut term, mut sum) = (if is_odd { cos } else { 1.0 }, 0.0);
    for k in (if is_odd { 3 } else { 2 }..=freedom).step_by(2) {
        sum += term;
        let next = k as f64;
        term *= (next - 1.0) / next * cos * cos;
    }
    if is_odd { (angle + sin * sum) / (0.5 * PI) } else { sin * sum }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wilson_interval_solves_wilsons_equation() {
        for (p, n) in [(0.0, 10.0), (0.3, 50.0), (1.0, 7.0), (0.01, 1e4)] {
            let (low, high) = wilson_interval(p, n);
            for bound in [low, high] {
                let sigma = (bound * (1.0 - bound) / n).sqrt();
                assert!((p - bound).abs() < 1e-15 || ((p - bound).abs() / sigma - QUANTILE).abs() < 1e-9);
            }
            assert!(low <= p && p <= high && low < high);
        }
    }

    /// Abramowitz & Stegun, Table 26.10.
    #[test]
    fn students_quantiles_are_those_of_the_table() {
        for (freedom, expected) in [(1, 12.706), (2, 4.303), (3, 3.182), (9, 2.262), (15, 2.131), (30, 2.042)] {
            assert!((student_quantile(freedom) - expected).abs() < 6e-4, "{freedom}: {}", student_quantile(freedom));
        }
        assert!((student_quantile(100_000) - QUANTILE).abs() < 1e-4);
    }

    #[test]
    fn the_interval_of_groups_is_that_of_their_spread_but_never_empty_where_nothing_has_passed() {
        let times = [0.0, 1.0];
        // Two groups of pairs: in the first, everybody passes by 1 yr; in the second, half.
        let points = (0..400).map(|i| if i / 2 % 2 == 0 || i % 4 == 3 { 1 } else { 2 });
        let curve = curve_of_groups(points, 2, &times);
        assert_eq!(curve.probability, [0.0, 0.75]);
        let interval = curve.interval.unwrap();
        assert_eq!(interval[0], wilson_interval(0.0, 400.0));
        // Half of the difference of two groups is their standard error.
        assert_eq!(interval[1], (0.0, 1.0), "a quarter times 12.7 is more than there is");
        assert!(curve_of_groups((0..8).map(|_| 1), 1, &times).interval.is_none());
    }

    #[test]
    fn weights_of_one_are_no_weights() {
        let (passages, times) = ([0.3, f64::INFINITY, 0.1, 0.2], [0.0, 0.1, 0.25, 5.0]);
        let plain = empirical_curve(&passages, None, &times);
        assert_eq!(plain.probability, [0.0, 0.25, 0.5, 0.75]);
        assert_eq!(empirical_curve(&passages, Some(&[2.0; 4]), &times).probability, plain.probability);
        assert_eq!(
            empirical_curve(&passages, Some(&[0.0, 1.0, 3.0, 0.0]), &times).probability,
            [0.0, 0.75, 0.75, 0.75]
        );
    }
}

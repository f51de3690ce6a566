//! The first-passage curve of a weighted sample of orbits.

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
    let orbits = points.len() as f64;
    let mut counts = vec![0usize; times.len()];
    for point in points {
        if let Some(count) = counts.get_mut(point) {
            *count += 1;
        }
    }
    let mut passed = 0;
    let share = |count: &usize| {
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
/// normal approximation does not reject the observation (Wilson, J. Am. Stat. Assoc. 22, 1927). Unlike `p ± 2 sigma` it stays
/// within `[0, 1]` and is not empty at `p = 0`. Without trials it is `[0, 1]`.
pub fn wilson_interval(p: f64, count: f64) -> (f64, f64) {
    if count <= 0.0 {
        return (0.0, 1.0);
    }
    let z2 = QUANTILE * QUANTILE / count;
    let centre = (p + 0.5 * z2) / (1.0 + z2);
    let half = QUANTILE * (p * (1.0 - p) / count + 0.25 * z2 / count).sqrt() / (1.0 + z2);
    ((centre - half).clamp(0.0, p), (centre + half).clamp(p, 1.0))
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

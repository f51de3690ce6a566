//! What re-entry, or its absence, says of an uncertain radiation parameter: its moments given that event.

use crate::exact::Estimated;

/// Mean and standard deviation of the radiation parameter given an event, each with an estimate of its error or its
/// standard error; NaN where they are not known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Given {
    /// Mean.
    pub mean: Estimated,
    /// Standard deviation.
    pub deviation: Estimated,
}

/// Nothing known.
const UNKNOWN: Estimated = Estimated { value: f64::NAN, error: f64::NAN };

impl Given {
    /// Nothing is known, as of an event that is as good as impossible.
    pub const UNKNOWN: Self = Self { mean: UNKNOWN, deviation: UNKNOWN };

    /// The same without errors.
    #[must_use]
    pub fn without_errors(self) -> Self {
        let bare = |of: Estimated| Estimated { error: f64::NAN, ..of };
        Self { mean: bare(self.mean), deviation: bare(self.deviation) }
    }

    /// From the integrals of 1, `d` and `d²` over the event, where the parameter is `centre + scale d`. Their errors
    /// are taken to add up. Nothing is told that is known no better than `scale`, the deviation of the parameter itself.
    pub(super) fn of_integrals([mass, first, second]: [Estimated; 3], (centre, scale): (f64, f64)) -> Self {
        let over_mass = |sum: Estimated| {
            let value = sum.value / mass.value;
            Estimated { value, error: (sum.error + value.abs() * mass.error) / mass.value }
        };
        let (mean, square) = (over_mass(first), over_mass(second));
        let variance = square.value - mean.value * mean.value;
        let of_variance = square.error + 2.0 * mean.value.abs() * mean.error;
        let deviation = variance.max(0.0).sqrt();
        // A variance within its own error of zero has a root of any size up to that of the error.
        let of_deviation = (of_variance / (2.0 * deviation)).min(of_variance.sqrt());
        if mean.error >= 1.0 || of_deviation >= 1.0 {
            return Self::UNKNOWN;
        }
        Self {
            mean: Estimated { value: centre + scale * mean.value, error: scale * mean.error },
            deviation: Estimated { value: scale * deviation, error: scale * of_deviation },
        }
    }

    /// From the number of the members of a sample and the sums of their `d`, `d²`, `d³` and `d⁴`, where the parameter
    /// is `centre + scale d`. The errors are the standard errors for independent members (Kendall & Stuart, *The
    /// Advanced Theory of Statistics* 1, 1977, Sect. 10.6).
    fn of_sums([count, sums @ ..]: [f64; 5], (centre, scale): (f64, f64)) -> Self {
        if count == 0.0 {
            return Self::UNKNOWN;
        }
        let [first, second, third, fourth] = sums.map(|sum| sum / count);
        let variance = (second - first * first).max(0.0);
        let fourth = fourth - 4.0 * first * third + 6.0 * first * first * second - 3.0 * first * first * first * first;
        let deviation = variance.sqrt();
        let (of_mean, of_deviation) = match count > 1.0 && variance > 0.0 {
            true => (
                (variance / count).sqrt(),
                ((fourth - variance * variance).max(0.0) / count).sqrt() / (2.0 * deviation),
            ),
            false => (f64::NAN, f64::NAN),
        };
        Self {
            mean: Estimated { value: centre + scale * first, error: scale * of_mean },
            deviation: Estimated { value: scale * deviation, error: scale * of_deviation },
        }
    }
}

/// The moments of the parameter given that an orbit has passed, and given that it has not, by each of `times` times.
/// Each orbit of the sample has its parameter and the position of the time by which it has passed
/// ([`super::empirical::point`]).
pub fn of_sample(orbits: impl Iterator<Item = (f64, usize)> + Clone, times: usize) -> Vec<[Given; 2]> {
    // Sums about a value among the orbits, in units of their spread, lose no digits.
    let Some((centre, _)) = orbits.clone().next() else { return vec![[Given::UNKNOWN; 2]; times] };
    let scale = orbits.clone().map(|(value, _)| (value - centre).abs()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let mut by_point = vec![[0.0; 5]; times + 1];
    for (value, point) in orbits {
        let d = (value - centre) / scale;
        let sums = &mut by_point[point.min(times)];
        [1.0, d, d * d, d * d * d, d * d * d * d].iter().zip(sums).for_each(|(power, sum)| *sum += power);
    }
    let add = |sums: &mut [f64; 5], more: &[f64; 5]| {
        sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        Some(*sums)
    };
    let passed: Vec<[f64; 5]> = by_point.iter().scan([0.0; 5], add).collect();
    let mut still: Vec<[f64; 5]> = by_point.iter().rev().scan([0.0; 5], add).collect();
    still.reverse();
    (0..times).map(|k| [passed[k], still[k + 1]].map(|sums| Given::of_sums(sums, (centre, scale)))).collect()
}

/// The moments of several parts together, each with its number of members. Standard errors are those of independent
/// parts.
pub fn pooled(parts: &[(f64, Given)]) -> Given {
    let parts = || parts.iter().filter(|(count, given)| *count > 0.0 && given.mean.value.is_finite());
    let count: f64 = parts().map(|(count, _)| count).sum();
    if count == 0.0 {
        return Given::UNKNOWN;
    }
    let mean = parts().map(|(count, given)| count * given.mean.value).sum::<f64>() / count;
    let square = |given: &Given| given.deviation.value.powi(2) + (given.mean.value - mean).powi(2);
    let deviation = (parts().map(|(count, given)| count * square(given)).sum::<f64>() / count).sqrt();
    let knows = count > 1.0 && parts().any(|(_, given)| given.mean.error.is_finite());
    // A part of a single member has no error of its own, and hardly any weight.
    let of_parts =
        parts().map(|(count, given)| (count * given.deviation.error).powi(2)).filter(|term| term.is_finite());
    let error = |error: f64| if knows { error } else { f64::NAN };
    Given {
        mean: Estimated { value: mean, error: error(deviation / count.sqrt()) },
        deviation: Estimated { value: deviation, error: error(of_parts.sum::<f64>().sqrt() / count) },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Skewed numbers, of which every seventh orbit passes early, every third late, and the rest never.
    fn orbits(count: u32) -> Vec<(f64, usize)> {
        let one = |i: u32| {
            let uniform = f64::from(i * 7919 % 10_007) / 10_007.0;
            (
                0.15 + 0.01 * uniform * uniform,
                if i.is_multiple_of(7) { 0 } else { 1 + usize::from(!i.is_multiple_of(3)) },
            )
        };
        (0..count).map(one).collect()
    }

    fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        (mean, (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt())
    }

    #[test]
    fn the_moments_of_a_sample_are_those_of_its_members_that_have_passed_and_of_the_others() {
        let all = orbits(5000);
        let given = of_sample(all.iter().copied(), 2);
        for (k, given) in given.iter().enumerate() {
            for (has_passed, given) in [(true, given[0]), (false, given[1])] {
                let chosen = all.iter().filter(|(_, point)| (*point <= k) == has_passed).map(|(value, _)| *value);
                let (mean, deviation) = mean_and_deviation(&chosen.collect::<Vec<_>>());
                assert!((given.mean.value - mean).abs() < 1e-14, "{k} {has_passed}: {given:?}");
                assert!((given.deviation.value / deviation - 1.0).abs() < 1e-10, "{k} {has_passed}: {given:?}");
            }
        }
    }

    #[test]
    fn the_standard_errors_are_the_scatter_of_samples() {
        let samples: Vec<Given> = (0..400)
            .map(|sample: u32| {
                let one = |i: u32| {
                    let hashed = (sample * 1000 + i).wrapping_mul(2_654_435_761) ^ (sample * 1000 + i).rotate_left(13);
                    let uniform = f64::from(hashed.wrapping_mul(2_246_822_519)) / f64::from(u32::MAX);
                    (0.15 + 0.01 * uniform * uniform, 0)
                };
                of_sample((0..1000).map(one), 1)[0][0]
            })
            .collect();
        let scatter = |of: fn(&Given) -> Estimated| {
            let (_, deviation) = mean_and_deviation(&samples.iter().map(|given| of(given).value).collect::<Vec<_>>());
            let stated = samples.iter().map(|given| of(given).error).sum::<f64>() / samples.len() as f64;
            deviation / stated
        };
        for ratio in [scatter(|given| given.mean), scatter(|given| given.deviation)] {
            assert!((0.85..1.15).contains(&ratio), "{ratio}");
        }
    }

    #[test]
    fn parts_together_have_the_moments_of_the_whole() {
        let all = orbits(5000);
        let whole = of_sample(all.iter().copied(), 2)[0][0];
        let part = |range: std::ops::Range<usize>| {
            let part = &all[range];
            let count = part.iter().filter(|(_, point)| *point == 0).count() as f64;
            (count, of_sample(part.iter().copied(), 2)[0][0])
        };
        let together = pooled(&[part(0..1), part(1..1200), part(1200..5000)]);
        assert!((together.mean.value - whole.mean.value).abs() < 1e-14);
        assert!((together.deviation.value / whole.deviation.value - 1.0).abs() < 1e-10);
        assert!((together.mean.error / whole.mean.error - 1.0).abs() < 1e-10);
        assert!((together.deviation.error / whole.deviation.error - 1.0).abs() < 0.05);
        assert!(pooled(&[]).mean.value.is_nan());
    }

    #[test]
    fn nothing_is_known_of_an_event_that_no_orbit_has_seen() {
        let given = of_sample([(0.1, 1), (0.2, 1)].into_iter(), 1)[0];
        assert!(given[0].mean.value.is_nan() && given[0].deviation.error.is_nan());
        assert!((given[1].mean.value - 0.15).abs() < 1e-15 && (given[1].deviation.value - 0.05).abs() < 1e-15);
        assert!(of_sample(std::iter::empty(), 3).iter().all(|given| given[0].mean.value.is_nan()));
    }

    /// A Gaussian given that it is above its mean has the mean `sqrt(2/pi)` and the variance `1 - 2/pi`.
    #[test]
    fn integrals_give_the_moments_and_an_error_that_grows_with_theirs() {
        let first = 1.0 / (2.0 * std::f64::consts::PI).sqrt();
        let sums = |error: f64| [0.5, first, 0.5].map(|value| Estimated { value, error });
        let given = Given::of_integrals(sums(1e-6), (0.15, 0.01));
        assert!((given.mean.value - 0.15 - 0.01 * 2.0 * first).abs() < 1e-15);
        assert!((given.deviation.value - 0.01 * (1.0 - 4.0 * first * first).sqrt()).abs() < 1e-15);
        assert!((1e-8..1e-7).contains(&given.mean.error) && (1e-8..1e-7).contains(&given.deviation.error));
        let doubled = Given::of_integrals(sums(2e-6), (0.15, 0.01));
        assert!((doubled.deviation.error / given.deviation.error - 2.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_known_no_better_than_the_parameter_itself_is_not_told() {
        // An event of 0.003 whose parameter is half a deviation above the mean.
        let sums = |error: f64| [0.003, 0.0015, 0.002].map(|value| Estimated { value, error });
        assert!(Given::of_integrals(sums(1e-5), (0.15, 0.01)).mean.error < 0.001);
        assert!(Given::of_integrals(sums(3e-3), (0.15, 0.01)).mean.value.is_nan());
    }
}

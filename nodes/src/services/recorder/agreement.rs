//! Whether methods with known errors agree.
//!
//! An exact density with its error estimates is compared with itself, with samples and with other exact densities of
//! the same run.
//!
//! A figure of an exact method may be off by [`ESTIMATES`] times its own error estimate. The further error that is
//! allowed for samples follows from inequalities that hold for any distribution, so that a rare part of a cloud,
//! which a sample has missed, raises no alarm: Bernstein's with the sample's own variance for moments (Maurer &
//! Pontil, *Empirical Bernstein bounds and sample variance penalization*, 2009, Theorem 4), Chernoff's for counts,
//! McDiarmid's for the total variation. The number of comparisons is counted, and each gets its part of
//! [`FALSE_ALARMS`].

use super::cloud::Cloud;
use crate::services::passage_rules::{INDEPENDENT, Row, divergence, rows};
use crate::services::reading::Reading;
use kit::diagnosis;
use kit::kind::counted_samples;
use kit::space::Quantity;

/// Probability of an alarm in a run in which all methods are right.
const FALSE_ALARMS: f64 = 1e-4;
/// Factor by which a true error may exceed its error estimate.
const ESTIMATES: f64 = 10.0;
/// Tolerated rounding error of sums over many bins.
const ROUNDING: f64 = 1e-9;

/// The results of a case in a scenario.
pub(super) struct CaseResults<'a> {
    pub(super) label: &'a str,
    pub(super) snapshots: Vec<&'a Reading>,
    /// The payload of its first-passage curve; empty if there is none that can be used.
    pub(super) passage: Vec<f64>,
    /// How many samples the curve was counted from, or 0.
    pub(super) counted: u64,
}

impl CaseResults<'_> {
    fn is_exact(&self) -> bool {
        self.snapshots.first().is_some_and(|first| diagnosis::of(&first.header).is_stated())
    }
}

/// Two statements that contradict one another.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Contradiction {
    pub(super) label: String,
    /// Time \[yr\].
    pub(super) time: f64,
    /// In words.
    pub(super) what: String,
}

/// A comparison that has been made.
struct Comparison {
    label: String,
    time: f64,
    /// Both statements in words.
    what: String,
    test: Test,
}

/// How a comparison is judged.
enum Test {
    /// A difference, of which `known` is allowed. For samples, noise is allowed in addition: a number of standard
    /// errors, and the part of `range` that a part of the cloud can cause that all `samples` samples have missed.
    Difference { difference: f64, known: f64, standard_error: f64, range: f64, samples: f64 },
    /// A share of samples, where the probability lies in an interval.
    Count { share: f64, samples: f64, interval: (f64, f64) },
    /// A total variation, where the expected one is known.
    Variation { distance: f64, expected: f64, samples: f64 },
}

impl Test {
    /// Whether it fails, if a false alarm may have a probability of `4 exp(-l)`.
    fn fails(&self, l: f64) -> bool {
        match *self {
            Self::Difference { difference, known, standard_error, range, samples } => {
                let missed = if samples > 1.0 { 7.0 * range * l / (3.0 * (samples - 1.0)) } else { 0.0 };
                difference > known + standard_error * (2.0 * l).sqrt() + missed
            }
            Self::Count { share, samples, interval: (low, high) } => {
                let nearest = share.clamp(low.min(high), high);
                samples * INDEPENDENT * divergence(share, nearest) > l
            }
            Self::Variation { distance, expected, samples } => {
                distance > expected + (l / (2.0 * INDEPENDENT * samples)).sqrt()
            }
        }
    }
}

/// All contradictions within a case or between two cases, in one of the `scenarios` scenarios of a run.
pub(super) fn contradictions(cases: &[CaseResults<'_>], critical: f64, scenarios: u32) -> Vec<Contradiction> {
    let mut comparisons = Vec::new();
    for (place, exact) in cases.iter().enumerate().filter(|(_, case)| case.is_exact()) {
        comparisons.extend(exact.snapshots.iter().flat_map(|snapshot| with_itself(exact.label, snapshot, critical)));
        for (other_place, other) in cases.iter().enumerate() {
            let is_met_once = other_place > place || !other.is_exact();
            if other_place != place && is_met_once {
                for (a, b) in exact.snapshots.iter().zip(&other.snapshots) {
                    comparisons.extend(of_snapshots((exact.label, a), (other.label, b)));
                }
                comparisons.extend(of_passages(exact, other));
            }
        }
    }
    let chances = comparisons.len() as f64 * f64::from(scenarios.max(1));
    let l = (4.0 * chances / FALSE_ALARMS).ln();
    let failed = comparisons.into_iter().filter(|comparison| comparison.test.fails(l));
    failed.map(|Comparison { label, time, what, .. }| Contradiction { label, time, what }).collect()
}

/// Compares figures that an exact density states twice: its joint density gives a mass, which must be 1, and the mean
/// of the re-entry variable and the probability that it is above its critical value, which are also stated by
/// themselves.
fn with_itself(label: &str, reading: &Reading, critical: f64) -> Vec<Comparison> {
    let (header, space) = (&reading.header, &reading.space);
    let reentry = space.reentry;
    let Some((density, axis)) = reading.marginal(reentry) else { return Vec::new() };
    let [moments, _, probability, joint] = header.diagnostics.map(|estimate| ESTIMATES * estimate);
    let missing = (1.0 - header.mass_on_grid).max(0.0);
    let width = axis.width();
    let name = &space.variables[reentry].name;
    let (mean, deviation) = (reading.value(Quantity::Mean(reentry)), reading.value(Quantity::Deviation(reentry)));
    let above = reading.value(Quantity::AboveCritical);
    let shares: Vec<f64> = density.iter().map(|density| density * width).collect();
    let of_bins: f64 =
        shares.iter().enumerate().map(|(bin, share)| share * (axis.low + (bin as f64 + 0.5) * width)).sum();
    let from = |first: f64| (((first - axis.low) / width).max(0.0) as usize).min(shares.len());
    let surely: f64 = shares[from(critical + width)..].iter().sum();
    let perhaps: f64 = shares[from(critical)..].iter().sum::<f64>() + missing;
    let comparison = |what: String, difference: f64, known: f64| {
        let exactly =
            Test::Difference { difference, known: known + ROUNDING, standard_error: 0.0, range: 0.0, samples: 0.0 };
        Comparison {
            label: label.into(),
            time: header.time,
            what: format!("{label} contradicts itself: {what}"),
            test: exactly,
        }
    };
    let mass = header.mass_on_grid;
    vec![
        comparison(format!("its joint density has a mass of {mass:.6}; a density has 1"), mass - 1.0, joint),
        comparison(
            format!("its mean {name} is {mean:.6}, that of its joint density {:.6}", of_bins / mass),
            (of_bins / mass - mean).abs(),
            0.5 * width + missing / mass + joint + moments * deviation,
        ),
        comparison(
            format!(
                "its probability above the critical {name} is {above:.6}, by its joint density it is {surely:.6} to \
                 {perhaps:.6}"
            ),
            (surely - above).max(above - perhaps),
            probability + joint,
        ),
    ]
}

/// Compares a snapshot of an exact density with that of another case with known errors.
fn of_snapshots(exact: (&str, &Reading), other: (&str, &Reading)) -> Vec<Comparison> {
    let (a, b) = (Cloud::of(exact.1), Cloud::of(other.1));
    let (Some(a), Some(b)) = (a, b) else { return Vec::new() };
    let (header, space) = (&exact.1.header, &exact.1.space);
    let mut found = Vec::new();
    let mut compare = |what: &str, values: (f64, f64), test: Test| {
        let (label, time) = (exact.0.to_owned(), header.time);
        let what = format!("{} and {} disagree: {what} is {} and {}", exact.0, other.0, told(values.0), told(values.1));
        // Figures that are withheld, or have no known error, are not compared.
        let is_known = match test {
            Test::Difference { difference, known, standard_error, .. } => {
                difference.is_finite() && known.is_finite() && standard_error.is_finite()
            }
            Test::Count { share, interval: (low, high), .. } => {
                share.is_finite() && low.is_finite() && high.is_finite()
            }
            Test::Variation { distance, expected, .. } => distance.is_finite() && expected.is_finite(),
        };
        if is_known {
            found.push(Comparison { label, time, what, test });
        }
    };
    for moment in Cloud::compared(&a, &b) {
        let known = ESTIMATES * (moment.estimates.0 + moment.estimates.1) + moment.branch;
        let (standard_error, range, samples) = (moment.standard_error, moment.range, b.samples);
        let test = Test::Difference { difference: moment.difference, known, standard_error, range, samples };
        compare(&moment.name, moment.values, test);
    }
    let (pa, pb) = (exact.1.value(Quantity::AboveCritical), other.1.value(Quantity::AboveCritical));
    let widened = |reading: &Reading| {
        let (p, estimate) = (reading.value(Quantity::AboveCritical), ESTIMATES * reading.header.diagnostics[2]);
        (p - estimate, p + estimate)
    };
    let above = &space.in_words(Quantity::AboveCritical);
    let (low, high) = widened(exact.1);
    if b.samples > 0.0 {
        compare(above, (pa, pb), Test::Count { share: pb, samples: b.samples, interval: (low, high) });
        if let Some((distance, expected)) = variation(exact.1, other.1, b.samples) {
            let estimate = ESTIMATES * 0.5 * header.diagnostics[3];
            let test = Test::Variation { distance, expected: expected + estimate, samples: b.samples };
            compare(
                "the total variation of their joint densities, counting noise expected and found,",
                (expected, distance),
                test,
            );
        }
    } else if b.is_exact {
        let (other_low, other_high) = widened(other.1);
        let apart = (low - other_high).max(other_low - high);
        let test =
            Test::Difference { difference: apart, known: ROUNDING, standard_error: 0.0, range: 0.0, samples: 0.0 };
        compare(above, (pa, pb), test);
    }
    found
}

/// Total variation of the joint densities, and an upper bound of the one that counting noise is expected to cause.
fn variation(exact: &Reading, sampled: &Reading, samples: f64) -> Option<(f64, f64)> {
    let (a, b) = (&exact.header, &sampled.header);
    counted_samples(b)?;
    let (p, q, area) = (exact.joint(), sampled.joint(), exact.cell(0));
    let outside = (1.0 - a.mass_on_grid, 1.0 - b.mass_on_grid);
    let pairs = p.iter().zip(q).map(|(p, q)| (p * area, q * area)).chain([outside]);
    let (mut distance, mut expected) = (0.0, 0.0);
    for (p, q) in pairs {
        distance += 0.5 * (p - q).abs();
        expected += 0.5 * (p * (1.0 - p) / (INDEPENDENT * samples)).max(0.0).sqrt();
    }
    Some((distance, expected))
}

/// Compares the first-passage curves of an exact method and of another case.
fn of_passages(exact: &CaseResults<'_>, other: &CaseResults<'_>) -> Vec<Comparison> {
    let pairs = rows(&exact.passage).into_iter().zip(rows(&other.passage));
    let pairs = pairs.filter(|(a, b)| (a.time - b.time).abs() <= 1e-9 * a.time.abs());
    let compared = pairs.filter_map(|(a, b)| {
        let interval @ (low, high) = widened(&a)?;
        let test = match other.counted {
            0 if other.is_exact() => {
                let (other_low, other_high) = widened(&b)?;
                let difference = (low - other_high).max(other_low - high);
                Test::Difference { difference, known: ROUNDING, standard_error: 0.0, range: 0.0, samples: 0.0 }
            }
            0 => return None,
            counted => Test::Count { share: b.probability, samples: counted as f64, interval },
        };
        let of = |row: &Row| match row.is_withheld() {
            true => format!("between {} and {}", told(row.low), told(row.high)),
            false => told(row.probability),
        };
        let what = format!(
            "{} and {} disagree: the probability of having reached the critical eccentricity is {} and {}",
            exact.label,
            other.label,
            of(&a),
            of(&b)
        );
        Some(Comparison { label: exact.label.into(), time: a.time, what, test })
    });
    compared.collect()
}

/// The interval in which the probability of an exact method's row lies if its error estimate is right within a factor
/// of [`ESTIMATES`].
fn widened(row: &Row) -> Option<(f64, f64)> {
    let Row { probability: p, low, high, .. } = *row;
    let ends = if row.is_withheld() { (low, high) } else { (p - ESTIMATES * (p - low), p + ESTIMATES * (high - p)) };
    (ends.0.is_finite() && ends.1.is_finite()).then_some(ends)
}

/// A number in a sentence.
fn told(value: f64) -> String {
    if value == 0.0 || (1e-4..1e4).contains(&value.abs()) { format!("{value:.5}") } else { format!("{value:.1e}") }
}

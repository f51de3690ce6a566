//! The rules for a first-passage curve of any sender.
//!
//! The recorder does not use a curve that breaks a rule ([`breach`]), and notes its [`doubts`]; `phasecloud check`
//! reports both.

use density::model::registry::Planar;
use density::problem::Problem;
use density::trust::Diagnosis;
use messages::layout::{GIVEN_COLUMNS, PASSAGE_COLUMNS, PassageHeader};

use crate::services::reading::Reading;
use kit::assignment::Assignment;
use kit::diagnosis;
use kit::kind::counted_samples;
use kit::space::Quantity;

/// Tolerated rounding error of sums of many probabilities.
const ROUNDING: f64 = 1e-6;
/// Tolerated error of figures that come from samples, in standard errors.
const SIGMAS: f64 = 5.0;
/// Tolerated error of a curve that was not counted from samples and has no interval.
const GENEROUS: f64 = 0.01;
/// Tolerated error of a probability of a method that does not know its error.
const UNKNOWN: f64 = 1e-3;
/// Tolerated difference of a count from a whole number. Beyond `MOST_COUNTED` samples rounding may cause a larger
/// one.
const COUNT_ROUNDING: f64 = 1e-3;
const MOST_COUNTED: u64 = 1_000_000_000;
/// Samples that are drawn in antithetic pairs count as half as many independent samples.
pub const INDEPENDENT: f64 = 0.5;
/// Only the order of magnitude is right of probabilities below this one.
const LEAST_PROBABILITY: f64 = 1e-12;

/// A row of a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Time \[yr\].
    pub time: f64,
    /// The probability of having passed by then; NaN if it is withheld.
    pub probability: f64,
    /// Lower end of its interval; NaN if it has none.
    pub low: f64,
    /// Upper end of its interval; NaN if it has none.
    pub high: f64,
}

impl Row {
    /// Whether the probability is withheld.
    pub fn is_withheld(&self) -> bool {
        self.probability.is_nan()
    }

    /// How wide its interval is; NaN if it has none.
    pub fn width(&self) -> f64 {
        self.high - self.low
    }

    /// The least and the largest probability that the row allows.
    pub fn ends(&self) -> (f64, f64) {
        let or = |end: f64| if end.is_nan() { self.probability } else { end };
        (or(self.low), or(self.high))
    }
}

/// The numbers of a curve in a payload, whose rows may go on with what re-entry says of an uncertain parameter.
pub fn curve_in(header: &PassageHeader, items: &[f64]) -> Vec<f64> {
    let columns = PASSAGE_COLUMNS + if header.given == 0 { 0 } else { GIVEN_COLUMNS };
    items.chunks_exact(columns).flat_map(|row| &row[..PASSAGE_COLUMNS]).copied().collect()
}

/// The rows of a payload.
pub fn rows(items: &[f64]) -> Vec<Row> {
    let row = |row: &[f64]| Row { time: row[0], probability: row[1], low: row[2], high: row[3] };
    items.chunks_exact(PASSAGE_COLUMNS).map(row).collect()
}

/// The first thing that makes a curve impossible, if there is one: the row, and what would be right.
pub fn breach(items: &[f64]) -> Option<String> {
    let rows = rows(items);
    rows.iter().find_map(breach_of_row).or_else(|| falls(&rows))
}

fn breach_of_row(Row { time, probability, low, high }: &Row) -> Option<String> {
    let possible = -ROUNDING..=1.0 + ROUNDING;
    let has_ends = !low.is_nan() && !high.is_nan();
    let what = match () {
        () if low.is_nan() != high.is_nan() => {
            format!("has an interval from {low} to {high}; it has both ends or none")
        }
        () if probability.is_nan() && !has_ends => "is NaN without an interval; what is withheld has bounds".to_owned(),
        () if !probability.is_nan() && !possible.contains(probability) => {
            format!("is {probability}; a probability lies between 0 and 1")
        }
        () if has_ends && (!possible.contains(low) || !possible.contains(high)) => {
            format!("has an interval from {low} to {high}; both ends lie between 0 and 1")
        }
        () if has_ends && *low > high + ROUNDING => {
            format!("has an interval from {low} to {high}; low is never above high")
        }
        () if has_ends && !(low - ROUNDING..=high + ROUNDING).contains(probability) && !probability.is_nan() => {
            format!("is {probability}, outside its interval from {low} to {high}")
        }
        () => return None,
    };
    Some(format!("the probability at {time} yr {what}"))
}

/// Checks that a curve does not fall: a probability must not be below an earlier one, even at the ends of their
/// intervals.
fn falls(rows: &[Row]) -> Option<String> {
    if let Some(pair) = rows.windows(2).find(|pair| pair[1].time <= pair[0].time) {
        return Some(format!("a row at {} yr follows one at {} yr; times ascend", pair[1].time, pair[0].time));
    }
    // The largest lower end and the largest probability so far, with their times.
    let (mut certain, mut claimed) = ((0.0, 0.0), (0.0, 0.0));
    for row in rows {
        let (low, high) = row.ends();
        let Row { time, probability, .. } = *row;
        for ((least, since), most) in [(claimed, probability), (certain, high)] {
            if most < least - ROUNDING {
                return Some(format!(
                    "the probability falls from {least} at {since} yr to {most} at {time} yr; who has passed has passed"
                ));
            }
        }
        if low > certain.0 {
            certain = (low, time);
        }
        if probability > claimed.0 {
            claimed = (probability, time);
        }
    }
    None
}

/// A curve that breaks no rule, with the rounding errors of its probabilities removed.
pub fn without_rounding(items: &[f64]) -> Vec<f64> {
    let mut items = items.to_vec();
    for row in items.chunks_exact_mut(PASSAGE_COLUMNS) {
        row[1..].iter_mut().for_each(|p| *p = if p.is_nan() { *p } else { p.clamp(0.0, 1.0) });
        if !row[1].is_nan() && !row[2].is_nan() {
            row[2] = row[2].min(row[1]);
            row[3] = row[3].max(row[1]);
        }
    }
    items
}

/// The known facts that a curve contradicts: the initial Gaussian, and the probabilities of being above the critical
/// eccentricity at the snapshots of the same case. `samples` is the number of equally weighted samples from which the
/// curve was counted, 0 if it was not counted.
pub fn doubts(items: &[f64], samples: u64, assignment: &Assignment, snapshots: &[&Reading]) -> Vec<String> {
    let rows = rows(items);
    let Some(first) = rows.first() else { return Vec::new() };
    let problem = assignment.plane.as_ref().filter(|_| first.time == 0.0).map(|plane| &plane.problem);
    let at_start = problem.and_then(|problem| off_the_start(first, samples, problem));
    let overtaken = snapshots.iter().find_map(|snapshot| overtaken(&rows, samples, snapshot));
    let uncounted = not_a_count(&rows, samples).or_else(|| more_than_there_are(samples, snapshots));
    at_start.into_iter().chain(uncounted).chain(overtaken).collect()
}

/// A probability that is counted from samples is a whole number divided by the number of samples.
fn not_a_count(rows: &[Row], samples: u64) -> Option<String> {
    if samples == 0 || samples > MOST_COUNTED {
        return None;
    }
    let off = |row: &&Row| {
        let count = row.probability * samples as f64;
        !row.is_withheld() && (count - count.round()).abs() > COUNT_ROUNDING
    };
    rows.iter().find(off).map(|row| {
        format!(
            "its first-passage curve is said to be counted from {samples} samples, but {} by {} yr is no whole number of them",
            row.probability, row.time
        )
    })
}

/// A curve cannot be counted from more samples than the case has.
fn more_than_there_are(samples: u64, snapshots: &[&Reading]) -> Option<String> {
    let rows = snapshots.iter().find_map(|snapshot| counted_samples(&snapshot.header))?;
    (samples > u64::from(rows)).then(|| {
        format!("its first-passage curve is said to be counted from {samples} samples, but its snapshots have {rows}")
    })
}

/// At `t = 0` exactly the orbits at or above the critical eccentricity have passed.
fn off_the_start(first: &Row, samples: u64, problem: &Problem<Planar>) -> Option<String> {
    let right = problem.initial.probability_above(problem.critical_e);
    let (low, high) = first.ends();
    let allowed = allowance(right, samples, high - low);
    let off = (low - right).max(right - high);
    (off > allowed).then(|| {
        let seen = if first.is_withheld() { format!("between {low} and {high}") } else { first.probability.to_string() };
        format!(
            "its first-passage curve begins with {seen}, but {right:.5} of the initial cloud is at or above the critical \
             eccentricity"
        )
    })
}

/// Every orbit that is above the critical eccentricity has passed.
fn overtaken(rows: &[Row], samples: u64, reading: &Reading) -> Option<String> {
    let (above, snapshot) = (reading.value(Quantity::AboveCritical), &reading.header);
    // The curve does not fall: at its next time it is at least as high as at the time of the snapshot.
    let row = rows.iter().find(|row| row.time >= snapshot.time * (1.0 - 1e-12))?;
    let (low, high) = row.ends();
    let of_snapshot = match diagnosis::of(snapshot) {
        Diagnosis::Stated { probability, .. } => 10.0 * probability,
        _ => SIGMAS * reading.error(Quantity::AboveCritical),
    };
    // The error of a mesh or a mixture is not known.
    let least = above - if of_snapshot.is_nan() { UNKNOWN } else { of_snapshot };
    let is_counted = samples > 0 && !row.is_withheld();
    let claimed = if row.is_withheld() { high } else { row.probability };
    let contradicted = match is_counted {
        true => least > claimed && samples as f64 * INDEPENDENT * divergence(claimed, least) > 0.5 * SIGMAS * SIGMAS,
        false => least - high > allowance(high, 0, high - low),
    };
    contradicted.then(|| {
        format!(
            "its probability of being above the critical eccentricity at {} yr is {above:.5}, but of ever having reached it by \
             {} yr only {claimed:.5}; who is above it has passed",
            snapshot.time, row.time
        )
    })
}

/// Kullback-Leibler divergence `D(p, q)` of two Bernoulli distributions with the probabilities `p` and `q`. If each
/// of `n` independent samples has the probability `q > p`, a share of `p` or less of them has a probability of at
/// most `exp(-n D(p, q))` (Chernoff).
pub fn divergence(p: f64, q: f64) -> f64 {
    let q = q.clamp(LEAST_PROBABILITY, 1.0 - LEAST_PROBABILITY);
    let term = |p: f64, q: f64| if p > 0.0 { p * (p / q).ln() } else { 0.0 };
    term(p, q) + term(1.0 - p, 1.0 - q)
}

/// Tolerated error of a probability of a curve. For a curve that was counted from `samples` samples this is the
/// counting noise. For others (`samples` is 0) it follows from the `width` of the interval. The ends of a 95 %
/// interval lie two standard errors from its middle, so five standard errors reach three quarters of its width beyond
/// them. A narrow interval may be an error estimate, which is right within a factor of ten.
pub fn allowance(probability: f64, samples: u64, width: f64) -> f64 {
    match samples {
        0 if width > 0.0 => (10.0 * width).min(GENEROUS.max(0.75 * width)) + 1e-9,
        0 => GENEROUS,
        n => {
            let p = probability.clamp(0.0, 1.0);
            SIGMAS * (p * (1.0 - p) / n as f64).sqrt() + 25.0 / n as f64
        }
    }
}

#[cfg(test)]
mod tests {
    use messages::content::kind;
    use messages::layout::DensityHeader;

    use super::*;

    const NAN: f64 = f64::NAN;

    fn curve(rows: &[[f64; 3]]) -> Vec<f64> {
        rows.iter().enumerate().flat_map(|(k, [p, low, high])| [0.5 * k as f64, *p, *low, *high]).collect()
    }

    #[test]
    fn a_curve_that_cannot_be_right_is_told_with_its_row_and_one_that_withholds_within_bounds_is_good() {
        for good in [
            &[[0.0, NAN, NAN], [0.3, NAN, NAN], [0.3, NAN, NAN]][..],
            &[[0.0, 0.0, 0.1], [NAN, 0.0, 0.9], [1.0, 0.9, 1.0]],
            &[[0.0, 0.0, 0.0], [1.000_000_3, 1.0, 1.000_000_3]],
            &[[0.5, 0.5, 0.5], [0.5, 0.4, 0.6]], // the interval widens, but the probability does not fall
            &[],
        ] {
            assert_eq!(breach(&curve(good)), None);
        }
        for (bad, words) in [
            (&[[0.3, NAN, NAN], [0.2, NAN, NAN]][..], "falls from 0.3 at 0 yr to 0.2 at 0.5 yr"),
            (&[[0.1, 0.2, 0.05]], "has an interval from 0.2 to 0.05; low is never above high"),
            (&[[0.1, -0.1, 0.2]], "both ends lie between 0 and 1"),
            (&[[0.5, 0.1, 0.2]], "is 0.5, outside its interval"),
            (&[[1.995, NAN, NAN]], "is 1.995; a probability lies between 0 and 1"),
            (&[[f64::INFINITY, NAN, NAN]], "is inf"),
            (&[[NAN, NAN, NAN]], "is NaN without an interval"),
            (&[[0.1, NAN, 0.2]], "both ends or none"),
            (&[[NAN, 0.4, 0.5], [NAN, 0.0, 0.3]], "falls from 0.4 at 0 yr to 0.3 at 0.5 yr"),
            (&[[0.5, NAN, NAN], [NAN, 0.0, 1.0], [0.2, NAN, NAN]], "falls from 0.5 at 0 yr to 0.2 at 1 yr"),
        ] {
            let what = breach(&curve(bad)).unwrap();
            assert!(what.contains(words), "{what}");
        }
    }

    #[test]
    fn rounding_leaves_no_probability_outside_0_and_1_and_none_outside_its_interval() {
        let rows =
            rows(&without_rounding(&curve(&[[1.000_000_3, 1.0, 1.0], [-1e-9, 0.0, 0.1], [NAN, 0.2, 1.000_001]])));
        assert_eq!((rows[0].probability, rows[0].high, rows[1].probability, rows[1].low), (1.0, 1.0, 0.0, 0.0));
        assert!(rows[2].is_withheld() && rows[2].high == 1.0);
    }

    #[test]
    fn a_curve_contradicts_the_initial_cloud_or_its_own_snapshots_only_beyond_its_noise() {
        // Nothing of this cloud is at or above the critical eccentricity at the start; its second snapshot is at 0.5
        // yr.
        let assignment = kit::example::assignment();
        let snapshot = |above: f64| {
            let mut numbers = vec![NAN; Reading::numbers_of(&assignment)];
            numbers[5] = above;
            let header = DensityHeader {
                index: 1,
                count: 2,
                time: 0.7,
                rows: 2_000,
                kind: kind::SAMPLES,
                ..DensityHeader::default()
            };
            let header = DensityHeader { quantities: 8, diagnostics: [NAN; 4], ..header };
            Reading::new(header, &numbers, &assignment).unwrap()
        };
        let doubts = |rows: &[[f64; 3]], samples: u64, above: f64| {
            doubts(&curve(rows), samples, &assignment, &[&snapshot(above)]).join("; ")
        };
        let good = [[0.0, NAN, NAN], [0.2, NAN, NAN], [0.4, NAN, NAN]];
        assert_eq!(doubts(&good, 0, 0.4), "");
        assert!(doubts(&[[0.3, NAN, NAN]; 3], 0, 0.3).contains("begins with 0.3, but 0.00000 of the initial cloud"));
        assert!(
            doubts(&[[0.3, 0.2, 0.4]; 3], 0, 0.3).contains("begins with 0.3"),
            "an interval that the truth is far from"
        );
        let overtaken = doubts(&good, 0, 0.5);
        assert!(
            overtaken.contains("at 0.7 yr is 0.50000, but of ever having reached it by 1 yr only 0.40000"),
            "{overtaken}"
        );
        assert_eq!(doubts(&good, 100, 0.5), "", "five standard errors of 100 samples are 0.24");
        assert!(doubts(&good, 2_000, 0.5).contains("only 0.40000"));
        let few = doubts(&[[0.0, NAN, NAN], [0.3, 0.1, 0.6], [0.3, 0.1, 0.6]], 10, 1.0);
        assert!(few.contains("by 1 yr only 0.30000"), "ten samples cannot have missed what is certain: {few}");
        assert!(doubts(&[[0.0, NAN, NAN], [0.333, 0.1, 0.6]], 10, 0.3).contains("0.333 by 0.5 yr is no whole number"));
        assert!(doubts(&good, 5_000, 0.4).contains("counted from 5000 samples, but its snapshots have 2000"));
        // All probabilities are withheld within bounds: nothing is stated that could be wrong.
        assert_eq!(doubts(&[[NAN, 0.0, 1.0]; 3], 0, 1.0), "");
        assert_eq!(doubts(&good, 0, NAN), "", "a withheld probability contradicts nothing");
    }
}

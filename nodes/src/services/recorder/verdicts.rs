//! What each method is good for at a tolerance: the rows of `verdicts.csv`.
//!
//! If a reference states a quantity, a method is judged by its distance from that reference. The reference itself,
//! and a method if no reference states the quantity, are judged by what is known of their own errors
//! (`density/src/trust.rs`). The noise of a distance is, for a moment, two standard errors of the method and of the
//! reference together, and for a density the counting noise of both. A distance that does not exceed `BEYOND_NOISE`
//! times its noise is as good as sampling allows.

use density::trust::{self, Verdict};
use results::rows::VerdictRow;

use super::Recording;
use crate::services::comparator::{difference, distances_on};
use crate::services::reading::Reading;
use crate::services::roster::Roster;
use crate::services::yardstick::{Figure, stand_for};
use kit::diagnosis;
use kit::kind::counted_samples;
use kit::space::{Quantity, Space};

/// The quantities that are judged: means, deviations and the probability above the critical value.
fn judged_quantities(space: &Space) -> Vec<Quantity> {
    let is_judged = |q: &Quantity| match q {
        Quantity::Mean(_) | Quantity::Deviation(_) | Quantity::AboveCritical => true,
        Quantity::Covariance(..) | Quantity::CircularMean(_) | Quantity::ResultantLength(_) => false,
    };
    space.quantities().into_iter().filter(is_judged).collect()
}

/// A variable with a deviation below this is certain: its errors in deviations say nothing. Methods that need a
/// deviation give such a variable one of 5e-10.
const CERTAIN: f64 = 1e-8;

/// Whether this is the mean or the deviation of a variable that does not vary, by this method and by all references.
fn is_certain(own: &Reading, references: &[(&str, &Reading)], quantity: Quantity) -> bool {
    let (Quantity::Mean(k) | Quantity::Deviation(k)) = quantity else { return false };
    let mut readings = references.iter().map(|(_, reading)| *reading).chain([own]);
    readings.all(|reading| reading.value(Quantity::Deviation(k)) < CERTAIN)
}

/// A distance that exceeds its noise by more than this factor is not explained by noise.
const BEYOND_NOISE: f64 = 2.0;

/// How good one quantity is at one snapshot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Grade {
    Good,
    /// Not distinguishable from sampling error, and not known to be within the tolerance.
    AsSampled,
    /// There is no other reference, and the method knows nothing of its own errors.
    Unknown,
    Bad,
    Withheld,
}

/// A quantity at a snapshot, judged.
#[derive(Debug, Clone)]
struct Judged {
    grade: Grade,
    error: f64,
    noise: f64,
    quantity: String,
    time: f64,
    by: String,
}

/// Judges all cases of a scenario that have not failed.
pub(super) fn of(recording: &Recording, roster: &Roster, tolerance: f64) -> Vec<VerdictRow> {
    let alive = roster.cases.iter().filter(|(_, failed)| !failed);
    alive.filter_map(|(method, _)| Some(row(recording, roster, method, &recording.case(method)?, tolerance))).collect()
}

fn row(recording: &Recording, roster: &Roster, method: &str, case: &[&Reading], tolerance: f64) -> VerdictRow {
    let references: Vec<_> =
        roster.standing_references().filter_map(|label| Some((label, recording.case(label)?))).collect();
    let (mut moments, mut density) = (Vec::new(), Vec::new());
    for (index, own) in case.iter().enumerate() {
        let there: Vec<(&str, &Reading)> =
            references.iter().filter_map(|(label, all)| Some((*label, *all.get(index)?))).collect();
        // Samples withhold nothing: what they do not state is of a variable that their model does not have.
        let is_absent = |q: &Quantity| counted_samples(&own.header).is_some() && own.value(*q).is_nan();
        let is_judged = |q: &Quantity| !is_absent(q) && !is_certain(own, &there, *q);
        for quantity in judged_quantities(&own.space).into_iter().filter(is_judged) {
            moments.push(judge_moment(method, own, &there, quantity, tolerance));
        }
        density.push(judge_density(method, own, &there, tolerance));
    }
    let (moments, density) = (worst(moments), worst(density));
    let verdict = in_words(moments.as_ref(), density.as_ref());
    let none = || Judged {
        grade: Grade::Unknown,
        error: f64::NAN,
        noise: f64::NAN,
        quantity: String::new(),
        time: f64::NAN,
        by: "".into(),
    };
    let (m, d) = (moments.unwrap_or_else(none), density.unwrap_or_else(none));
    VerdictRow {
        scenario: recording.assignment.description.name.clone(),
        method: method.into(),
        verdict,
        tolerance,
        moments_error: m.error,
        moments_noise: m.noise,
        moments_quantity: m.quantity,
        moments_t_yr: m.time,
        moments_judged_by: m.by,
        density_error: d.error,
        density_noise: d.noise,
        density_t_yr: d.time,
        density_judged_by: d.by,
    }
}

/// The entry with the worst grade; among several of them, the one with the largest error or noise.
fn worst(judged: Vec<Judged>) -> Option<Judged> {
    let size = |j: &Judged| if j.error.is_nan() { j.noise } else { j.error.max(j.noise) };
    judged.into_iter().max_by(|a, b| a.grade.cmp(&b.grade).then(size(a).total_cmp(&size(b))))
}

fn in_words(moments: Option<&Judged>, density: Option<&Judged>) -> String {
    let grade = |judged: Option<&Judged>| judged.map_or(Grade::Unknown, |judged| judged.grade);
    let percent = |judged: Option<&Judged>| judged.map_or(f64::NAN, |j| 100.0 * j.error.max(j.noise));
    match (grade(moments), grade(density)) {
        (Grade::AsSampled, Grade::AsSampled) => format!(
            "as good as the sampling error of {:.1} % in the moments and {:.1} % in the density",
            percent(moments),
            percent(density)
        ),
        (Grade::AsSampled, other) => {
            let density = if other == Grade::Good { "good for the density, " } else { "" };
            format!("{density}in the moments as good as the sampling error of {:.1} %", percent(moments))
        }
        (Grade::Good, Grade::AsSampled) => {
            format!("good for moments, in the density as good as the sampling error of {:.1} %", percent(density))
        }
        (_, Grade::AsSampled) => {
            format!("not good for moments, in the density as good as the sampling error of {:.1} %", percent(density))
        }
        (Grade::Unknown, Grade::Unknown) => Verdict::Unknown.words().into(),
        (moments, density) => Verdict::new(moments == Grade::Good, density == Grade::Good).words().into(),
    }
}

fn judge_moment(
    method: &str,
    own: &Reading,
    references: &[(&str, &Reading)],
    quantity: Quantity,
    tolerance: f64,
) -> Judged {
    let judged = |grade, error, noise, by: &str| {
        let (quantity, time, by) = (own.space.name(quantity), own.header.time, by.to_owned());
        Judged { grade, error, noise, quantity, time, by }
    };
    if !Figure::Quantity(quantity).is_stated(own) {
        return judged(Grade::Withheld, f64::NAN, f64::NAN, "withheld");
    }
    let chosen = stand_for(references.iter().copied(), Figure::Quantity(quantity)).filter(|label| *label != method);
    let Some((label, reference)) = references.iter().find(|(label, _)| Some(*label) == chosen) else {
        return own_moment(own, quantity, tolerance, judged);
    };
    let unit = unit(reference, quantity);
    let error = difference(&own.space, quantity, own.value(quantity), reference.value(quantity)).abs() / unit;
    let noise = 2.0 * noise_of(own, quantity).hypot(noise_of(reference, quantity)) / unit;
    judged(graded(error, noise, tolerance), error, noise, label)
}

/// Judges a moment by what the method knows of its own error.
fn own_moment(
    own: &Reading,
    quantity: Quantity,
    tolerance: f64,
    judged: impl Fn(Grade, f64, f64, &str) -> Judged,
) -> Judged {
    const ITSELF: &str = "its own diagnostics";
    if states_its_errors(own) {
        let estimate = Figure::Quantity(quantity).error_estimate(own);
        return judged(graded(estimate, 0.0, tolerance), estimate, 0.0, ITSELF);
    }
    let noise = 2.0 * own.error(quantity) / unit(own, quantity);
    if own.error(quantity).is_finite() {
        return judged(
            if noise <= tolerance { Grade::Good } else { Grade::AsSampled },
            f64::NAN,
            noise,
            "its standard errors",
        );
    }
    let grade = match trusted(own, tolerance) {
        Verdict::Unknown => Grade::Unknown,
        verdict if verdict.moments() => Grade::Good,
        _ => Grade::Bad,
    };
    judged(grade, f64::NAN, f64::NAN, ITSELF)
}

fn judge_density(method: &str, own: &Reading, references: &[(&str, &Reading)], tolerance: f64) -> Judged {
    const ITSELF: &str = "its own diagnostics";
    let header = &own.header;
    let judged = |grade, error, noise, by: &str| {
        let (quantity, time, by) = ("total_variation".to_owned(), header.time, by.to_owned());
        Judged { grade, error, noise, quantity, time, by }
    };
    if !Figure::Densities.is_stated(own) {
        return judged(Grade::Withheld, f64::NAN, f64::NAN, "withheld");
    }
    let chosen = stand_for(references.iter().copied(), Figure::Densities).filter(|label| *label != method);
    if let Some((label, reference)) = references.iter().find(|(label, _)| Some(*label) == chosen) {
        let error = distances_on(own, reference, 0).total_variation;
        let noise = counting_noise(own).hypot(counting_noise(reference));
        return judged(graded(error, noise, tolerance), error, noise, label);
    }
    if states_its_errors(own) {
        let estimate = 0.5 * Figure::Densities.error_estimate(own);
        return judged(graded(estimate, 0.0, tolerance), estimate, 0.0, ITSELF);
    }
    if counted_samples(header).is_some() {
        let noise = counting_noise(own);
        return judged(
            if noise <= tolerance { Grade::Good } else { Grade::AsSampled },
            f64::NAN,
            noise,
            "its counting noise",
        );
    }
    let grade = match trusted(own, tolerance) {
        Verdict::Unknown => Grade::Unknown,
        verdict if verdict.density() => Grade::Good,
        _ => Grade::Bad,
    };
    judged(grade, f64::NAN, f64::NAN, ITSELF)
}

/// Grades a distance with its noise against a tolerance. A distance that is NaN is bad.
fn graded(error: f64, noise: f64, tolerance: f64) -> Grade {
    let is_noise = noise > 0.0 && error <= BEYOND_NOISE * noise;
    match () {
        () if error <= tolerance && noise <= tolerance => Grade::Good,
        () if is_noise => Grade::AsSampled,
        () if error <= tolerance => Grade::Good,
        () => Grade::Bad,
    }
}

/// Whether the method states a density with estimates of its errors.
fn states_its_errors(own: &Reading) -> bool {
    diagnosis::of(&own.header).is_stated()
}

fn trusted(reading: &Reading, tolerance: f64) -> Verdict {
    let (header, space) = (&reading.header, &reading.space);
    let lengths = (0..space.variables.len()).map(|k| reading.value(Quantity::ResultantLength(k)));
    // Variables that are not angles have no resultant length.
    let shortest = lengths.filter(|length| !length.is_nan()).fold(1.0, f64::min);
    trust::trust(diagnosis::of(header), shortest, tolerance)
}

/// The unit in which the error of a quantity is given: the standard deviation of its variable, or 1 for a
/// probability.
fn unit(reading: &Reading, quantity: Quantity) -> f64 {
    match quantity {
        Quantity::Mean(k) | Quantity::Deviation(k) => reading.value(Quantity::Deviation(k)),
        Quantity::AboveCritical => 1.0,
        Quantity::Covariance(..) | Quantity::CircularMean(_) | Quantity::ResultantLength(_) => 1.0, // not judged
    }
}

/// The standard error of a quantity; 0 for methods that have none.
fn noise_of(reading: &Reading, quantity: Quantity) -> f64 {
    let error = reading.error(quantity);
    if error.is_finite() { error } else { 0.0 }
}

/// Expected total variation that counting causes; 0 for a density that was not counted from samples.
fn counting_noise(reading: &Reading) -> f64 {
    counted_samples(&reading.header)
        .map_or(0.0, |samples| trust::counting_noise(reading.joint(), reading.cell(0), f64::from(samples)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_distance_within_its_noise_is_as_good_as_sampling_and_one_that_is_unknown_is_not_good() {
        assert_eq!(graded(0.005, 0.0, 0.01), Grade::Good);
        assert_eq!(graded(0.02, 0.0, 0.01), Grade::Bad);
        assert_eq!(graded(0.02, 0.03, 0.01), Grade::AsSampled);
        assert_eq!(graded(0.005, 0.03, 0.01), Grade::AsSampled, "it could be off by 3 %");
        assert_eq!(graded(0.02, 0.005, 0.01), Grade::Bad, "four times its noise");
        assert_eq!(graded(f64::NAN, 0.0, 0.01), Grade::Bad);
        assert_eq!(graded(f64::INFINITY, 0.0, 0.01), Grade::Bad);
    }

    #[test]
    fn a_verdict_says_what_a_method_is_good_for_and_what_its_samples_allow() {
        let judged = |grade, error, noise| Judged {
            grade,
            error,
            noise,
            quantity: "mean_e".into(),
            time: 1.0,
            by: "exact".into(),
        };
        let good = judged(Grade::Good, 0.001, 0.0);
        let bad = judged(Grade::Bad, 0.3, 0.0);
        let sampled = judged(Grade::AsSampled, 0.02, 0.031);
        assert_eq!(in_words(Some(&good), Some(&good)), "good for moments and density");
        assert!(in_words(Some(&good), Some(&bad)).starts_with("good for moments"));
        assert!(in_words(Some(&bad), Some(&bad)).starts_with("good for neither"));
        assert_eq!(
            in_words(Some(&good), Some(&sampled)),
            "good for moments, in the density as good as the sampling error of 3.1 %"
        );
        let withheld = judged(Grade::Withheld, f64::NAN, f64::NAN);
        assert!(in_words(Some(&good), Some(&withheld)).starts_with("good for moments"));
        assert_eq!(worst(vec![good.clone(), withheld, sampled]).unwrap().grade, Grade::Withheld);
        assert_eq!(worst(vec![good, judged(Grade::Good, 0.002, 0.0)]).unwrap().error, 0.002);
    }
}

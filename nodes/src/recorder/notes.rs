//! What a user should know about a result, in words.

use density::angle::nearest;
use density::mesh::MeshDiagnostics;
use density::mixture::linearity;
use messages::layout::{DensityHeader, diagnostic};
use messages::text::unpack;
use serde::Serialize;

use super::RecordedPassage;
use crate::passage_rules::{Row, rows};
use crate::yardstick::Quantity;

/// An exact density whose own error estimate is above this, in standard deviations, is told.
const MOMENT_ERROR: f64 = 1e-6;
/// Likewise for the resultant vector.
const CIRCULAR_ERROR: f64 = 1e-6;
/// Likewise for the probability above the critical eccentricity.
const PROBABILITY_ERROR: f64 = 1e-6;
/// Likewise for the L1 error of its joint density.
const JOINT_ERROR: f64 = 1e-3;
/// Densities that characteristics carry along are told if they are off by more than this on average.
const CARRIED_DENSITY_ERROR: f64 = 1e-3;
/// The comparison grid holds the image of the 4-sigma ellipse, 0.9997 of the probability: less than this is told.
const LEAST_MASS: f64 = 0.95;
/// And more than this.
const MOST_MASS: f64 = 1.001;

/// A mixture with more of its probability below `e = 0` is told.
const MASS_BELOW_ZERO: f64 = 0.005;
/// An initial Gaussian with more of its probability beyond `e = 1` is told of a mixture.
const MASS_BEYOND_ONE: f64 = 5e-4;
/// An error estimate, in standard deviations or of a probability, that says nothing any more.
const NOTHING_KNOWN: f64 = 100.0;
/// Weights of a mixture that add up to something farther from 1 are told.
const WEIGHTS: f64 = 1e-3;
/// A cloud of a mean resultant length below this is said to reach round the circle.
const ROUND_THE_CIRCLE: f64 = 0.3;

/// How grave a note is: the words that it begins with in `notes.csv`, the gravest first.
pub const SEVERITIES: [&str; 4] = ["fallback: ", "lost: ", "error: ", "warning: "];

/// The place of a note in the order of gravity; plain remarks come last.
pub fn severity(note: &str) -> usize {
    SEVERITIES.iter().position(|word| note.starts_with(word)).unwrap_or(SEVERITIES.len())
}

/// A row of `notes.csv`; `t_yr` is NaN if the note is about the whole scenario.
#[derive(Debug, Clone, Default, Serialize)]
pub(super) struct Note {
    pub(super) scenario: String,
    pub(super) method: String,
    pub(super) t_yr: f64,
    pub(super) note: String,
}

/// Remarks and warnings that a density's own diagnostics and its mass call for.
pub(super) fn of_density(header: &DensityHeader) -> Vec<String> {
    let said = match header.diagnostic {
        diagnostic::MESH => of_mesh(header),
        diagnostic::MIXTURE => of_mixture(header),
        diagnostic::NUMERICAL => of_estimates(header),
        _ => Vec::new(),
    };
    said.into_iter().chain(of_mass(header)).chain(of_spread(header)).collect()
}

fn of_mesh(header: &DensityHeader) -> Vec<String> {
    let (defect, carried_error) = (header.diagnostics[0], header.carried_density_error);
    let limit = MeshDiagnostics::LARGEST_DEFECT;
    let mut said = Vec::new();
    if !is_within(defect, limit) {
        said.push(format!(
            "warning: the mesh is too coarse for the flow here (measure defect {defect:.2}, above {limit}); take more points"
        ));
    }
    let misplaced = header.diagnostics[3];
    if misplaced > 2.0 * limit {
        said.push(format!(
            "warning: the cloud winds too much for the mesh: about {:.1} % of the joint density is in wrong bins; take more \
             points or fewer bins",
            100.0 * misplaced
        ));
    }
    if carried_error > CARRIED_DENSITY_ERROR {
        let percent = 100.0 * carried_error;
        said.push(format!(
            "warning: the densities n that came with its points are off by {percent:.2} % on average from what the points \
             imply; the carried mesh does not use them, but something in the propagator is wrong"
        ));
    }
    said
}

fn of_mixture(header: &DensityHeader) -> Vec<String> {
    let [disagreement, below_zero, weights, beyond_one] = header.diagnostics;
    let mut said = Vec::new();
    if disagreement.is_nan() {
        said.push("how far the flow over its components is from linear is not known".into());
    } else if !is_within(disagreement, linearity::DISTRUST) {
        said.push(format!(
            "warning: components are too wide for the flow here (disagreement {disagreement:.2}, above {}); \
             do not trust the density, split more finely",
            linearity::DISTRUST
        ));
    }
    if below_zero > MASS_BELOW_ZERO {
        said.push(format!(
            "warning: {:.1} % of the mixture's probability lies below e = 0, where there are no orbits, and is left out; \
             components are poor pictures of a cloud that reaches across e = 0",
            100.0 * below_zero
        ));
    }
    if beyond_one > MASS_BEYOND_ONE {
        said.push(format!(
            "warning: {:.1} % of the uncut initial Gaussian lies beyond e = 1, where there are no orbits; a mixture has no edge \
             there, its moments and probabilities are off by a few times as much",
            100.0 * beyond_one
        ));
    }
    if (weights - 1.0).abs() > WEIGHTS {
        said.push(format!(
            "warning: its weights add up to {weights:.4}, those of a mixture to 1; moments and density are those of the weights \
             divided by that"
        ));
    }
    said
}

/// What a cloud that reaches round the circle does to the moments of the solar angle.
fn of_spread(header: &DensityHeader) -> Option<String> {
    (header.resultant < ROUND_THE_CIRCLE).then(|| {
        format!(
            "the cloud reaches round the circle (mean resultant length {:.3}): mean and deviation of phi depend on where its \
             branch is cut, opposite to the circular mean",
            header.resultant
        )
    })
}

/// What an exact density states in spite of a large error estimate, and what it withholds.
fn of_estimates(header: &DensityHeader) -> Vec<String> {
    let [moments, circular, probability, joint] = header.diagnostics;
    let limits = [
        (moments, MOMENT_ERROR, "standard deviations in the moments", &[0, 1, 2, 3, 4][..]),
        (circular, CIRCULAR_ERROR, "in the resultant vector of phi", &[6, 7]),
        (probability, PROBABILITY_ERROR, "in the probability above the critical eccentricity", &[5]),
    ];
    let is_stated = |moments: &[usize]| moments.iter().any(|&k| Quantity::Moment(k).is_stated(header));
    let limits = limits.into_iter().map(|(estimate, limit, of, moments)| (estimate, limit, of, is_stated(moments)));
    let joint = (joint, JOINT_ERROR, "in the joint density in L1", Quantity::Densities.is_stated(header));
    let large: Vec<String> = limits
        .chain([joint])
        .filter(|(estimate, limit, _, is_stated)| *is_stated && !is_within(*estimate, *limit))
        .map(|(estimate, _, of, _)| format!("{estimate:.1e} {of}"))
        .collect();
    let large = (!large.is_empty())
        .then(|| format!("warning: the exact density reached an error estimate of {}", large.join(" and ")));
    let withheld = withheld(header);
    let withheld = (!withheld.is_empty()).then(|| format!("withheld: {}", in_a_row(&withheld)));
    large.into_iter().chain(withheld).collect()
}

/// What a snapshot withholds, each with the error estimate that was reached.
pub(super) fn withheld(header: &DensityHeader) -> Vec<String> {
    let all = Quantity::all().filter(|quantity| !quantity.is_stated(header));
    all.map(|quantity| with_estimate(quantity, header)).collect()
}

/// A quantity that is withheld, and why.
pub(super) fn with_estimate(quantity: Quantity, header: &DensityHeader) -> String {
    match quantity.error_estimate(header) {
        estimate if estimate < NOTHING_KNOWN => format!("{} (error estimate {estimate:.1e})", quantity.in_words()),
        _ => format!("{} (error unknown)", quantity.in_words()),
    }
}

fn of_mass(header: &DensityHeader) -> Option<String> {
    let mass = header.mass_on_grid;
    if mass < LEAST_MASS {
        return Some(format!(
            "warning: only {:.1} % of its probability is on the comparison grid, which holds 99.97 % of the true cloud; {}",
            100.0 * mass,
            off_the_grid(header)
        ));
    }
    // A density that withholds its joint has no mass to judge.
    (mass > MOST_MASS)
        .then(|| format!("warning: its density has a mass of {mass:.4} on the comparison grid; a density has 1"))
}

/// In which direction a cloud is off its grid.
fn off_the_grid(header: &DensityHeader) -> String {
    let [phi_low, phi_high, e_low, e_high] = header.grid;
    let (phi, e) = (header.moments[0], header.moments[2]);
    let phi_on_branch = nearest(phi, 0.5 * (phi_low + phi_high));
    let is_off = |value: f64, low: f64, high: f64| value.is_finite() && !(low..=high).contains(&value);
    if is_off(e, e_low, e_high) {
        return format!("its mean eccentricity {e:.5} is outside the grid, which is {e_low:.5} to {e_high:.5}");
    }
    if is_off(phi_on_branch, phi_low, phi_high) {
        return format!(
            "its mean solar angle {phi:.5} is outside the grid, which is {phi_low:.5} to {phi_high:.5} rad; are its angles in \
             radians?"
        );
    }
    let (of_phi, of_e) = (2.0 * header.moments[1], 2.0 * header.moments[3]);
    let reaches =
        |value: f64, by: f64, low: f64, high: f64| is_off(value - by, low, high) || is_off(value + by, low, high);
    if reaches(e, of_e, e_low, e_high) {
        return format!(
            "two deviations about its mean eccentricity, {:.5} to {:.5}, reach beyond the grid, which is {e_low:.5} to {e_high:.5}",
            e - of_e,
            e + of_e
        );
    }
    if reaches(phi_on_branch, of_phi, phi_low, phi_high) {
        return format!(
            "two deviations about its mean solar angle, {:.5} to {:.5}, reach beyond the grid, which is {phi_low:.5} to {phi_high:.5} rad",
            phi_on_branch - of_phi,
            phi_on_branch + of_phi
        );
    }
    "its moments lie well on the grid: its density is not that of its moments, or too narrow to be told".into()
}

/// Whether a number is known, and not above a limit.
fn is_within(number: f64, limit: f64) -> bool {
    number <= limit
}

/// Why a method has no first-passage curve, or what it withholds of it.
pub(super) fn of_passage(passage: &RecordedPassage) -> Option<String> {
    if passage.values.is_empty() {
        return Some(format!("no first-passage curve: {}", unpack(&passage.header.reason)));
    }
    withheld_passages(&passage.values).map(|withheld| format!("withheld: {withheld}"))
}

/// What a curve withholds: at which times, and between which bounds the probability lies at the last of them.
pub(super) fn withheld_passages(values: &[f64]) -> Option<String> {
    let rows = rows(values);
    let withheld: Vec<&Row> = rows.iter().filter(|row| row.is_withheld()).collect();
    let (first, last) = (withheld.first()?, withheld.last()?);
    let when = match withheld.len() {
        1 => format!("at {} yr", first.time),
        some => format!("at {some} of {} times from {} to {} yr", rows.len(), first.time, last.time),
    };
    let bounds = format!("between {:.5} and {:.5}", last.low, last.high);
    Some(format!("the probability of having reached the critical eccentricity {when} (in the end strictly {bounds})"))
}

/// `a, b and c`.
pub(super) fn in_a_row(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exact(moments: [f64; 6], mass_on_grid: f64, diagnostics: [f64; 4]) -> DensityHeader {
        let diagnostic = diagnostic::NUMERICAL;
        DensityHeader { moments, mass_on_grid, resultant: 0.9, diagnostics, diagnostic, ..DensityHeader::default() }
    }

    #[test]
    fn each_of_the_four_error_estimates_is_looked_at_and_infinity_or_nan_is_never_good_enough() {
        let good = [1e-9, 1e-9, 1e-9, 1e-5];
        assert!(of_density(&exact([0.5; 6], 1.0, good)).is_empty());
        let names = ["in the moments", "resultant vector", "critical eccentricity", "in L1"];
        for (k, name) in names.iter().enumerate() {
            for bad in [0.1, f64::INFINITY, f64::NAN] {
                let mut estimates = good;
                estimates[k] = bad;
                let said = of_density(&exact([0.5; 6], 1.0, estimates));
                assert!(said.len() == 1 && said[0].starts_with("warning: ") && said[0].contains(name), "{said:?}");
            }
        }
        for bad in [0.5, f64::NAN] {
            let mesh = DensityHeader {
                diagnostic: diagnostic::MESH,
                diagnostics: [bad, 0.0, 0.0, f64::NAN],
                mass_on_grid: 1.0,
                resultant: 0.9,
                ..DensityHeader::default()
            };
            assert_eq!(of_density(&mesh).len(), 1);
        }
    }

    #[test]
    fn what_is_withheld_is_named_with_what_was_reached_and_is_no_warning_about_a_number() {
        let said = of_density(&exact([0.5, 0.5, f64::NAN, 0.5, 0.5, 0.5], f64::NAN, [0.2, 0.0, 0.0, f64::INFINITY]));
        assert!(said[0].contains("2.0e-1 standard deviations in the moments"), "{said:?}");
        assert!(!said[0].contains("L1"), "nothing is stated of the joint density: {said:?}");
        assert_eq!(said[1], "withheld: the mean of e (error estimate 2.0e-1) and the joint density (error unknown)");
        assert_eq!(said.len(), 2);
    }

    #[test]
    fn a_cloud_that_is_off_the_grid_and_densities_that_do_not_fit_their_points_draw_a_word() {
        let off = |phi: f64, e: f64| {
            let moments = [phi, 0.1, e, 0.01, 0.0, 0.0];
            let grid = [6.0, 7.0, 0.1, 0.3];
            of_density(&DensityHeader { mass_on_grid: 0.4, moments, grid, ..DensityHeader::default() })[0].clone()
        };
        assert!(off(372.4, 0.2).contains("only 40.0 % of its probability is on the comparison grid"));
        assert!(off(372.4, 0.2).contains("are its angles in radians?"), "{}", off(372.4, 0.2));
        assert!(
            off(0.2, 0.5).contains("its mean eccentricity 0.50000 is outside the grid, which is 0.10000 to 0.30000")
        );
        assert!(off(0.2, 0.2).contains("lie well on the grid"), "the same angle on another branch: {}", off(0.2, 0.2));
        assert!(off(0.2, 0.29).contains("mean eccentricity, 0.27000 to 0.31000, reach beyond"), "{}", off(0.2, 0.29));
        assert!(off(6.9, 0.2).contains("mean solar angle, 6.70000 to 7.10000, reach beyond"), "{}", off(6.9, 0.2));
        let header = DensityHeader { mass_on_grid: 1.05, ..DensityHeader::default() };
        assert!(of_density(&header)[0].contains("a mass of 1.0500"));
        let header = DensityHeader {
            diagnostic: diagnostic::MESH,
            diagnostics: [0.0; 4],
            carried_density_error: 0.5,
            mass_on_grid: 1.0,
            ..DensityHeader::default()
        };
        assert!(of_density(&header)[0].contains("off by 50.00 % on average"));
    }

    #[test]
    fn errors_come_before_warnings_and_warnings_before_remarks() {
        let notes = ["no curve", "warning: coarse", "lost: too slow", "error: wrong", "fallback: mc"];
        let mut sorted = notes;
        sorted.sort_by_key(|note| severity(note));
        assert_eq!(sorted, ["fallback: mc", "lost: too slow", "error: wrong", "warning: coarse", "no curve"]);
    }
}

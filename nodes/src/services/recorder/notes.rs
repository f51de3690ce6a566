//! What a user should know about a result, in words.

use density::angle::nearest;
use density::grid::Axis;
use density::mesh::MeshDiagnostics;
use density::mixture::linearity;
use density::trust::Diagnosis;
use messages::scenario::Variable;
use messages::text::unpack;
use results::notes::listed;

use super::RecordedPassage;
use crate::services::passage_rules::{Row, rows};
use crate::services::reading::Reading;
use crate::services::yardstick::Figure;
use kit::diagnosis;
use kit::space::Quantity;

/// Error estimate of the moments of an exact density, in standard deviations, above which there is a note: a hundredth
/// of the 1 % to which verdicts judge the other methods by it.
const MOMENT_ERROR: f64 = 1e-4;
/// The same for the resultant vector.
const CIRCULAR_ERROR: f64 = 1e-4;
/// The same for the probability above the critical eccentricity, where that is not small.
const PROBABILITY_ERROR: f64 = 1e-4;
/// A small probability has a note if its error estimate is above this share of it, unless the estimate is at most
/// [`LEAST_ERROR`].
const RELATIVE_ERROR: f64 = 0.01;
/// Error estimate of a probability that never causes a note.
const LEAST_ERROR: f64 = 1e-6;
/// The same for the L1 error of its joint density.
const JOINT_ERROR: f64 = 1e-3;
/// Mean relative error of the densities that characteristics carry along, above which there is a note.
const CARRIED_DENSITY_ERROR: f64 = 1e-3;
/// Probability on the comparison grid below which there is a note. The grid holds the image of the 4-sigma ellipse,
/// 0.9997 of the probability.
const LEAST_MASS: f64 = 0.95;
/// Probability on the comparison grid above which there is a note.
const MOST_MASS: f64 = 1.001;

/// Probability of a mixture below `e = 0` above which there is a note.
const MASS_BELOW_ZERO: f64 = 0.005;
/// Probability of the initial Gaussian beyond `e = 1` above which there is a note on a mixture.
const MASS_BEYOND_ONE: f64 = 5e-4;
/// Error estimate, in standard deviations or of a probability, from which on an error counts as unknown.
const NOTHING_KNOWN: f64 = 100.0;
/// Difference from 1 of the sum of a mixture's weights above which there is a note.
const WEIGHTS: f64 = 1e-3;
/// Mean resultant length below which a note says that the cloud reaches round the circle.
const ROUND_THE_CIRCLE: f64 = 0.3;

/// The remarks and warnings that follow from a density's diagnostics and its mass.
pub(super) fn of_density(reading: &Reading) -> Vec<String> {
    let header = &reading.header;
    let said = match diagnosis::of(header) {
        Diagnosis::Mesh { measure_defect, misplaced_mass, .. } => {
            of_mesh(measure_defect, misplaced_mass, header.carried_density_error)
        }
        Diagnosis::Mixture { disagreement, below_zero, weights, beyond_one } => {
            of_mixture([disagreement, below_zero, weights, beyond_one])
        }
        Diagnosis::Stated { moments, resultant, probability, joint } => {
            of_estimates(reading, [moments, resultant, probability, joint])
        }
        Diagnosis::None => Vec::new(),
    };
    said.into_iter().chain(of_mass(reading)).chain(of_spread(reading)).collect()
}

fn of_mesh(defect: f64, misplaced: f64, carried_error: f64) -> Vec<String> {
    let limit = MeshDiagnostics::LARGEST_DEFECT;
    let mut said = Vec::new();
    if !is_within(defect, limit) {
        said.push(format!(
            "warning: the mesh is too coarse for the flow here (measure defect {defect:.2}, above {limit}); take more points"
        ));
    }
    if misplaced > 2.0 * limit {
        said.push(format!(
            "warning: the bins are too fine for the mesh here: about {:.1} % of the joint density is in wrong bins; take \
             more points or fewer bins",
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

fn of_mixture([disagreement, below_zero, weights, beyond_one]: [f64; 4]) -> Vec<String> {
    let mut said = Vec::new();
    if disagreement.is_nan() {
        said.push("how far the flow over its components is from linear is not known".into());
    } else if !is_within(disagreement, linearity::DISTRUST) {
        said.push(format!(
            "warning: components are too wide for the flow here (disagreement {disagreement:.2}, above {}); \
             do not trust the density, and the moments only as far as another method confirms them; split more finely",
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

/// A remark for every angle round whose circle the cloud reaches.
fn of_spread(reading: &Reading) -> Vec<String> {
    let space = &reading.space;
    let round = |k: usize| (k, reading.value(Quantity::ResultantLength(k)));
    let circles = (0..space.variables.len()).filter(|&k| space.is_circle(k)).map(round);
    let said = circles.filter(|(_, length)| *length < ROUND_THE_CIRCLE).map(|(k, length)| {
        format!(
            "the cloud reaches round the circle (mean resultant length {length:.3}): mean and deviation of {} depend on where its \
             branch is cut, opposite to the circular mean",
            space.symbol(k)
        )
    });
    said.collect()
}

/// A warning about figures that an exact density states in spite of a large error estimate, and a remark on those
/// that it withholds.
fn of_estimates(reading: &Reading, [moments, circular, probability, joint]: [f64; 4]) -> Vec<String> {
    let space = &reading.space;
    let is_circular = |q: &Quantity| matches!(q, Quantity::CircularMean(_) | Quantity::ResultantLength(_));
    let is_moment = |q: &Quantity| matches!(q, Quantity::Mean(_) | Quantity::Deviation(_) | Quantity::Covariance(..));
    let is_stated = |is_meant: &dyn Fn(&Quantity) -> bool| {
        space.quantities().into_iter().filter(|q| is_meant(q)).any(|q| Figure::Quantity(q).is_stated(reading))
    };
    let angles: Vec<&str> =
        (0..space.variables.len()).filter(|&k| space.is_circle(k)).map(|k| space.symbol(k)).collect();
    let limits = [
        (moments, MOMENT_ERROR, "standard deviations in the moments".to_owned(), is_stated(&is_moment)),
        (
            circular,
            CIRCULAR_ERROR,
            format!("in the resultant vector of {}", angles.join(", ")),
            is_stated(&is_circular),
        ),
        (
            probability,
            largest_error(reading.value(Quantity::AboveCritical)),
            format!("in {}", space.in_words(Quantity::AboveCritical)),
            is_stated(&|q: &Quantity| *q == Quantity::AboveCritical),
        ),
        (joint, JOINT_ERROR, "in the joint density in L1".to_owned(), Figure::Densities.is_stated(reading)),
    ];
    let large: Vec<String> = limits
        .into_iter()
        .filter(|(estimate, limit, _, is_stated)| *is_stated && !is_within(*estimate, *limit))
        .map(|(estimate, _, of, _)| format!("{estimate:.1e} {of}"))
        .collect();
    let large = (!large.is_empty())
        .then(|| format!("warning: the exact density reached an error estimate of {}", large.join(" and ")));
    let withheld = withheld(reading);
    let withheld = (!withheld.is_empty()).then(|| format!("withheld: {}", listed(&withheld)));
    large.into_iter().chain(withheld).collect()
}

/// The largest error estimate of a probability that causes no note.
fn largest_error(probability: f64) -> f64 {
    (RELATIVE_ERROR * probability).clamp(LEAST_ERROR, PROBABILITY_ERROR)
}

/// The figures that a snapshot withholds, each with the error estimate that was reached.
pub(super) fn withheld(reading: &Reading) -> Vec<String> {
    let all = Figure::all(&reading.space).filter(|figure| !figure.is_stated(reading));
    all.map(|figure| with_estimate(figure, reading)).collect()
}

/// A figure that is withheld, in words, with its error estimate.
pub(super) fn with_estimate(figure: Figure, reading: &Reading) -> String {
    let words = figure.in_words(&reading.space);
    match figure.error_estimate(reading) {
        estimate if estimate < NOTHING_KNOWN => format!("{words} (error estimate {estimate:.1e})"),
        _ => format!("{words} (error unknown)"),
    }
}

fn of_mass(reading: &Reading) -> Option<String> {
    let mass = reading.header.mass_on_grid;
    if mass < LEAST_MASS {
        return Some(format!(
            "warning: only {:.1} % of its probability is on the comparison grid, which holds 99.97 % of the true cloud; {}",
            100.0 * mass,
            off_the_grid(reading)
        ));
    }
    // A snapshot that withholds its joint density has no mass to judge.
    (mass > MOST_MASS)
        .then(|| format!("warning: its density has a mass of {mass:.4} on the comparison grid; a density has 1"))
}

/// In which direction a cloud is off its grid: numbers are examined before angles.
fn off_the_grid(reading: &Reading) -> String {
    let count = reading.space.variables.len();
    let is_circle = |k: &usize| reading.space.is_circle(*k);
    let order: Vec<usize> = (0..count).filter(|k| !is_circle(k)).chain((0..count).filter(is_circle)).collect();
    let outside = order.iter().find_map(|&k| Spread::of(reading, k)?.outside());
    outside.or_else(|| order.iter().find_map(|&k| Spread::of(reading, k)?.reaching_beyond())).unwrap_or(
        "its moments lie well on the grid: its density is not that of its moments, or too narrow to be told".into(),
    )
}

/// Where a cloud lies along an axis of the grid.
struct Spread<'a> {
    variable: &'a Variable,
    axis: Axis,
    /// The mean on the branch of the axis, and as it was published.
    mean: (f64, f64),
    deviation: f64,
    is_circle: bool,
}

impl<'a> Spread<'a> {
    /// `None` for a variable in which no density is compared.
    fn of(reading: &'a Reading, k: usize) -> Option<Self> {
        let (axis, is_circle, said) = (reading.axes[k], reading.space.is_circle(k), reading.value(Quantity::Mean(k)));
        let mean = if is_circle { nearest(said, 0.5 * (axis.low + axis.high)) } else { said };
        let (variable, deviation) = (&reading.space.variables[k], reading.value(Quantity::Deviation(k)));
        (axis.bins > 0).then_some(Self { variable, axis, mean: (mean, said), deviation, is_circle })
    }

    fn is_off(&self, value: f64) -> bool {
        value.is_finite() && !(self.axis.low..=self.axis.high).contains(&value)
    }

    fn axis_in_words(&self) -> String {
        let unit = if self.variable.unit.is_empty() { String::new() } else { format!(" {}", self.variable.unit) };
        format!("{:.5} to {:.5}{unit}", self.axis.low, self.axis.high)
    }

    fn outside(&self) -> Option<String> {
        let hint = if self.is_circle { "; are its angles in radians?" } else { "" };
        self.is_off(self.mean.0).then(|| {
            let name = &self.variable.name;
            format!("its mean {name} {:.5} is outside the grid, which is {}{hint}", self.mean.1, self.axis_in_words())
        })
    }

    fn reaching_beyond(&self) -> Option<String> {
        let (low, high) = (self.mean.0 - 2.0 * self.deviation, self.mean.0 + 2.0 * self.deviation);
        (self.is_off(low) || self.is_off(high)).then(|| {
            format!(
                "two deviations about its mean {}, {low:.5} to {high:.5}, reach beyond the grid, which is {}",
                self.variable.name,
                self.axis_in_words()
            )
        })
    }
}

/// Whether a number is known, and not above a limit.
fn is_within(number: f64, limit: f64) -> bool {
    number <= limit
}

/// Why a method has no first-passage curve, or what part of the curve it withholds.
pub(super) fn of_passage(passage: &RecordedPassage) -> Option<String> {
    if passage.values.is_empty() {
        return Some(format!("no first-passage curve: {}", unpack(&passage.header.reason)));
    }
    withheld_passages(&passage.values).map(|withheld| format!("withheld: {withheld}"))
}

/// The part of a curve that is withheld: at which times, and between which bounds the probability lies at the last of
/// them.
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

#[cfg(test)]
mod tests;

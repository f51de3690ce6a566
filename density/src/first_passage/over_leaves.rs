//! First-passage curves where the radiation parameter is uncertain, with what re-entry says about the parameter.

use crate::exact::leaves::ExactLeaves;
use crate::exact::over_leaves::{Leaf, Panel, integrate};
use crate::exact::{Error, Estimated, is_possible};

use super::exact::of_family;

/// What is known at a time of a cloud with an uncertain radiation parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passed {
    /// The probability of having passed.
    pub probability: Estimated,
    /// Mean and standard deviation of the radiation parameter, given that the satellite has passed; NaN if that is as good as impossible.
    pub radiation_if_passed: (f64, f64),
    /// The same, given that it has not.
    pub radiation_if_not: (f64, f64),
}

/// Target for the absolute error of probabilities where the radiation parameter is uncertain.
const LEAVES_ERROR: f64 = 1e-5;
/// Largest number of values of the radiation parameter for a curve.
const MOST_LEAVES: usize = 3_000;
/// Probability below which nothing is said of the parameter given that event.
const RAREST: f64 = 1e-4;

/// The curve for an uncertain radiation parameter: the mean of the curves of all its values.
///
/// # Errors
/// As [`super::exact::exact_curve`], for the mean of the parameter.
pub fn curve(exact: &ExactLeaves, times: &[f64]) -> Result<Vec<Passed>, Error> {
    let problem = exact.problem();
    is_possible(&problem.plane.model)?;
    let count = times.len();
    // The probabilities, then their products with the parameter and its square; last the parameter and its square.
    let leaf = |plane: &_, z: f64, _: f64| {
        let radiation = problem.radiation(z);
        let read = |family: &_| {
            let found = of_family(plane, family, times, (0.1 * LEAVES_ERROR, exact.most_orbits()));
            let powers = [1.0, radiation, radiation * radiation];
            let values = powers.iter().flat_map(|power| found.iter().map(move |p| power * p.value)).chain(powers);
            Leaf { values: values.collect(), errors: found.iter().map(|p| p.error).collect() }
        };
        exact.on_leaf(plane, z, read)
    };
    let share = |panel: &Panel, _: &[f64]| panel.errors().take(count).fold(0.0, f64::max) / LEAVES_ERROR;
    let found = integrate(problem, leaf, share, MOST_LEAVES)?;
    let (values, inner) = (found.values(), found.inner());
    let by_rule = |k: usize| found.panels.iter().filter_map(|panel| panel.errors().nth(k)).sum::<f64>();
    let [_, mean, square] = [0, 1, 2].map(|power| values[3 * count + power]);
    let moments = |mass: f64, first: f64, second: f64| match mass > RAREST {
        true => (first / mass, (second / mass - (first / mass).powi(2)).max(0.0).sqrt()),
        false => (f64::NAN, f64::NAN),
    };
    let at = |k: usize| {
        let [p, first, second] = [0, 1, 2].map(|power| values[power * count + k]);
        let probability = Estimated { value: p.clamp(0.0, 1.0), error: by_rule(k) + inner[k] + found.lost() };
        let radiation_if_not = moments(1.0 - found.lost() - p, mean - first, square - second);
        Passed { probability, radiation_if_passed: moments(p, first, second), radiation_if_not }
    };
    let mut passed: Vec<Passed> = (0..count).map(at).collect();
    // Each leaf's curve does not fall; the sums may by rounding.
    for k in 1..count {
        passed[k].probability.value = passed[k].probability.value.max(passed[k - 1].probability.value);
    }
    Ok(passed)
}

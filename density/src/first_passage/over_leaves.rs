//! First-passage curves where the radiation parameter is uncertain, with what re-entry says about the parameter.

use crate::exact::leaves::ExactLeaves;
use crate::exact::over_leaves::{Leaf, Panel, eased, integrate};
use crate::exact::{Error, Estimated, ProbabilityTolerance, is_possible};
use crate::flow::{Accuracy, Flow};
use crate::mesh::passage::{PassageCurve, PassageError, layer_curve};
use crate::mesh::points::{lattice_points, lattice_reach};
use crate::model::registry::Planar;
use crate::problem::Problem;
use crate::uncertain::UncertainProblem;

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

/// Target for the absolute error of probabilities where the radiation parameter is uncertain, and the largest number of its values.
const EXACT: Effort = Effort { error: 1e-5, most_leaves: 3_000 };
/// The same where a curve follows from the flow that a lattice interpolates.
const ON_LATTICES: Effort = Effort { error: 1e-4, most_leaves: 400 };
/// Probability below which nothing is said of the parameter given that event.
const RAREST: f64 = 1e-4;

/// How accurate a curve is to be.
#[derive(Debug, Clone, Copy)]
struct Effort {
    error: f64,
    most_leaves: usize,
}

/// The curve for an uncertain radiation parameter: the mean of the curves of all its values.
///
/// # Errors
/// As [`super::exact::exact_curve`], for the mean of the parameter.
pub fn curve(exact: &ExactLeaves, times: &[f64]) -> Result<Vec<Passed>, Error> {
    let problem = exact.problem();
    is_possible(&problem.plane.model)?;
    let of_leaf = |plane: &Problem<Planar>, z: f64, density: f64| {
        let tolerance = ProbabilityTolerance::Absolute(eased(0.1 * EXACT.error, density));
        exact.on_leaf(plane, z, |family| of_family(plane, family, times, (tolerance, exact.most_orbits())))
    };
    mean_curve(problem, times, EXACT, of_leaf)
}

/// The same from the flow that lattices of `side` points per side interpolate to `degree`, each with a radiation parameter of its own.
///
/// # Errors
/// [`PassageError`].
pub fn curve_on_lattices(
    problem: &UncertainProblem,
    accuracy: Accuracy,
    (side, degree): (usize, usize),
    times: &[f64],
) -> Result<Vec<Passed>, PassageError> {
    let points = lattice_points(&problem.plane, side, lattice_reach(side))?;
    let of_leaf = |plane: &Problem<Planar>, _: f64, _: f64| {
        let PassageCurve { probability, error } =
            layer_curve(plane, &Flow { model: plane.model, accuracy }, &points, degree, times)?;
        let both = probability.into_iter().zip(error);
        Ok(Some(both.map(|(value, error)| Estimated { value, error }).collect()))
    };
    mean_curve(problem, times, ON_LATTICES, of_leaf)
}

/// The mean of the curves that `of_leaf` finds for values of the radiation parameter, with what they say of it. `of_leaf` is given the plane, `z`, and the
/// density of `z`.
fn mean_curve<E: Send>(
    problem: &UncertainProblem,
    times: &[f64],
    effort: Effort,
    of_leaf: impl Fn(&Problem<Planar>, f64, f64) -> Result<Option<Vec<Estimated>>, E> + Sync,
) -> Result<Vec<Passed>, E> {
    let count = times.len();
    // The probabilities, then their products with the parameter and its square; last the parameter and its square.
    let leaf = |plane: &Problem<Planar>, z: f64, density: f64| {
        let radiation = problem.radiation(z);
        let powers = [1.0, radiation, radiation * radiation];
        let all = |found: Vec<Estimated>| {
            let values = powers.iter().flat_map(|power| found.iter().map(move |p| power * p.value)).chain(powers);
            Leaf { values: values.collect(), errors: found.iter().map(|p| p.error).collect() }
        };
        of_leaf(plane, z, density).map(|found| found.map(all))
    };
    let share = |panel: &Panel, _: &[f64]| panel.errors().take(count).fold(0.0, f64::max) / effort.error;
    let found = integrate(problem, leaf, share, effort.most_leaves)?;
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

//! First-passage curves where the radiation parameter is uncertain, with what re-entry says about the parameter.

use crate::exact::leaves::ExactLeaves;
use crate::exact::over_leaves::{LeafPanel, LeafValues, REACH, eased, integrate};
use crate::exact::{Error, Estimated, ProbabilityTolerance, is_possible};
use crate::flow::{Accuracy, Flow};
use crate::mesh::passage::{PassageCurve, PassageError, layer_curve};
use crate::mesh::points::{lattice_points, lattice_reach};
use crate::model::registry::Planar;
use crate::problem::Problem;
use crate::uncertain::UncertainProblem;

use super::exact::of_family;
use super::given::Given;

/// What is known at a time of a cloud with an uncertain radiation parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passed {
    /// The probability of having passed.
    pub probability: Estimated,
    /// The radiation parameter given that the satellite has passed; NaN if that is as good as impossible.
    pub radiation_if_passed: Given,
    /// The same, given that it has not.
    pub radiation_if_not: Given,
}

/// Target for the absolute error of probabilities where the radiation parameter is uncertain, and the largest number of
/// its values.
const EXACT: Effort = Effort { error: 1e-5, most_leaves: 3_000 };
/// The same where a curve follows from the flow that a lattice interpolates.
const ON_LATTICES: Effort = Effort { error: 1e-4, most_leaves: 400 };
/// Probability below which nothing is said of the parameter given that event.
const RAREST: f64 = 1e-4;

/// Factor by which the products of the probabilities with the parameter, in deviations from its mean, may be less
/// accurate.
const FOR_PRODUCTS: f64 = 10.0;

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
        let tolerance = ProbabilityTolerance::Absolute(eased(EXACT.error, density));
        exact.on_leaf(plane, z, |family| of_family(plane, family, times, (tolerance, exact.most_orbits())))
    };
    mean_curve(problem, times, EXACT, of_leaf)
}

/// The same from the flow that lattices of `side` points per side interpolate to `degree`, each with a radiation
/// parameter of its own.
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

/// The mean of the curves that `of_leaf` finds for values of the radiation parameter, with what they say of it.
/// `of_leaf` is given the plane, `z`, and the density of `z`.
fn mean_curve<E: Send>(
    problem: &UncertainProblem,
    times: &[f64],
    effort: Effort,
    of_leaf: impl Fn(&Problem<Planar>, f64, f64) -> Result<Option<Vec<Estimated>>, E> + Sync,
) -> Result<Vec<Passed>, E> {
    let count = times.len();
    // The parameter in deviations from its mean.
    let (centre, scale) = (problem.mean(), problem.spread.relative * problem.mean());
    // The probabilities, then their products with the parameter and its square; last the powers alone.
    let leaf = |plane: &Problem<Planar>, z: f64, density: f64| {
        let d = (problem.radiation(z) - centre) / scale;
        let powers = [1.0, d, d * d];
        let all = |found: Vec<Estimated>| {
            let values = powers.iter().flat_map(|power| found.iter().map(move |p| power * p.value)).chain(powers);
            let errors = powers.iter().flat_map(|power| found.iter().map(move |p| power.abs() * p.error));
            LeafValues { values: values.collect(), errors: errors.collect() }
        };
        of_leaf(plane, z, density).map(|found| found.map(all))
    };
    // A difference of two rules may be small by chance; those of all three kinds of integrals together are not.
    let tolerated = |k: usize| if k < count { effort.error } else { FOR_PRODUCTS * effort.error };
    let share = |panel: &LeafPanel, _: &[f64]| {
        panel.errors().enumerate().map(|(k, error)| error / tolerated(k)).fold(0.0, f64::max)
    };
    let found = integrate(problem, 3 * count + 3, leaf, share, effort.most_leaves)?;
    let (values, inner, lost) = (found.values(), found.inner(), found.lost());
    let by_rule = |k: usize| found.panels.iter().filter_map(|panel| panel.errors().nth(k)).sum::<f64>();
    let of_rules: Vec<f64> = (0..values.len()).map(by_rule).collect();
    let at = |k: usize| {
        // The parameter of a leaf of which nothing is known lies at most so many deviations off.
        let passed = [0, 1, 2].map(|power| {
            let index = power * count + k;
            Estimated { value: values[index], error: of_rules[index] + inner[index] + lost * REACH.powi(power as i32) }
        });
        let still = [0, 1, 2].map(|power| {
            let all = 3 * count + power;
            Estimated { value: values[all] - passed[power].value, error: passed[power].error + of_rules[all] }
        });
        let given = |sums: [Estimated; 3]| match sums[0].value > RAREST {
            true => Given::of_integrals(sums, (centre, scale)),
            false => Given::UNKNOWN,
        };
        let probability = Estimated { value: passed[0].value.clamp(0.0, 1.0), ..passed[0] };
        Passed { probability, radiation_if_passed: given(passed), radiation_if_not: given(still) }
    };
    let mut passed: Vec<Passed> = (0..count).map(at).collect();
    // Each leaf's curve does not fall; the sums may by rounding.
    for k in 1..count {
        passed[k].probability.value = passed[k].probability.value.max(passed[k - 1].probability.value);
    }
    Ok(passed)
}

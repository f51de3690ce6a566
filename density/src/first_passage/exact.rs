//! The first-passage curve without sampling.
//!
//! Every orbit of the plane is closed, and its eccentricity grows during one half of the period and falls during the
//! other ([`crate::exact`]). So an orbit whose largest eccentricity is below the critical one never passes, and an
//! orbit whose least eccentricity is above it has passed at the start. Any other orbit is above during one arc of its
//! period. Of the initial probability along such an orbit, two parts have passed by `t`: the part on the arc above, and
//! the part that lies up to `t` before the beginning of that arc:
//!
//! ```text
//! P(T <= t) = ∫ dq h'(q) [A(arc above) + A(θ_c - min(n_sun t, R), θ_c)] ,     R = length of the arc below.
//! ```
//!
//! `A` is the initial probability of an arc. All terms are positive, so the curve cannot fall or leave `[0, 1]`.

use crate::exact::detail::Detail;
use crate::exact::family::{Family, Orbit};
use crate::exact::measure::Measure;
use crate::exact::moments::{Noise, touching};
use crate::exact::{Error, Estimated, PROBABILITY_ERROR, ProbabilityTolerance, is_possible};
use crate::flow::{Accuracy, Flow};
use crate::model::PlanarHamiltonian;
use crate::problem::Problem;

/// Largest number of orbits for a curve.
pub const MOST_ORBITS: usize = 30_000;

/// `P(T <= t)` at each of the ascending `times` \[yr\], with error estimates.
///
/// # Errors
/// [`Error`] if the model's orbits do not fit the method.
pub fn exact_curve<M: PlanarHamiltonian>(
    problem: &Problem<M>,
    flow: &Flow<M>,
    times: &[f64],
) -> Result<Vec<Estimated>, Error> {
    curve(problem, flow, times, MOST_ORBITS)
}

/// Like [`exact_curve`], with at most `most_orbits`.
///
/// # Errors
/// As [`exact_curve`].
pub fn curve<M: PlanarHamiltonian>(
    problem: &Problem<M>,
    flow: &Flow<M>,
    times: &[f64],
    most_orbits: usize,
) -> Result<Vec<Estimated>, Error> {
    curve_within(problem, flow, times, (PROBABILITY_ERROR, most_orbits))
}

/// Like [`curve`], to about `tolerance`.
///
/// # Errors
/// As [`exact_curve`].
pub fn curve_within<M: PlanarHamiltonian>(
    problem: &Problem<M>,
    flow: &Flow<M>,
    times: &[f64],
    (tolerance, most_orbits): (f64, usize),
) -> Result<Vec<Estimated>, Error> {
    is_possible(&flow.model)?;
    let family = Family::new(flow, Measure::new(problem.initial), problem.critical_e, Detail::FINE);
    Ok(of_family(problem, &family, times, (ProbabilityTolerance::RareToo(tolerance), most_orbits)))
}

/// The curve of one of many problems that are compared or averaged, to about `tolerance`, which is 1e-6 or more.
///
/// # Errors
/// As [`exact_curve`].
pub fn rough_curve<M: PlanarHamiltonian>(
    problem: &Problem<M>,
    times: &[f64],
    tolerance: f64,
) -> Result<Vec<Estimated>, Error> {
    is_possible(&problem.model)?;
    let flow = Flow { model: problem.model, accuracy: Accuracy::Medium };
    let family = Family::new(&flow, Measure::new(problem.initial), problem.critical_e, Detail::COARSE);
    Ok(of_family(problem, &family, times, (ProbabilityTolerance::Absolute(tolerance), MOST_ORBITS)))
}

/// The curve of a model whose orbits fit the method.
pub(crate) fn of_family<M: PlanarHamiltonian>(
    problem: &Problem<M>,
    family: &Family<M>,
    times: &[f64],
    (tolerance, most_orbits): (ProbabilityTolerance, usize),
) -> Vec<Estimated> {
    let passed = |orbit: &Orbit| passed(orbit, problem.critical_e, times);
    let noise = Noise::of_probabilities(times.last().copied().unwrap_or(0.0), family);
    let of_value = |&value: &f64| tolerance.of(value).max(0.3 * noise * value);
    let tolerances = |values: &[f64], _: &[f64]| values.iter().map(of_value).collect();
    let found = family.integrate(family.first_intervals(), times.len() + 1, passed, tolerances, most_orbits);
    let missing: f64 = (1.0 - found.values[times.len()]).abs();
    let at_start = Estimated { value: problem.initial.probability_above(problem.critical_e), error: f64::EPSILON };
    // The probability at the start is known best, and the curve never falls below it.
    let least = if times.first() == Some(&0.0) { at_start.value } else { 0.0 };
    let estimated = |k: usize| Estimated {
        value: found.values[k].clamp(least, 1.0),
        error: found.errors[k]
            + touching(found.values[k])
            + if missing > 1e-12 { missing } else { missing * found.values[k] },
    };
    (0..times.len()).map(|k| if times[k] == 0.0 { at_start } else { estimated(k) }).collect()
}

/// The part of an orbit's probability that has passed by each time, then the total; per unit of `H`.
fn passed(orbit: &Orbit, critical_e: f64, times: &[f64]) -> Vec<f64> {
    let (contour, share) = (&orbit.contour, &orbit.share);
    let total = share.total();
    let Some(rise) = contour.rises_above(critical_e) else {
        return std::iter::repeat_n(0.0, times.len()).chain([total]).collect();
    };
    let between = |from: f64, to: f64| share.between(contour, from, to);
    let above = between(rise, contour.period() - rise);
    // The sum goes from time to time, so that each part is integrated once.
    let (mut sum, mut reached) = (above, 0.0);
    let at = |&time: &f64| {
        let now = crate::exact::angle_of(time).min(2.0 * rise);
        sum += between(rise - now, rise - reached);
        reached = now;
        sum
    };
    let mut values: Vec<f64> = times.iter().map(at).collect();
    values.push(total);
    values
}

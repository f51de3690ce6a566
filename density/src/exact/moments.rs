//! Moments and the probability above the critical eccentricity, without sampling noise.
//!
//! They are integrals over the orbits of the cloud ([`super::family`]) of integrals along each orbit.
//!
//! Along an orbit the integrand is the initial probability at `θ` times a function of the state at `θ + n_sun t`. It is
//! smooth except at certain times: the ends of the intervals that resolve the initial probability ([`super::share`]),
//! the ends of the integrator's steps that resolve the state, the passages of the branch cut of the solar angle
//! opposite the circular mean, and times near the passage of `e = 0`, where the solar angle turns quickly. All of these
//! are ends of intervals here, so that the eight-point Gauss rule is accurate to rounding.

use std::f64::consts::PI;

use crate::angle::{Circular, fold, nearest};
use crate::flow::Accuracy;
use crate::model::PlanarHamiltonian;

use super::ProbabilityTolerance;
use super::adaptive::Interval;
use super::contour::angle_of;
use super::family::{Family, Integrals, Orbit};
use super::rules::gauss;
use super::share::density;

/// First and second moments of a cloud and its circular mean, with error estimates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SmoothMoments {
    /// Mean solar angle on the branch of the circular mean \[rad\].
    pub mean_phi: f64,
    /// Standard deviation of the solar angle on that branch \[rad\].
    pub std_phi: f64,
    /// Mean eccentricity.
    pub mean_e: f64,
    /// Standard deviation of the eccentricity.
    pub std_e: f64,
    /// Covariance \[rad\].
    pub cov_phi_e: f64,
    /// Circular mean and resultant length.
    pub circular: Circular,
    /// Largest error estimate of the five moments, in units of the standard deviations (or products of them).
    pub error: f64,
    /// Error estimate of the mean eccentricity and its standard deviation, in units of the standard deviation.
    pub e_error: f64,
    /// Error estimate of the mean of `(cos phi, sin phi)`.
    pub circular_error: f64,
    /// Difference of the probability of all orbits from 1, plus its error estimate.
    pub mass_error: f64,
    /// Number of orbits taken.
    pub orbits: usize,
}

/// The point about which the moments are taken.
#[derive(Debug, Clone, Copy)]
pub(super) struct Centre {
    pub phi: f64,
    pub e: f64,
}

impl Centre {
    /// From the values of the first pass.
    pub(super) fn of(values: &[f64]) -> Self {
        let circular = Circular::from_mean_vector(values[2] / values[0], values[1] / values[0]);
        Self { phi: circular.mean, e: values[3] / values[0] }
    }
}

/// Absolute accuracy of states, apart from the integrator's error.
const ROUNDING: f64 = 1e-14;
/// Accuracy of a probability, as a share of its variance, where orbits of the cloud just touch the critical
/// eccentricity. Such an orbit is above for a time that grows as the square root of its distance in `H` from the
/// touching orbit, which is known to rounding only. The factor is measured: a cloud whose mean orbit just touches, with
/// deviations of 1e-4 rad and 1e-3, had an error of 5e-8 at a probability of one half, and twice that is reported.
const TOUCHING: f64 = 4e-7;
/// Functions integrated for the centre: 1, cos, sin, e, e².
pub(super) const FIRST: usize = 5;
/// Functions integrated about the centre: 1, cos, sin, δe, δe², δphi, δphi², δphi δe, density of `phi` at its branch
/// cut.
pub(super) const SECOND: usize = 9;

/// The moments after `years`, refined until the error estimate is below `tolerance` or `most_orbits` have been taken.
pub(super) fn smooth_moments(
    family: &Family<impl PlanarHamiltonian>,
    years: f64,
    tolerance: f64,
    most_orbits: usize,
) -> SmoothMoments {
    let noise = Noise::after(years, family);
    let coarse = first_pass(family, years, tolerance, most_orbits / 2);
    let centre = Centre::of(&coarse.values);
    let left = most_orbits.saturating_sub(coarse.orbits);
    let fine = second_pass(family, years, centre, coarse.intervals.clone(), (tolerance, left));
    finish(&coarse, &fine, centre, noise)
}

/// The integrals from which the centre follows.
pub(super) fn first_pass(
    family: &Family<impl PlanarHamiltonian>,
    years: f64,
    tolerance: f64,
    most_orbits: usize,
) -> Integrals {
    let (t, noise) = (angle_of(years), Noise::after(years, family));
    let first = |orbit: &Orbit| {
        along(family, orbit, t, None, |phi, e| {
            let (sin, cos) = phi.sin_cos();
            [1.0, cos, sin, e, e * e]
        })
    };
    let scale = |values: &[f64], _: &[f64]| {
        let std_e = (values[4] / values[0] - (values[3] / values[0]).powi(2)).max(1e-30).sqrt();
        // Angles are computed to the same share of their spread, which follows from 1 - R².
        let spread = (1.0 - (values[1].powi(2) + values[2].powi(2)) / values[0].powi(2)).max(1e-12).sqrt();
        let tolerance = tolerance.max(noise.over(std_e, spread, values[3] / values[0]));
        [1.0, spread, spread, std_e, std_e].map(|scale| 0.3 * tolerance * scale).to_vec()
    };
    family.integrate(family.first_intervals(), FIRST, first, scale, most_orbits)
}

/// The integrals about a centre.
pub(super) fn second_pass(
    family: &Family<impl PlanarHamiltonian>,
    years: f64,
    centre: Centre,
    from: Vec<Interval>,
    (tolerance, most_orbits): (f64, usize),
) -> Integrals {
    let (t, noise) = (angle_of(years), Noise::after(years, family));
    let second = |orbit: &Orbit| about(family, orbit, t, centre);
    let scale = |values: &[f64], _: &[f64]| {
        let (std_e, std_phi) = deviations(values);
        let tolerance = tolerance.max(noise.over(std_e, std_phi, centre.e));
        scales(values).map(|scale| 0.3 * tolerance * scale).to_vec()
    };
    family.integrate(from, SECOND, second, scale, most_orbits)
}

/// Absolute accuracy of states, which no number of orbits improves.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Noise(f64);

impl Noise {
    /// The error of an orbit grows about linearly with time; `Accuracy` states it after two years.
    pub(super) fn after(years: f64, family: &Family<impl PlanarHamiltonian>) -> Self {
        Self::of(years, family.flow.accuracy)
    }

    /// The same for orbits of this accuracy.
    pub(super) fn of(years: f64, accuracy: Accuracy) -> Self {
        Self(ROUNDING + 0.5 * years * accuracy.largest_error())
    }

    /// The noise as a share of the deviations of the initial Gaussian: the accuracy of probabilities.
    pub(crate) fn of_probabilities(years: f64, family: &Family<impl PlanarHamiltonian>) -> f64 {
        let initial = &family.measure.gaussian;
        Self::after(years, family).over(initial.sigma_e, initial.sigma_phi_given_e(), initial.mean_e)
    }

    /// The noise as a share of one standard deviation.
    fn over_one(self, deviation: f64) -> f64 {
        self.0 / deviation
    }

    /// The noise as a share of the deviations of a cloud, summed over `phi` and `e`.
    pub(super) fn over(self, std_e: f64, std_phi: f64, mean_e: f64) -> f64 {
        self.over_one(std_phi * mean_e.max(std_e)) + self.over_one(std_e)
    }
}

/// Standard deviation of `e` and of `phi` from the second pass.
fn deviations(values: &[f64]) -> (f64, f64) {
    let deviation = |first: f64, second: f64| {
        let (first, second) = (first / values[0], second / values[0]);
        (second - first * first).max(1e-30).sqrt()
    };
    (deviation(values[3], values[4]), deviation(values[5], values[6]))
}

/// The natural size of each integral of the second pass.
pub(super) fn scales(values: &[f64]) -> [f64; SECOND] {
    let (e, phi) = deviations(values);
    let spread = phi.min(1.0);
    // The density at the branch cut only enters an error estimate.
    [1.0, spread, spread, e, e * e, phi, phi * phi, phi * e, f64::INFINITY]
}

/// The moments from both passes.
pub(super) fn finish(coarse: &Integrals, fine: &Integrals, centre: Centre, noise: Noise) -> SmoothMoments {
    let mean = |f: usize| fine.values[f] / fine.values[0];
    let (std_e, std_phi) = deviations(&fine.values);
    let circular = Circular::from_mean_vector(mean(2), mean(1));
    let circular_error = fine.errors[1] + fine.errors[2] + (1.0 - fine.values[0]).abs();
    // The mean moves by 2π p(cut) for every radian that the branch cut moves by.
    let shift = nearest(circular.mean - centre.phi, 0.0).abs() + circular_error / circular.resultant.max(1e-300);
    let cut = (2.0 * PI * mean(8).max(0.0) * shift).min(2.0 * PI);
    let scales = scales(&fine.values);
    let missing = (1.0 - fine.values[0]).abs();
    let relative = |f: usize| fine.errors[f] / scales[f] + missing;
    // The accuracy of the states themselves matters for a cloud that is hardly wider than their error.
    let mean_e = centre.e + mean(3);
    let e_error =
        relative(3).max(relative(4)) + noise.over_one(std_e) + if fine.lost + coarse.lost > 0 { missing } else { 0.0 };
    let phi_error = relative(5).max(relative(6)).max(relative(7))
        + noise.over(std_e, std_phi, mean_e)
        + cut / std_phi
        + 2.0 * cut * PI / std_phi.powi(2);
    SmoothMoments {
        // The centre and the circular mean may lie on different sides of 2π.
        mean_phi: nearest(centre.phi + mean(5), fold(circular.mean, 0.0)),
        std_phi,
        mean_e,
        std_e,
        cov_phi_e: mean(7) - mean(5) * mean(3),
        circular: Circular { mean: fold(circular.mean, 0.0), ..circular },
        error: e_error.max(phi_error),
        e_error,
        circular_error,
        mass_error: missing + fine.errors[0],
        orbits: coarse.orbits + fine.orbits,
    }
}

fn about(family: &Family<impl PlanarHamiltonian>, orbit: &Orbit, t: f64, centre: Centre) -> Vec<f64> {
    let cuts = cut_crossings(orbit, &family.flow.model, centre.phi + PI);
    let mut values = along(family, orbit, t, Some(&cuts), |phi, e| {
        let (theta, de) = (nearest(phi, centre.phi) - centre.phi, e - centre.e);
        let (sin, cos) = phi.sin_cos();
        [1.0, cos, sin, de, de * de, theta, theta * theta, theta * de]
    });
    let at_cut = |&theta: &f64| {
        let state = orbit.contour.at(theta);
        let point = super::trail::OrbitPoint { theta, phi: state.solar_angle(), e: state.eccentricity() };
        let (rate, _) = point.rates(&family.flow.model);
        density(&family.measure, orbit.contour.at(orbit.contour.wrap(theta - t))) / rate.abs().max(1e-3)
    };
    values.push(cuts.iter().map(at_cut).sum());
    values
}

/// The integral along an orbit of functions of the state `t` later. The functions jump at the times `cuts` on the
/// orbit.
fn along<const N: usize>(
    family: &Family<impl PlanarHamiltonian>,
    orbit: &Orbit,
    t: f64,
    cuts: Option<&[f64]>,
    function: impl Fn(f64, f64) -> [f64; N],
) -> Vec<f64> {
    let contour = &orbit.contour;
    // Where a rule must end, as times on the orbit at the start.
    let mut ends: Vec<f64> = later_ends(orbit).chain(cuts.unwrap_or(&[]).iter().copied()).collect();
    ends.iter_mut().for_each(|end| *end = contour.wrap(*end - t));
    ends.sort_by(f64::total_cmp);
    let mut sums = [0.0; N];
    let mut add = |theta: f64, weight: f64| {
        let there = contour.at(contour.wrap(theta + t));
        let values = function(there.solar_angle(), there.eccentricity());
        sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
    };
    for (low, high, part) in orbit.share.parts() {
        let first = ends.partition_point(|&end| end <= low);
        let mut inside = ends[first..].iter().copied().take_while(|&end| end < high).peekable();
        if inside.peek().is_none() {
            gauss(low, high).iter().zip(part.density).for_each(|(&(theta, weight), a)| add(theta, weight * a));
            continue;
        }
        let mut from = low;
        for to in inside.chain([high]) {
            let nodes = gauss(from, to);
            nodes.iter().for_each(|&(theta, weight)| add(theta, weight * density(&family.measure, contour.at(theta))));
            from = to;
        }
    }
    sums.to_vec()
}

/// Times on the orbit between which its state is well resolved: the ends of the integrator's steps, and times on both
/// sides of the least eccentric point at distances that double, from a fraction of the time in which the solar angle
/// turns there.
fn later_ends(orbit: &Orbit) -> impl Iterator<Item = f64> + '_ {
    let contour = &orbit.contour;
    let knots = contour.knots().flat_map(|knot| [knot, -knot]);
    let first_step = contour.knots().nth(1).unwrap_or(contour.half);
    let start = contour.at(0.0).eccentricity();
    let speed = contour.at(1e-3 * first_step).x1.abs() / (1e-3 * first_step);
    let turning = 0.25 * start / speed.max(1e-300);
    let doubled = std::iter::successors(Some(turning.max(1e-13)), |x| Some(2.0 * x));
    knots.chain(doubled.take_while(move |&x| x < first_step).flat_map(|x| [x, -x]))
}

/// The times on the orbit at which the solar angle passes `cut`.
fn cut_crossings(orbit: &Orbit, model: &impl PlanarHamiltonian, cut: f64) -> Vec<f64> {
    let (sin, cos) = cut.sin_cos();
    // e sin(phi - cut) and e cos(phi - cut), which are smooth also at e = 0.
    let aside = |theta: f64| {
        let state = orbit.contour.at(theta);
        state.x1 * cos - state.x2 * sin
    };
    let ahead = |theta: f64| {
        let state = orbit.contour.at(theta);
        state.x2 * cos + state.x1 * sin
    };
    let points = &orbit.trail(model).points;
    let values: Vec<f64> = points.iter().map(|point| point.e * (point.phi - cut).sin()).collect();
    let changes = (1..points.len()).filter(|&k| (values[k - 1] < 0.0) != (values[k] < 0.0));
    let root = |k: usize| {
        let (mut low, mut high) = (points[k - 1].theta, points[k].theta);
        let starts_below = aside(low) < 0.0;
        for _ in 0..60 {
            let middle = low.midpoint(high);
            if (aside(middle) < 0.0) == starts_below { low = middle } else { high = middle }
        }
        low.midpoint(high)
    };
    changes.map(root).filter(|&theta| ahead(theta) > 0.0).collect()
}

/// The probability that the eccentricity exceeds `critical_e` after `years`, with its error estimate.
pub(super) fn probability_above(
    family: &Family<impl PlanarHamiltonian>,
    critical_e: f64,
    years: f64,
    tolerance: ProbabilityTolerance,
    most_orbits: usize,
) -> super::Estimated {
    let t = angle_of(years);
    let above = |orbit: &Orbit| {
        let contour = &orbit.contour;
        let rises = contour.rises_above(critical_e);
        let above = rises.map_or(0.0, |theta| orbit.share.between(contour, theta - t, contour.period() - theta - t));
        vec![orbit.share.total(), above]
    };
    let noise = Noise::of_probabilities(years, family);
    let tolerances = |values: &[f64], _: &[f64]| {
        let of_share = tolerance.of(values[1]).max(0.3 * noise * values[1]);
        vec![tolerance.absolute().max(0.3 * noise), of_share]
    };
    let found = family.integrate(family.first_intervals(), 2, above, tolerances, most_orbits);
    let missing = (1.0 - found.values[0]).abs();
    // The missing part of the whole may be above.
    let missing = if missing < found.errors[0] + 1e-13 { missing * found.values[1] } else { missing };
    let value = found.values[1].clamp(0.0, 1.0);
    super::Estimated { value, error: found.errors[1] + missing + touching(value) }
}

/// Uncertainty of a probability where orbits just touch the critical eccentricity.
pub(crate) fn touching(probability: f64) -> f64 {
    TOUCHING * probability * (1.0 - probability)
}

//! Probability of a region at time `t` from its boundary: the curve is carried back to `t = 0` and the initial measure's
//! one-form integrated along it (see [`super::measure`]).
//!
//! The curve is cut into panels, each a Chebyshev polynomial through backward orbits. Panels whose last coefficients are
//! not yet small against the cloud are halved, all those of a level in one call of the flow.

use std::f64::consts::FRAC_PI_2;

use crate::dynamics::State;
use crate::flow::{Escaped, Flow};

use super::measure::{Measure, REACH, Side};
use super::panel::{Panel, Resolution, chebyshev_nodes, chebyshev_transform};

const N: usize = 16;
/// Panels at the start.
const FIRST: usize = 8;
/// Panels after which halving ends; a curve that needs more reports a large error.
const MOST: usize = 1 << 15;
/// How small, in standard deviations, the last coefficients have to be.
const SMALL: f64 = 1e-10;
/// The flow's own accuracy: smaller coefficients say nothing.
const NOISE: f64 = 1e-12;

/// Coefficients below which the flow's noise, amplified along the orbit, may be what is left.
const NOISY: f64 = 1e-8;

/// An integral and an estimate of its error.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Quadrature {
    /// The integral.
    pub value: f64,
    /// Estimate of its absolute error.
    pub error: f64,
}

impl Quadrature {
    /// The sum of two integrals; errors add.
    pub fn plus(self, other: Self) -> Self {
        Self { value: self.value + other.value, error: self.error + other.error }
    }

    /// A multiple.
    pub fn times(self, factor: f64) -> Self {
        Self { value: self.value * factor, error: self.error * factor.abs() }
    }
}

/// `∫ G w dphi` (or with `U`, see [`Side`]) along the image at `t = 0` of a curve. `curve(s)`, `0 <= s <= 1`, gives a state
/// and how many years after `t = 0` the curve passes there.
///
/// # Errors
/// [`Escaped`] if an orbit of the curve cannot be followed back.
pub fn circulation(
    flow: &Flow,
    measure: &Measure,
    side: Side,
    curve: impl Fn(f64) -> (State, f64),
) -> Result<Quadrature, Escaped> {
    let (part, turns) = circulation_and_turns(flow, measure, side, curve)?;
    Ok(Quadrature { value: part.value + turns, ..part })
}

/// As [`circulation`], in two parts to be added: for [`Side::Above`] a whole number is kept apart from the rest, so that a small
/// probability keeps its digits.
///
/// # Errors
/// As [`circulation`].
pub fn circulation_and_turns(
    flow: &Flow,
    measure: &Measure,
    side: Side,
    curve: impl Fn(f64) -> (State, f64),
) -> Result<(Quadrature, f64), Escaped> {
    let (nodes, transform) = (chebyshev_nodes::<N>(), chebyshev_transform::<N>());
    let tolerance = (SMALL * measure.scale()).max(NOISE);
    let part = |i: usize| i as f64 / FIRST as f64;
    let mut pending: Vec<(f64, f64, f64)> = (0..FIRST).map(|i| (part(i), part(i + 1), f64::INFINITY)).collect();
    let (mut total, mut turns, mut panels) = (Quadrature::default(), 0.0, 0);
    while !pending.is_empty() {
        let parameters = pending.iter().flat_map(|&(a, b, _)| nodes.map(|x| a.midpoint(b) + 0.5 * (b - a) * x));
        let (states, years): (Vec<State>, Vec<f64>) = parameters.map(&curve).unzip();
        let mut x1: Vec<f64> = states.iter().map(|state| state.x1).collect();
        let mut x2: Vec<f64> = states.iter().map(|state| state.x2).collect();
        let back: Vec<f64> = years.iter().map(|years| -years).collect();
        flow.advance_each(&mut x1, &mut x2, &back)?;
        panels += pending.len();
        let mut next = Vec::new();
        for ((&(a, b, before), x1), x2) in pending.iter().zip(x1.chunks_exact(N)).zip(x2.chunks_exact(N)) {
            let coefficients = |values: &[f64]| transform.map(|row| row.iter().zip(values).map(|(t, x)| t * x).sum());
            let panel = Panel { x1: coefficients(x1), x2: coefficients(x2) };
            let tail = panel.tail();
            // Halving divides a smooth curve's last coefficients by thousands. Once it does not, they are noise of the flow.
            let noise = tail < NOISY && tail > 0.1 * before;
            if tail > tolerance && !noise && panels < MOST {
                if !passes_beside(measure, x1, x2) {
                    next.extend([(a, a.midpoint(b), tail), (a.midpoint(b), b, tail)]);
                }
            } else {
                let (part, part_turns) = integral(&panel, measure, side);
                total = total.plus(part);
                turns += part_turns;
            }
        }
        pending = next;
    }
    Ok((total, turns))
}

/// Whether the curve keeps so far to the side of the cloud, in solar angle, that the one-form vanishes on it: farther than its
/// nodes are from each other.
fn passes_beside(measure: &Measure, x1: &[f64], x2: &[f64]) -> bool {
    let widest = (1..N).map(|k| (x1[k] - x1[k - 1]).hypot(x2[k] - x2[k - 1])).fold(0.0, f64::max);
    let beside = x1.iter().zip(x2).map(|(&x1, &x2)| {
        let state = State { x1, x2 };
        let angle = (measure.phi_sigmas(state.solar_angle()).abs() - REACH) * measure.gaussian.sigma_phi;
        if angle > 0.0 { state.eccentricity() * angle.min(FRAC_PI_2).sin() } else { 0.0 }
    });
    beside.fold(f64::INFINITY, f64::min) > 2.0 * widest
}

fn integral(panel: &Panel<N>, measure: &Measure, side: Side) -> (Quadrature, f64) {
    let along = |resolution| panel.circulation(measure, side, resolution, (-1.0, 1.0));
    let (coarse, fine) = (along(Resolution::FINE), along(Resolution::FINEST));
    // A curve displaced by a share of a standard deviation moves at most that share of what it sweeps and of its ends. The
    // polynomial displaces it by its last coefficients, the flow by its own error, which they do not show.
    let displaced = (panel.tail() + NOISE) / measure.scale() * (fine.size + panel.end_values(measure, side));
    let difference = (fine.value - coarse.value) + (fine.turns - coarse.turns);
    (Quadrature { value: fine.value, error: difference.abs() + displaced }, fine.turns)
}

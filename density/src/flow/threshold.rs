//! First passages read off the integrator's own series.
//!
//! A satellite re-enters where its clearance `c` ([`crate::model::Model::clearance`]; in the plane `s = sqrt(1 - e²)`)
//! falls to a critical value `c_crit`. The integrator has the Taylor series of the clearance at hand: within a step `h`
//! the clearance cannot fall below `c_0 - sum |c_n| h^n`. Only where that bound reaches `c_crit` is the series itself
//! followed, in a few pieces, to its first root.

use multiversion::multiversion;

use super::carry::{Crew, Step, Watch};
use super::taylor::MOST_COEFFICIENTS;
use crate::model::earth::SUN_MEAN_MOTION;
use crate::model::{LANES, Lanes};

/// Number of pieces of a step, in each of which the clearance has at most one minimum. A year takes about fifteen steps
/// at the default accuracy.
const PIECES: usize = 8;
/// Largest number of steps to a root: more than a double has bits, if all of them are halvings.
const MOST_STEPS: u32 = 60;
/// Length of a step that ends the search, as a share of the interval in which the root is sought.
const SMALL_STEP: f64 = 1e-9;

/// Where first passages are noted, in the precision that the caller needs.
pub struct Passages<'a, T> {
    /// One entry per orbit.
    pub passages: &'a mut [T],
    /// The entry of an orbit that has not passed.
    pub pending: T,
    /// The entry for a passage at a given time \[yr\].
    pub note: &'a (dyn Fn(f64) -> T + Sync),
}

/// Watches for the first passage of every orbit through a critical clearance; all orbits run forwards.
pub(super) struct Threshold<'a, T> {
    /// The clearance at which a satellite re-enters.
    pub critical: f64,
    /// Time at the end of the interval \[yr\].
    pub end: f64,
    /// The passages noted so far.
    pub passages: Passages<'a, T>,
}

impl<T: Copy + PartialEq> Watch for Threshold<'_, T> {
    fn sees_clearance(&self) -> bool {
        true
    }

    fn see(&mut self, &Step { clearance, lengths, crew, .. }: &Step<'_>) {
        let pending = |orbit: &usize| self.passages.passages.get(*orbit).is_some_and(|p| *p == self.passages.pending);
        if !crew.orbit.iter().flatten().any(pending) {
            return;
        }
        let is_near = may_reach(clearance, lengths, self.critical);
        if is_near.contains(&true) {
            for l in 0..LANES {
                if is_near[l] {
                    self.follow(clearance, l, lengths[l], crew);
                }
            }
        }
    }
}

impl<T: Copy + PartialEq> Threshold<'_, T> {
    /// Looks for the passage of one lane's orbit in one step.
    fn follow(&mut self, clearance: &[Lanes], lane: usize, step: f64, crew: &Crew) {
        let Passages { passages, pending, note } = &mut self.passages;
        let Some(passage) = crew.orbit[lane].and_then(|orbit| passages.get_mut(orbit)) else { return };
        if passage != pending {
            return;
        }
        let mut polynomial = [0.0; MOST_COEFFICIENTS];
        for (coefficient, lanes) in polynomial.iter_mut().zip(clearance) {
            *coefficient = lanes[lane];
        }
        polynomial[0] -= self.critical;
        if let Some(time) = first_fall(&polynomial[..clearance.len()], step) {
            *passage = note(self.end - (crew.left[lane] + step - time) / SUN_MEAN_MOTION);
        }
    }
}

/// In which lanes the clearance may fall to its critical value within the step.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
fn may_reach(clearance: &[Lanes], lengths: &Lanes, critical: f64) -> [bool; LANES] {
    let Some((now, further)) = clearance.split_first() else { return [false; LANES] };
    let mut fall = [0.0; LANES];
    for coefficient in further.iter().rev() {
        for l in 0..LANES {
            fall[l] = (fall[l] + coefficient[l].abs()) * lengths[l];
        }
    }
    std::array::from_fn(|l| now[l] - fall[l] <= critical)
}

/// First time in `[0, step]` at which a polynomial of at most [`MOST_COEFFICIENTS`] coefficients is 0 or less.
fn first_fall(polynomial: &[f64], step: f64) -> Option<f64> {
    if polynomial[0] <= 0.0 {
        return Some(0.0);
    }
    let mut edges = [0.0; PIECES + 1];
    for (piece, edge) in edges.iter_mut().enumerate() {
        *edge = step * piece as f64 / PIECES as f64;
    }
    let (values, slopes) = evaluate(polynomial, &edges);
    (0..PIECES).find_map(|piece| {
        let (from, to) = (edges[piece], edges[piece + 1]);
        let at = |t: f64| {
            let ([value], [slope]) = evaluate(polynomial, &[t]);
            (value, slope)
        };
        if values[piece + 1] <= 0.0 {
            let secant = from + (to - from) * values[piece] / (values[piece] - values[piece + 1]);
            return Some(root(at, from, to, secant));
        }
        // A minimum between the ends?
        if !(slopes[piece] < 0.0 && slopes[piece + 1] > 0.0) {
            return None;
        }
        let mut derivative = [0.0; MOST_COEFFICIENTS];
        for (n, coefficient) in polynomial.iter().enumerate().skip(1) {
            derivative[n - 1] = -(n as f64) * coefficient;
        }
        let lowest = root(
            |t| {
                let ([slope], [curvature]) = evaluate(&derivative[..polynomial.len()], &[t]);
                (slope, curvature)
            },
            from,
            to,
            0.5 * (from + to),
        );
        (at(lowest).0 <= 0.0).then(|| root(at, from, lowest, 0.5 * (from + lowest)))
    })
}

/// Values and slopes of a polynomial at several times at once.
fn evaluate<const N: usize>(polynomial: &[f64], times: &[f64; N]) -> ([f64; N], [f64; N]) {
    let (mut values, mut slopes) = ([0.0; N], [0.0; N]);
    for coefficient in polynomial.iter().rev() {
        for k in 0..N {
            slopes[k] = slopes[k] * times[k] + values[k];
            values[k] = values[k] * times[k] + coefficient;
        }
    }
    (values, slopes)
}

/// The argument at which a function that is positive at `low` and not at `high` changes its sign. The search starts
/// from `time` and takes Newton steps from value and slope, or a halving where a Newton step would leave the remaining
/// interval.
///
/// Near a simple root the error of a Newton step is the square of the error before, so a step of [`SMALL_STEP`] is the
/// last.
fn root(function: impl Fn(f64) -> (f64, f64), mut low: f64, mut high: f64, mut time: f64) -> f64 {
    let small = SMALL_STEP * (high - low);
    for _ in 0..MOST_STEPS {
        let (value, slope) = function(time);
        if value > 0.0 {
            low = time;
        } else {
            high = time;
        }
        let newton = time - value / slope;
        let next = if (low..=high).contains(&newton) { newton } else { 0.5 * (low + high) };
        if (next - time).abs() <= small {
            return next;
        }
        time = next;
    }
    time
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_fall_is_found_also_when_the_polynomial_rises_again() {
        // (t - 0.3)(t - 0.4): it falls below zero and rises again between two edges.
        assert!((first_fall(&[0.12, -0.7, 1.0], 2.0).unwrap() - 0.3).abs() < 1e-15);
        assert!((first_fall(&[1.0, -2.0], 1.0).unwrap() - 0.5).abs() < 1e-15);
        assert_eq!(first_fall(&[0.0, 1.0], 1.0), Some(0.0));
        assert_eq!(first_fall(&[1.0, -0.1], 1.0), None);
        assert_eq!(first_fall(&[0.13, -0.7, 1.0], 2.0), None, "its minimum is above");
    }

    #[test]
    fn a_root_is_found_where_newtons_steps_alone_would_not_converge() {
        // From a start this far off, Newton's steps for arctan overshoot ever farther.
        let function = |t: f64| ((0.3 - t).atan(), -1.0 / (1.0 + (0.3 - t) * (0.3 - t)));
        assert!((root(function, -20.0, 40.0, 10.0) - 0.3).abs() < 1e-15);
        // A flat start.
        assert!((root(|t| (1.0 - t.powi(9), -9.0 * t.powi(8)), 0.0, 2.5, 1.25) - 1.0).abs() < 1e-15);
    }
}

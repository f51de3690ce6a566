//! First passages read off the integrator's own series.
//!
//! The eccentricity reaches its critical value where `s = sqrt(1 - e²)` falls to `s_crit`, and `s` is one of the variables
//! whose Taylor series the integrator has at hand: within a step `h` it cannot fall below `s_0 - sum |s_n| h^n`. Only where
//! that bound reaches `s_crit` is the series itself followed, in a few pieces, to its first root.

use super::taylor::{Crew, LANES, Lanes, Series, Watch};
use crate::dynamics::SUN_MEAN_MOTION;

/// Pieces of a step in which `s` has at most one minimum: a year takes about fifteen steps at the default accuracy.
const PIECES: u32 = 8;
/// Halvings of an interval: more than a double has bits.
const HALVINGS: u32 = 60;

/// Watches for the first passage of every orbit through a critical eccentricity.
pub(super) struct Threshold<'a> {
    /// `sqrt(1 - e_crit²)`.
    pub critical_s: f64,
    /// Time at the end of the interval \[yr\].
    pub end: f64,
    /// First passage time of each orbit \[yr\]; infinite while it has not passed.
    pub passages: &'a mut [f64],
}

impl Watch for Threshold<'_> {
    #[inline(always)]
    fn see<const P: usize>(&mut self, series: &Series<P>, steps: &Lanes, crew: &Crew) {
        let mut fall = [0.0; LANES];
        for n in (1..P).rev() {
            for l in 0..LANES {
                fall[l] = (fall[l] + series.s[n][l].abs()) * steps[l];
            }
        }
        let mut is_near = [false; LANES];
        for l in 0..LANES {
            is_near[l] = series.s[0][l] - fall[l] <= self.critical_s;
        }
        if is_near.contains(&true) {
            for l in 0..LANES {
                if is_near[l] {
                    self.follow(series, l, steps[l], crew);
                }
            }
        }
    }
}

impl Threshold<'_> {
    /// Looks for the passage of one lane's orbit in one step.
    #[inline(never)]
    fn follow<const P: usize>(&mut self, series: &Series<P>, lane: usize, step: f64, crew: &Crew) {
        let Some(passage) = crew.orbit[lane].and_then(|orbit| self.passages.get_mut(orbit)) else { return };
        if passage.is_finite() {
            return;
        }
        let mut polynomial = [0.0; P];
        for (coefficient, lanes) in polynomial.iter_mut().zip(&series.s) {
            *coefficient = lanes[lane];
        }
        polynomial[0] -= self.critical_s;
        if let Some(time) = first_fall(&polynomial, step) {
            *passage = self.end - (crew.left[lane] + step - time) / SUN_MEAN_MOTION;
        }
    }
}

/// First time in `[0, step]` at which a polynomial is 0 or less.
fn first_fall(polynomial: &[f64], step: f64) -> Option<f64> {
    if polynomial[0] <= 0.0 {
        return Some(0.0);
    }
    let value = |t: f64| polynomial.iter().rev().fold(0.0, |sum, c| sum * t + c);
    let slope = |t: f64| polynomial.iter().enumerate().skip(1).rev().fold(0.0, |sum, (n, c)| sum * t + n as f64 * c);
    let edge = |piece: u32| step * f64::from(piece) / f64::from(PIECES);
    (0..PIECES).find_map(|piece| {
        let (from, to) = (edge(piece), edge(piece + 1));
        if value(to) <= 0.0 {
            return Some(bisect(value, from, to));
        }
        // A minimum between the ends?
        let lowest = (slope(from) < 0.0 && slope(to) > 0.0).then(|| bisect(|t| -slope(t), from, to))?;
        (value(lowest) <= 0.0).then(|| bisect(value, from, lowest))
    })
}

/// Where a function that is positive at `low` and not at `high` changes its sign.
fn bisect(function: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if function(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_fall_is_found_also_when_the_polynomial_rises_again() {
        // (t - 0.3)(t - 0.4): down and up between two edges.
        assert!((first_fall(&[0.12, -0.7, 1.0], 2.0).unwrap() - 0.3).abs() < 1e-15);
        assert!((first_fall(&[1.0, -2.0], 1.0).unwrap() - 0.5).abs() < 1e-15);
        assert_eq!(first_fall(&[0.0, 1.0], 1.0), Some(0.0));
        assert_eq!(first_fall(&[1.0, -0.1], 1.0), None);
        assert_eq!(first_fall(&[0.13, -0.7, 1.0], 2.0), None, "its minimum is above");
    }
}

//! First passage: the probability that the eccentricity has EVER reached its critical value by time `t`.
//!
//! A satellite that has once touched the critical eccentricity has re-entered. So the snapshot probability
//! `P(e(t) > e_crit)` is only a lower bound of what matters for disposal: an orbit may peak and come back between
//! snapshots. With `T` the first time at which `e >= e_crit` (0 if the orbit starts there), the curve is `P(T <= t)`.
//!
//! - [`passage_times`]: `T` of every orbit of a sample, read off the integrator's own series;
//! - [`times`]: the same, searched for in segments, as a test of [`passage_times`];
//! - [`empirical`]: the curve of a weighted sample;
//! - [`exact`]: the curve without sampling;
//! - [`over_leaves`]: the curve where the radiation parameter is uncertain;
//! - [`given`]: what re-entry says of that parameter.

pub mod empirical;
pub mod exact;
pub mod given;
pub mod over_leaves;
pub mod times;

use crate::flow::{Escaped, Flow, Passages};
use crate::model::earth::SUN_MEAN_MOTION;
use crate::model::plane::{PlanarHamiltonian, State};

/// First time \[yr\] within `[0, end]` at which the orbit `(x1[i], x2[i])` has `e >= critical_e`; infinite if there is
/// none.
///
/// # Errors
/// [`Escaped`] if an orbit cannot be followed to `end`.
///
/// # Panics
/// If the slices differ in length.
pub fn passage_times<M: PlanarHamiltonian>(
    flow: &Flow<M>,
    x1: &[f64],
    x2: &[f64],
    critical_e: f64,
    end: f64,
) -> Result<Vec<f64>, Escaped> {
    let (mut x1, mut x2) = (x1.to_vec(), x2.to_vec());
    let mut times = vec![f64::INFINITY; x1.len()];
    let passages = Passages { passages: &mut times, pending: f64::INFINITY, note: &|time| time };
    flow.advance_watching(&mut x1, &mut x2, (0.0, end), critical_e, passages)?;
    Ok(times)
}

/// Evenly spaced times from 0 to `end` \[yr\], both included; a single 0 if `count < 2`.
pub fn curve_times(end: f64, count: usize) -> Vec<f64> {
    let last = count.max(2) - 1;
    (0..count.max(1)).map(|i| end * (i as f64 / last as f64)).collect()
}

/// Number of segments of an interval such that an orbit with `e <= critical_e` turns by less than a radian in each. A
/// segment is short enough for a fifth-degree polynomial to be accurate to 1e-5, and about as long as the integrator's
/// own steps.
fn segments(model: &impl PlanarHamiltonian, critical_e: f64, years: f64) -> usize {
    const PHASE: f64 = 1.0;
    /// So near to `e = 1` the rates lose their meaning.
    const RIM: f64 = 0.999_999_5;
    let turning = |e: f64| model.turning_rate(State { x1: 0.0, x2: e });
    let fastest = turning(0.0).max(turning(critical_e.min(RIM))).max(1.0) + model.pull();
    (years * SUN_MEAN_MOTION * fastest / PHASE).ceil().clamp(1.0, 1e7) as usize
}

/// The fifth-degree polynomial on `[0, length]` with given value, slope and second derivative at both ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quintic {
    coefficients: [f64; 6],
    length: f64,
}

impl Quintic {
    /// From `[value, slope, second derivative]` at 0 and at `length`.
    pub(crate) fn new(start: [f64; 3], end: [f64; 3], length: f64) -> Self {
        let [a, b, c] = [start[0], start[1] * length, 0.5 * start[2] * length * length];
        let rest = end[0] - a - b - c;
        let slope = end[1] * length - b - 2.0 * c;
        let bend = end[2] * length * length - 2.0 * c;
        let d = 10.0 * rest - 4.0 * slope + 0.5 * bend;
        let e = -15.0 * rest + 7.0 * slope - bend;
        let f = 6.0 * rest - 3.0 * slope + 0.5 * bend;
        Self { coefficients: [a, b, c, d, e, f], length }
    }

    pub(crate) fn at(&self, time: f64) -> f64 {
        let x = time / self.length;
        self.coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
    }

    fn slope_and_bend(&self, x: f64) -> (f64, f64) {
        let [_, b, c, d, e, f] = self.coefficients;
        let slope = b + x * (2.0 * c + x * (3.0 * d + x * (4.0 * e + x * 5.0 * f)));
        (slope, 2.0 * c + x * (6.0 * d + x * (12.0 * e + x * 20.0 * f)))
    }

    /// The time of the peak inside, `None` if there is none. There is a peak only if the slope is positive at 0 and
    /// negative at `length`, or if the value at an inner point is above both ends.
    pub(crate) fn peak(&self) -> Option<f64> {
        let (rise, fall) = (self.slope_and_bend(0.0).0, self.slope_and_bend(1.0).0);
        let (mut low, mut high) = (0.0, 1.0);
        if !(rise >= 0.0 && fall <= 0.0) {
            let ends = self.at(0.0).max(self.at(self.length));
            let inner = [0.25, 0.5, 0.75].into_iter().find(|x| self.at(x * self.length) > ends)?;
            (low, high) = (inner - 0.25, inner + 0.25);
        }
        let mut x: f64 = if rise > fall { (rise / (rise - fall)).clamp(low, high) } else { f64::midpoint(low, high) };
        for _ in 0..4 {
            let (slope, bend) = self.slope_and_bend(x);
            if slope > 0.0 {
                low = x
            } else {
                high = x
            }
            let newton = x - slope / bend;
            x = if newton > low && newton < high { newton } else { f64::midpoint(low, high) };
        }
        Some(x * self.length)
    }

    /// The first zero on the way up between 0 and `until`, at which the polynomial is positive or nearly so.
    fn first_rise(&self, until: f64) -> f64 {
        const PARTS: u32 = 16;
        let time = |k: u32| until * f64::from(k) / f64::from(PARTS);
        let part = (1..PARTS).find(|&k| self.at(time(k)) >= 0.0).unwrap_or(PARTS);
        let (mut low, mut high) = (time(part - 1), time(part));
        for _ in 0..40 {
            let middle = low.midpoint(high);
            if self.at(middle) < 0.0 { low = middle } else { high = middle }
        }
        high
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quintic_reproduces_a_polynomial_of_degree_five() {
        let f = |x: f64| 1.0 - x + 2.0 * x.powi(3) - 0.5 * x.powi(5);
        let df = |x: f64| -1.0 + 6.0 * x * x - 2.5 * x.powi(4);
        let ddf = |x: f64| 12.0 * x - 10.0 * x.powi(3);
        let quintic = Quintic::new([f(0.0), df(0.0), ddf(0.0)], [f(0.7), df(0.7), ddf(0.7)], 0.7);
        for x in [0.1, 0.33, 0.69] {
            assert!((quintic.at(x) - f(x)).abs() < 1e-14);
        }
    }
}

//! The first-passage curve without sampling.
//!
//! Every orbit that passes leaves `e < e_crit` through the upper half of the circle `e = e_crit`, where `sin(phi) > 0`. So
//! the orbits that have passed by `t` are those that start above `e_crit`, and the backward images `(phi, τ)` of the half
//! circle's points, `0 < phi < π`, `0 <= τ <= min(t, R(phi))`: carried back beyond `R` an orbit has come in through the
//! circle and been outside before. Each of them passes once in that set, so
//!
//! ```text
//! P(T <= t) = P(e_0 >= e_crit) + P{Φ_-τ(phi, e_crit) : 0 < phi < π, 0 <= τ <= min(t, R(phi))}
//! ```
//!
//! and the second probability is the circulation along that set's border (see [`crate::exact::measure`]): the half circle,
//! the orbits that touch the circle at `phi = 0` and `π`, the half circle at `τ = t` carried back, and where `R < t` the
//! entry points, which are the mirror images `-phi` as the flow is reversible: `H` on the circle depends on `cos(phi)` alone.
//! By the same symmetry the orbit is half-way when `x1 = 0`, so `R` is twice the time to that.

use std::f64::consts::PI;

use rayon::prelude::*;

use crate::dynamics::State;
use crate::exact::measure::{Measure, Side};
use crate::exact::pullback::{Quadrature, circulation};
use crate::flow::{Escaped, Flow};
use crate::problem::Problem;

use super::{Quintic, principal, segments};

/// Points of the half circle at which `R` is sampled, to find where it is above each time.
const SAMPLES: usize = 2048;

/// `P(T <= t)` at each of `times` \[yr\], with error estimates.
///
/// # Errors
/// [`Escaped`] if an orbit of the critical circle cannot be followed back.
pub fn exact_curve(problem: &Problem, flow: &Flow, times: &[f64]) -> Result<Vec<Quadrature>, Escaped> {
    let measure = Measure::new(problem.initial);
    let critical = Critical { flow, measure, e: problem.critical_e };
    let at_start = measure.e_probability(measure.e_sigmas(critical.e), Side::Above);
    let constant = Quadrature { value: at_start, error: 0.0 };
    let end = times.iter().copied().fold(0.0, f64::max);
    if flow.force.radiation == 0.0 || end == 0.0 {
        return Ok(vec![constant; times.len()]);
    }
    let angles: Vec<f64> = (0..=SAMPLES).map(|k| PI * k as f64 / SAMPLES as f64).collect();
    let residences = critical.residences(&angles, end)?;
    times
        .par_iter()
        .map(|&time| {
            Ok(if time > 0.0 { constant.plus(critical.passed(&angles, &residences, time)?) } else { constant })
        })
        .collect::<Vec<_>>()
        .into_iter()
        .collect()
}

struct Critical<'a> {
    flow: &'a Flow,
    measure: Measure,
    e: f64,
}

impl Critical<'_> {
    /// For how long, up to `end`, an orbit that leaves through `phi` has been inside; infinite if for longer.
    fn residences(&self, angles: &[f64], end: f64) -> Result<Vec<f64>, Escaped> {
        let force = self.flow.force;
        let (mut x1, mut x2): (Vec<f64>, Vec<f64>) = angles
            .iter()
            .map(|&phi| {
                let state = State::from_polar(-phi, self.e);
                (state.x1.min(0.0), state.x2)
            })
            .unzip();
        let count = segments(force, self.e, 0.5 * end);
        let segment = 0.5 * end / count as f64;
        let mut residences = vec![f64::INFINITY; angles.len()];
        for k in 0..count {
            let before: Vec<State> = x1.iter().zip(&x2).map(|(&x1, &x2)| State { x1, x2 }).collect();
            self.flow.advance(&mut x1, &mut x2, segment)?;
            let crosses = |&i: &usize| residences[i].is_infinite() && before[i].x1 <= 0.0 && x1[i] >= 0.0;
            let crossing: Vec<usize> = (0..angles.len()).filter(crosses).collect();
            let ends: Vec<State> = crossing.iter().map(|&i| State { x1: x1[i], x2: x2[i] }).collect();
            let starts: Vec<State> = crossing.iter().map(|&i| before[i]).collect();
            for (&i, time) in crossing.iter().zip(self.halfway(&starts, &ends, segment)?) {
                residences[i] = 2.0 * (segment * k as f64 + time);
            }
        }
        Ok(residences)
    }

    /// The times at which `x1 = 0` between two sets of states.
    fn halfway(&self, starts: &[State], ends: &[State], segment: f64) -> Result<Vec<f64>, Escaped> {
        let force = self.flow.force;
        let slope = |state: State| force.rate(state).x1;
        // The second derivative by the chain rule, from the rates beside the state.
        let bend = |state: State| {
            const STEP: f64 = 1e-4;
            let rate = force.rate(state);
            let beside = |h: f64| State { x1: state.x1 + h * rate.x1, x2: state.x2 + h * rate.x2 };
            (slope(beside(STEP)) - slope(beside(-STEP))) / (2.0 * STEP)
        };
        let data = |state: State| [state.x1, slope(state), bend(state)];
        let mut times: Vec<f64> = starts
            .iter()
            .zip(ends)
            .map(|(&start, &end)| Quintic::new(data(start), data(end), segment).first_rise(segment))
            .collect();
        for _ in 0..3 {
            let mut x1: Vec<f64> = starts.iter().map(|state| state.x1).collect();
            let mut x2: Vec<f64> = starts.iter().map(|state| state.x2).collect();
            self.flow.advance_each(&mut x1, &mut x2, &times)?;
            for ((time, &x1), &x2) in times.iter_mut().zip(&x1).zip(&x2) {
                let step = -x1 / slope(State { x1, x2 });
                *time = (*time + if step.is_finite() { step } else { 0.0 }).clamp(0.0, segment);
            }
        }
        Ok(times)
    }

    /// The probability of having passed by `time` from below.
    fn passed(&self, angles: &[f64], residences: &[f64], time: f64) -> Result<Quadrature, Escaped> {
        let on_circle = |from: f64, to: f64| {
            let below = self.measure.e_probability(self.measure.e_sigmas(self.e), Side::Below);
            below * self.measure.phi_between(principal(from), principal(from) + to - from)
        };
        let along =
            |curve: &(dyn Fn(f64) -> (State, f64) + Sync)| circulation(self.flow, &self.measure, Side::Below, curve);
        let touching = |phi: f64, residence: f64| {
            let touch = State { x1: 0.0, x2: self.e * phi.cos().signum() };
            let years = residence.min(time);
            if years > 0.0 { along(&|s| (touch, s * years)) } else { Ok(Quadrature::default()) }
        };
        let right = touching(PI, residences[SAMPLES])?;
        let left = touching(0.0, residences[0])?;
        let mut total = Quadrature { value: on_circle(0.0, PI), error: 0.0 }.plus(right).plus(left.times(-1.0));
        for (from, to, longer) in self.parts(angles, residences, time)? {
            total = total.plus(if longer {
                along(&|s| (State::from_polar(from + s * (to - from), self.e), time))?.times(-1.0)
            } else {
                Quadrature { value: on_circle(-to, -from), error: 0.0 }
            });
        }
        Ok(total)
    }

    /// The parts of `0..π` on which the residence is longer than `time`, or not.
    fn parts(&self, angles: &[f64], residences: &[f64], time: f64) -> Result<Vec<(f64, f64, bool)>, Escaped> {
        let longer: Vec<bool> = residences.iter().map(|&residence| residence > time).collect();
        let mut brackets: Vec<(f64, f64, bool)> = (0..SAMPLES)
            .filter(|&k| longer[k] != longer[k + 1])
            .map(|k| (angles[k], angles[k + 1], longer[k]))
            .collect();
        for _ in 0..if brackets.is_empty() { 0 } else { 46 } {
            let middles: Vec<f64> = brackets.iter().map(|&(low, high, _)| low.midpoint(high)).collect();
            // Slightly longer than `time`, so that a residence of just `time` is found.
            let residences = self.residences(&middles, time * 1.001)?;
            for ((bracket, middle), residence) in brackets.iter_mut().zip(middles).zip(residences) {
                if (residence > time) == bracket.2 { bracket.0 = middle } else { bracket.1 = middle }
            }
        }
        let mut from = 0.0;
        let mut parts = Vec::with_capacity(brackets.len() + 1);
        for (low, _, longer) in brackets {
            parts.push((from, low, longer));
            from = low;
        }
        parts.push((from, PI, longer[SAMPLES]));
        Ok(parts)
    }
}

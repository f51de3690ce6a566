//! Orbits recorded as the integrator's own Taylor series, step by step: dense output without further evaluations.

use super::taylor::{Crew, Lanes, Series, Watch};
use crate::dynamics::State;

/// Most coefficients of a series.
pub(crate) const COEFFICIENTS: usize = 19;

/// A step of an orbit as polynomials in the time since its start \[1/n_sun\].
#[derive(Debug, Clone)]
pub(crate) struct Step {
    /// How long the step is \[1/n_sun\].
    pub length: f64,
    x1: [f64; COEFFICIENTS],
    x2: [f64; COEFFICIENTS],
}

impl Step {
    /// The state `time` after the step's start.
    #[inline]
    pub fn at(&self, time: f64) -> State {
        let (mut x1, mut x2) = (0.0, 0.0);
        for (a, b) in self.x1.iter().zip(&self.x2).rev() {
            x1 = x1 * time + a;
            x2 = x2 * time + b;
        }
        State { x1, x2 }
    }
}

/// Keeps every step of every orbit.
pub(super) struct Recorder {
    /// The steps of each orbit.
    pub steps: Vec<Vec<Step>>,
}

impl Watch for Recorder {
    #[inline(never)]
    fn see<const P: usize>(&mut self, series: &Series<P>, lengths: &Lanes, crew: &Crew) {
        for (lane, &length) in lengths.iter().enumerate() {
            let Some(steps) = crew.orbit[lane].and_then(|orbit| self.steps.get_mut(orbit)) else { continue };
            if length > 0.0 {
                let (x1, x2) = series.coefficients(lane);
                steps.push(Step { length, x1, x2 });
            }
        }
    }
}

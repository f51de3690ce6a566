//! Orbits recorded as the integrator's own Taylor series, step by step: dense output without further evaluations.

use super::carry::{self, Watch};
use super::taylor::MOST_COEFFICIENTS;
use crate::model::plane::State;

/// A step of a planar orbit as polynomials in the time since its start \[1/n_sun\].
#[derive(Debug, Clone)]
pub(crate) struct Step {
    /// Length of the step \[1/n_sun\].
    pub length: f64,
    x1: [f64; MOST_COEFFICIENTS],
    x2: [f64; MOST_COEFFICIENTS],
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

/// Keeps every step of every planar orbit; the orbits run forwards.
pub(super) struct Recorder {
    /// The steps of each orbit.
    pub steps: Vec<Vec<Step>>,
}

impl Watch for Recorder {
    fn sees_clearance(&self) -> bool {
        false
    }

    fn see(&mut self, &carry::Step { coordinate, lengths, crew, .. }: &carry::Step<'_>) {
        let coefficients = |k: usize, lane: usize| {
            let mut coefficients = [0.0; MOST_COEFFICIENTS];
            coefficients.iter_mut().zip(coordinate(k)).for_each(|(coefficient, lanes)| *coefficient = lanes[lane]);
            coefficients
        };
        for (lane, &length) in lengths.iter().enumerate() {
            let Some(steps) = crew.orbit[lane].and_then(|orbit| self.steps.get_mut(orbit)) else { continue };
            if length > 0.0 {
                steps.push(Step { length, x1: coefficients(0, lane), x2: coefficients(1, lane) });
            }
        }
    }
}

//! The steps of one orbit by the method of Dormand and Prince, and the polynomial that each of them leaves behind.

use super::dormand_prince::{ERRORS, INTERPOLATION, STAGES, TIMES, WEIGHTS, WITH_INTERPOLATION};
use crate::model::earth::SUN_MEAN_MOTION;
use crate::model::{Coordinates, Model};

/// Most coordinates of a state.
pub(super) const MOST: usize = 8;
/// Number of coefficients of the interpolating polynomial.
pub(super) const COEFFICIENTS: usize = 8;
/// How many times longer or shorter than the last step the next one may be, and the share of the estimated step that is
/// taken.
const LONGER: f64 = 6.0;
const SHORTER: f64 = 0.1;
const SAFETY: f64 = 0.9;
/// First attempt at a step \[1/n_sun\].
const FIRST: f64 = 0.02;
/// A step below this share of the time that is left makes no progress \[1/n_sun\].
const LEAST: f64 = 1e-15;

/// A state or a rate, by its coordinates.
pub(super) type Vector = [f64; MOST];

/// A model with edges, at which its rate is continuous but not smooth.
pub trait Edged: Model {
    /// A time \[yr\] within which the orbit does not come to an edge and leave it again, forwards or backwards;
    /// never 0. A step that found no sign of an edge may still have jumped over one, there and back; within this time
    /// none can be reached.
    fn free_time(&self, time: f64, state: Self::State<f64>) -> f64;
}

/// An orbit on its way.
#[derive(Debug, Clone)]
pub(super) struct OrbitOnItsWay<M> {
    pub(super) model: M,
    /// \[yr\]
    pub(super) time: f64,
    /// Time to go \[1/n_sun\], and -1 if backwards.
    pub(super) left: f64,
    pub(super) sign: f64,
    pub(super) state: Vector,
    /// The rates of the stages of the step under way; the first is that of the state.
    rates: [Vector; WITH_INTERPOLATION],
    pub(super) has_rate: bool,
    /// The step under way, the state at its end, and the length to be tried next.
    pub(super) step: f64,
    end: Vector,
    next: f64,
    pub(super) steps: f64,
    pub(super) allowed: f64,
}

impl<M: Edged> OrbitOnItsWay<M> {
    /// An orbit that has nowhere to go yet.
    pub(super) fn at_rest(model: M, time: f64, state: Vector) -> Self {
        Self {
            model,
            time,
            left: 0.0,
            sign: 1.0,
            state,
            rates: [[0.0; MOST]; WITH_INTERPOLATION],
            has_rate: false,
            step: 0.0,
            end: [0.0; MOST],
            next: FIRST,
            steps: 0.0,
            allowed: 0.0,
        }
    }

    fn count() -> usize {
        M::State::<f64>::COUNT
    }

    /// The rate \[n_sun\] at a time since the start of the step.
    fn rate(&self, since: f64, state: &Vector) -> Vector {
        let time = self.time + self.sign * since / SUN_MEAN_MOTION;
        let rate = self.model.rate(time, Coordinates::from_fn(|k| state[k]));
        std::array::from_fn(|k| if k < Self::count() { rate.component(k) / SUN_MEAN_MOTION } else { 0.0 })
    }

    /// A sum of rates with these weights.
    fn sum(&self, weights: &[(usize, f64)]) -> Vector {
        let mut sum = [0.0; MOST];
        for &(stage, weight) in weights {
            for (sum, rate) in sum.iter_mut().zip(&self.rates[stage]) {
                *sum = weight.mul_add(*rate, *sum);
            }
        }
        sum
    }

    /// The state after a sum of rates over a step of this length.
    fn moved(&self, weights: &[(usize, f64)], length: f64) -> Vector {
        let sum = self.sum(weights);
        std::array::from_fn(|k| (self.sign * length).mul_add(sum[k], self.state[k]))
    }

    /// Computes a stage of a step of this length.
    fn stage(&mut self, stage: usize, length: f64) {
        let state = self.moved(WEIGHTS[stage], length);
        self.rates[stage] = self.rate(TIMES[stage] * length, &state);
    }

    /// Finds a step whose error is below the tolerance.
    pub(super) fn find_step(&mut self, tolerance: f64) {
        self.step = 0.0;
        if self.left <= 0.0 {
            return;
        }
        if !self.has_rate {
            self.rates[0] = self.rate(0.0, &self.state);
            self.has_rate = true;
        }
        let free = SUN_MEAN_MOTION * self.model.free_time(self.time, Coordinates::from_fn(|k| self.state[k]));
        let mut length = self.next.min(free).min(self.left);
        loop {
            (1..STAGES).for_each(|stage| self.stage(stage, length));
            let error = self.error(length) / tolerance;
            // The error of a step grows with the eighth power of its length.
            let factor = (SAFETY * libm::pow(error.max(1e-30), -0.125)).clamp(SHORTER, LONGER);
            if error <= 1.0 {
                self.end = self.moved(WEIGHTS[STAGES], length);
                self.step = length;
                // A step that was cut short says little about the next.
                self.next = if length < self.next { self.next.max(factor * length) } else { factor * length };
                return;
            }
            length *= if error.is_nan() { SHORTER } else { factor.min(1.0) };
            self.next = length;
            if length < LEAST * self.left.max(1.0) {
                // No step is short enough: the orbit is where its equations do not hold.
                self.end = [f64::NAN; MOST];
                self.step = self.left;
                return;
            }
        }
    }

    /// The estimated error of a step of this length.
    fn error(&self, length: f64) -> f64 {
        let [fifth, third] = ERRORS.map(|weights| {
            let sum = self.sum(weights);
            // `max` would hide a NaN.
            sum.iter().fold(0.0, |largest: f64, x| if x.abs() <= largest { largest } else { x.abs() })
        });
        if fifth == 0.0 { 0.0 } else { length * fifth * fifth / (fifth * fifth + 0.01 * third * third).sqrt() }
    }

    /// The polynomial of the step, by its coefficients per `1/n_sun`.
    pub(super) fn polynomial(&mut self) -> [Vector; COEFFICIENTS] {
        let (length, count) = (self.step, Self::count());
        self.rates[STAGES] = self.rate(length, &self.end);
        (STAGES + 1..WITH_INTERPOLATION).for_each(|stage| self.stage(stage, length));
        let signed = self.sign * length;
        let highest = INTERPOLATION.map(|weights| self.sum(weights));
        let mut coefficients = [[0.0; MOST]; COEFFICIENTS];
        for k in 0..count {
            let (first, last) = (signed * self.rates[0][k], signed * self.rates[STAGES][k]);
            let whole = self.end[k] - self.state[k];
            let terms = [whole, first - whole, 2.0 * whole - (first + last)];
            let terms: [f64; 7] = std::array::from_fn(|n| if n < 3 { terms[n] } else { signed * highest[n - 3][k] });
            // Nested: y = y_0 + x (F_0 + (1 - x) (F_1 + x (F_2 + ...))).
            let mut polynomial = [0.0; COEFFICIENTS];
            for (n, term) in terms.into_iter().enumerate().rev() {
                polynomial[0] += term;
                let before = polynomial;
                for m in 0..COEFFICIENTS {
                    let shifted = if m > 0 { before[m - 1] } else { 0.0 };
                    polynomial[m] = if n % 2 == 0 { shifted } else { before[m] - shifted };
                }
            }
            polynomial[0] += self.state[k];
            let mut power = 1.0;
            for (coefficient, value) in coefficients.iter_mut().zip(polynomial) {
                coefficient[k] = value * power;
                power /= signed;
            }
        }
        coefficients
    }

    /// Moves by a step, which is the one that was found unless something else ends it.
    pub(super) fn move_on(&mut self, step: f64) {
        let length = step.abs();
        if length == 0.0 {
            return;
        }
        self.state = if length == self.step { self.end } else { self.moved(WEIGHTS[STAGES], length) };
        self.left -= length;
        self.time += step / SUN_MEAN_MOTION;
        self.steps += 1.0;
        self.has_rate = false;
    }
}

//! Steps of models whose equations of motion are not smooth: an explicit Runge-Kutta method in the place of a Taylor
//! series.
//!
//! Where an orbit begins to touch the Earth's shadow its averaged equations have a kink like a square root, at which a
//! Taylor series ends. The method of order 8 by Dormand and Prince needs nothing but the rate, and its error estimate
//! shortens the step until it is over the kink (Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I,
//! 2nd ed., 1993, Sect. II.4 to II.6). A step that found no sign of an edge may still have jumped over one, there and
//! back; so the model bounds the time in which none can be reached ([`Edged::free_time`]).
//!
//! The result is a [`Series`] like those of smooth models: its coefficients are those of the interpolating polynomial
//! of the step, of order 7.

use super::dormand_prince::{ERRORS, INTERPOLATION, STAGES, TIMES, WEIGHTS, WITH_INTERPOLATION};
use crate::model::earth::SUN_MEAN_MOTION;
use crate::model::{Coordinates, LANES, Lanes, Model, Series};

/// Most coordinates of a state.
const MOST: usize = 8;
/// Number of coefficients of the interpolating polynomial.
const COEFFICIENTS: usize = 8;
/// How many times longer or shorter than the last step the next one may be, and the share of the estimated step that is
/// taken.
const LONGER: f64 = 6.0;
const SHORTER: f64 = 0.1;
const SAFETY: f64 = 0.9;
/// First attempt at a step \[1/n_sun\].
const FIRST: f64 = 0.02;
/// A step below this share of the time that is left makes no progress \[1/n_sun\].
const LEAST: f64 = 1e-15;
/// Number of steps, and more for each year, of which many may be tiny.
const CREEPING: f64 = 20_000.0;

/// A state or a rate, by its coordinates.
type Vector = [f64; MOST];

/// A model with edges, at which its rate is continuous but not smooth.
pub trait Edged: Model {
    /// A time \[yr\] within which the orbit does not come to an edge and leave it again, forwards or backwards;
    /// never 0.
    fn free_time(&self, time: f64, state: Self::State<f64>) -> f64;
}

/// Steps of [`LANES`] orbits of a model.
#[derive(Debug)]
pub struct RungeKutta<M, const P: usize> {
    lanes: Vec<Lane<M>>,
    tolerance: f64,
    coordinates: Vec<[Lanes; P]>,
    clearance: [Lanes; P],
}

/// An orbit on its way.
#[derive(Debug, Clone)]
struct Lane<M> {
    model: M,
    /// \[yr\]
    time: f64,
    /// Time to go \[1/n_sun\], and -1 if backwards.
    left: f64,
    sign: f64,
    state: Vector,
    /// The rates of the stages of the step under way; the first is that of the state.
    rates: [Vector; WITH_INTERPOLATION],
    has_rate: bool,
    /// The step under way, the state at its end, and the length to be tried next.
    step: f64,
    end: Vector,
    next: f64,
    steps: f64,
    allowed: f64,
}

impl<M: Edged> Lane<M> {
    fn at_rest(model: &M) -> Self {
        Self {
            model: *model,
            time: 0.0,
            left: 0.0,
            sign: 1.0,
            state: [0.0; MOST],
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
    fn find_step(&mut self, tolerance: f64) {
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
    fn polynomial(&mut self) -> [Vector; COEFFICIENTS] {
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
    fn move_on(&mut self, step: f64) {
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

/// The local error that is allowed in a step, where a Taylor series of the same accuracy has this number of
/// coefficients.
fn tolerance(coefficients: usize) -> f64 {
    match coefficients {
        ..=12 => 3e-9,
        13..=15 => 1e-12,
        _ => 1e-14,
    }
}

impl<M: Edged, const P: usize> RungeKutta<M, P> {
    /// Replaces the model of one lane.
    pub(crate) fn replace(&mut self, lane: usize, change: impl FnOnce(&mut M)) {
        change(&mut self.lanes[lane].model);
        self.lanes[lane].has_rate = false;
    }

    /// Writes the clearance of a lane that does not move.
    fn write_at_rest(&mut self, lane: usize) {
        let own = &self.lanes[lane];
        let clearance = own.model.clearance(M::State::<f64>::from_fn(|k| own.state[k]));
        for (n, coefficients) in self.clearance.iter_mut().enumerate() {
            coefficients[lane] = if n == 0 { clearance } else { 0.0 };
        }
    }

    /// Writes the polynomial of a lane's step, and that of the clearance.
    fn write(&mut self, lane: usize) {
        let own = &mut self.lanes[lane];
        let polynomial = own.polynomial();
        let step = own.sign * own.step;
        for (n, coefficients) in polynomial.iter().enumerate() {
            for (k, coordinate) in self.coordinates.iter_mut().enumerate() {
                coordinate[n][lane] = coefficients[k];
            }
        }
        let at = |share: f64| {
            let since = share * step;
            let value = |k: usize| polynomial.iter().rev().fold(0.0f64, |sum, c| sum.mul_add(since, c[k]));
            own.model.clearance(M::State::<f64>::from_fn(value))
        };
        for (n, coefficient) in through_nodes(at).into_iter().enumerate() {
            self.clearance[n][lane] = coefficient / step.powi(n as i32);
        }
    }
}

/// The coefficients of the polynomial that agrees with a function on `[0, 1]` at as many nodes as it has coefficients:
/// Newton's divided differences at Chebyshev's nodes.
fn through_nodes(value: impl Fn(f64) -> f64) -> [f64; COEFFICIENTS] {
    let angle = |k: usize| std::f64::consts::PI * (k as f64 + 0.5) / COEFFICIENTS as f64;
    let nodes: [f64; COEFFICIENTS] = std::array::from_fn(|k| 0.5 - 0.5 * libm::cos(angle(k)));
    let mut differences = nodes.map(value);
    for order in 1..COEFFICIENTS {
        for k in (order..COEFFICIENTS).rev() {
            differences[k] = (differences[k] - differences[k - 1]) / (nodes[k] - nodes[k - order]);
        }
    }
    let mut polynomial = [0.0; COEFFICIENTS];
    for k in (0..COEFFICIENTS).rev() {
        let before = polynomial;
        for m in 0..COEFFICIENTS {
            polynomial[m] = if m > 0 { before[m - 1] } else { 0.0 } - nodes[k] * before[m];
        }
        polynomial[0] += differences[k];
    }
    polynomial
}

impl<M: Edged + Model, const P: usize> Series<P> for RungeKutta<M, P> {
    type Model = M;

    fn new(model: &M) -> Self {
        let zero = [[0.0; LANES]; P];
        Self {
            lanes: vec![Lane::at_rest(model); LANES],
            tolerance: tolerance(P),
            coordinates: vec![zero; M::State::<f64>::COUNT],
            clearance: zero,
        }
    }

    fn start(&mut self, lane: usize, state: M::State<f64>, time: f64) {
        let model = self.lanes[lane].model;
        let state = std::array::from_fn(|k| if k < M::State::<f64>::COUNT { state.component(k) } else { 0.0 });
        self.lanes[lane] = Lane { time, state, ..Lane::at_rest(&model) };
        for (coordinate, value) in self.coordinates.iter_mut().zip(state) {
            coordinate[0][lane] = value;
        }
    }

    fn head_for(&mut self, lane: usize, years: f64) {
        let own = &mut self.lanes[lane];
        (own.left, own.sign) = (SUN_MEAN_MOTION * years.abs(), years.signum());
        own.allowed = CREEPING * (1.0 + years.abs());
    }

    fn expand(&mut self, with_clearance: bool) {
        for lane in 0..LANES {
            self.lanes[lane].find_step(self.tolerance);
            if with_clearance && self.lanes[lane].step > 0.0 {
                self.write(lane);
            } else if with_clearance {
                self.write_at_rest(lane);
            }
        }
    }

    fn shorten(&mut self, planned: Lanes) -> Lanes {
        std::array::from_fn(|lane| planned[lane].min(self.lanes[lane].step))
    }

    fn may_creep(&self, lane: usize) -> bool {
        self.lanes[lane].steps < self.lanes[lane].allowed
    }

    fn move_on(&mut self, steps: &Lanes) {
        for (lane, (own, &step)) in self.lanes.iter_mut().zip(steps).enumerate() {
            own.move_on(step);
            for (coordinate, value) in self.coordinates.iter_mut().zip(own.state) {
                coordinate[0][lane] = value;
            }
        }
    }

    fn is_inside(&self, lane: usize) -> bool {
        let own = &self.lanes[lane];
        let state = M::State::<f64>::from_fn(|k| own.state[k]);
        (0..M::State::<f64>::COUNT).all(|k| state.component(k).is_finite()) && own.model.is_inside(state)
    }

    fn coordinate(&self, k: usize) -> &[Lanes; P] {
        &self.coordinates[k]
    }

    fn clearance(&self) -> &[Lanes; P] {
        &self.clearance
    }
}

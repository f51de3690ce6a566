//! Steps of models whose equations of motion are not smooth: an explicit Runge-Kutta method in the place of a Taylor
//! series.
//!
//! Where an orbit begins to touch the Earth's shadow its averaged equations have a kink like a square root, at which a
//! Taylor series ends. The method of order 8 by Dormand and Prince needs nothing but the rate, and its error estimate
//! shortens the step until it is over the kink (Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I,
//! 2nd ed., 1993, Sect. II.4 to II.6). [`one_orbit`] has the steps of a single orbit; here [`LANES`] of them stand side
//! by side.
//!
//! The result is a [`Series`] like those of smooth models: its coefficients are those of the interpolating polynomial
//! of the step, of order 7.

mod dormand_prince;
mod one_orbit;

use one_orbit::{COEFFICIENTS, MOST, OrbitOnItsWay};

use crate::model::earth::SUN_MEAN_MOTION;
use crate::model::{Coordinates, LANES, Lanes, Model, Series};

pub use one_orbit::Edged;

/// Number of steps, and more for each year, of which many may be tiny.
const CREEPING: f64 = 20_000.0;

/// Steps of [`LANES`] orbits of a model.
#[derive(Debug)]
pub struct RungeKutta<M, const P: usize> {
    lanes: Vec<OrbitOnItsWay<M>>,
    tolerance: f64,
    coordinates: Vec<[Lanes; P]>,
    clearance: [Lanes; P],
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
            lanes: vec![OrbitOnItsWay::at_rest(*model, 0.0, [0.0; MOST]); LANES],
            tolerance: tolerance(P),
            coordinates: vec![zero; M::State::<f64>::COUNT],
            clearance: zero,
        }
    }

    fn start(&mut self, lane: usize, state: M::State<f64>, time: f64) {
        let model = self.lanes[lane].model;
        let state = std::array::from_fn(|k| if k < M::State::<f64>::COUNT { state.component(k) } else { 0.0 });
        self.lanes[lane] = OrbitOnItsWay::at_rest(model, time, state);
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

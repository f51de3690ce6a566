//! Taylor series of a model's orbits, expanded by the operations that its equations are made of ([`super::equations`]).

use std::ops::Range;

use super::equations::{Operation, Outcome, Recorder, Slot, Term};
use crate::model::earth::SUN_MEAN_MOTION;
use crate::model::{Coordinates, LANES, Lanes, Model, Series};

/// The series of any model, made from [`Model::rate`] and [`Model::clearance`].
///
/// The first slot is the time \[yr\]; then come the coordinates, the operations of the rate and the operations of the
/// clearance.
#[derive(Debug)]
pub struct FromEquations<M, const P: usize> {
    model: M,
    coordinates: usize,
    /// The operations of the rate, then those of the clearance.
    operations: Vec<Operation>,
    of_rate: usize,
    rate: Vec<Outcome>,
    clearance: Slot,
    slots: Vec<Coefficients<P>>,
}

/// Taylor coefficients of a quantity, aligned to cache lines.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Coefficients<const P: usize>([Lanes; P]);

/// The slot of the time.
const TIME: Slot = 0;

impl<M: Model, const P: usize> Series<P> for FromEquations<M, P> {
    type Model = M;

    #[inline(always)]
    fn new(model: &M) -> Self {
        Self::record(model)
    }

    #[inline(always)]
    fn start(&mut self, lane: usize, state: M::State<f64>, time: f64) {
        self.slots[TIME].0[0][lane] = time;
        for k in 0..self.coordinates {
            self.slots[1 + k].0[0][lane] = state.component(k);
        }
    }

    #[inline(always)]
    fn expand(&mut self, with_clearance: bool) {
        for n in 0..P - 1 {
            self.expand_operations(0..self.of_rate, n);
            let per_order = 1.0 / (SUN_MEAN_MOTION * (n + 1) as f64);
            for k in 0..self.coordinates {
                self.slots[1 + k].0[n + 1] = match self.rate[k] {
                    Outcome::In(slot) => self.slots[slot].0[n].map(|rate| per_order * rate),
                    Outcome::Number(rate) => [if n == 0 { per_order * rate } else { 0.0 }; LANES],
                };
            }
        }
        if with_clearance {
            (0..P).for_each(|n| self.expand_operations(self.of_rate..self.operations.len(), n));
        }
    }

    #[inline(always)]
    fn move_on(&mut self, steps: &Lanes) {
        for (time, step) in self.slots[TIME].0[0].iter_mut().zip(steps) {
            *time += step / SUN_MEAN_MOTION;
        }
        for Coefficients(x) in &mut self.slots[1..=self.coordinates] {
            let mut sum = x[P - 1];
            for n in (0..P - 1).rev() {
                for l in 0..LANES {
                    sum[l] = sum[l].mul_add(steps[l], x[n][l]);
                }
            }
            x[0] = sum;
        }
    }

    #[inline(always)]
    fn is_inside(&self, lane: usize) -> bool {
        let state = M::State::<f64>::from_fn(|k| self.slots[1 + k].0[0][lane]);
        (0..self.coordinates).all(|k| state.component(k).is_finite()) && self.model.is_inside(state)
    }

    #[inline(always)]
    fn coordinate(&self, k: usize) -> &[Lanes; P] {
        &self.slots[1 + k].0
    }

    #[inline(always)]
    fn clearance(&self) -> &[Lanes; P] {
        &self.slots[self.clearance].0
    }
}

impl<M: Model, const P: usize> FromEquations<M, P> {
    /// Records the operations of a model's equations.
    fn record(model: &M) -> Self {
        let coordinates = M::State::<f64>::COUNT;
        let recorder = Recorder::new(1 + coordinates);
        let state = M::State::<Term<'_>>::from_fn(|k| recorder.input(1 + k));
        let rate = model.rate(recorder.input(TIME), state);
        let rate: Vec<Outcome> = (0..coordinates).map(|k| rate.component(k).outcome()).collect();
        let of_rate = recorder.len();
        let clearance = match model.clearance(state).outcome() {
            Outcome::In(slot) => slot,
            Outcome::Number(constant) => recorder.slot(recorder.input(TIME) * 0.0 + constant),
        };
        let operations = recorder.into_operations();
        let mut slots = vec![Coefficients([[0.0; LANES]; P]); 1 + coordinates + operations.len()];
        slots[TIME].0[1] = [1.0 / SUN_MEAN_MOTION; LANES];
        Self { model: *model, coordinates, operations, of_rate, rate, clearance, slots }
    }

    /// Computes the coefficients of order `n` of some operations.
    #[inline(always)]
    fn expand_operations(&mut self, range: Range<usize>, n: usize) {
        let first = 1 + self.coordinates;
        for k in range {
            let (operands, results) = self.slots.split_at_mut(first + k);
            results[0].0[n] = expand_one(self.operations[k], operands, results, n);
        }
    }
}

/// The coefficient of order `n` of the result of an operation (the first of `results`), from the coefficients of its
/// operands and the lower coefficients of the result.
#[inline(always)]
fn expand_one<const P: usize>(
    operation: Operation,
    operands: &[Coefficients<P>],
    results: &[Coefficients<P>],
    n: usize,
) -> Lanes {
    let of = |slot: Slot| &operands[slot].0;
    let own = &results[0].0;
    match operation {
        Operation::Sum(a, b) => each(&of(a)[n], &of(b)[n], |a, b| a + b),
        Operation::Difference(a, b) => each(&of(a)[n], &of(b)[n], |a, b| a - b),
        Operation::Scaled(a, factor) => each(&of(a)[n], &of(a)[n], |a, _| factor * a),
        Operation::Shifted(a, number) if n == 0 => each(&of(a)[0], &of(a)[0], |a, _| a + number),
        Operation::Shifted(a, _) => of(a)[n],
        Operation::Product(a, b) => convolution(of(a), of(b), 0..n + 1, n),
        Operation::Quotient(a, b) => {
            let rest = each(&of(a)[n], &convolution(of(b), own, 1..n + 1, n), |a, sum| a - sum);
            each(&rest, &of(b)[0], |rest, b| rest / b)
        }
        Operation::Inverse(number, b) if n == 0 => each(&of(b)[0], &of(b)[0], |b, _| number / b),
        Operation::Inverse(_, b) => each(&convolution(of(b), own, 1..n + 1, n), &of(b)[0], |sum, b| -sum / b),
        Operation::Root(a) if n == 0 => each(&of(a)[0], &of(a)[0], |a, _| a.sqrt()),
        Operation::Root(a) => {
            let rest = each(&of(a)[n], &convolution(own, own, 1..n, n), |a, sum| a - sum);
            each(&rest, &own[0], |rest, root| 0.5 * rest / root)
        }
        Operation::Sine(a) if n == 0 => each(&of(a)[0], &of(a)[0], |a, _| libm::sin(a)),
        Operation::Cosine(a) if n == 0 => each(&of(a)[0], &of(a)[0], |a, _| libm::cos(a)),
        // The cosine is in the slot after the sine and has already been expanded to order n - 1.
        Operation::Sine(a) => weighted_convolution(of(a), &results[1].0, 1.0 / n as f64, n),
        Operation::Cosine(a) => weighted_convolution(of(a), of(operands.len() - 1), -1.0 / n as f64, n),
    }
}

/// A function of two numbers in every lane.
#[inline(always)]
fn each(a: &Lanes, b: &Lanes, function: impl Fn(f64, f64) -> f64) -> Lanes {
    let mut values = [0.0; LANES];
    for l in 0..LANES {
        values[l] = function(a[l], b[l]);
    }
    values
}

/// `Σ a_j b_{n-j}` over a range of `j`.
#[inline(always)]
fn convolution<const P: usize>(a: &[Lanes; P], b: &[Lanes; P], range: Range<usize>, n: usize) -> Lanes {
    let mut sum = [0.0; LANES];
    for j in range {
        for l in 0..LANES {
            sum[l] = a[j][l].mul_add(b[n - j][l], sum[l]);
        }
    }
    sum
}

/// `factor Σ_{j=1..n} j a_j b_{n-j}`.
#[inline(always)]
fn weighted_convolution<const P: usize>(a: &[Lanes; P], b: &[Lanes; P], factor: f64, n: usize) -> Lanes {
    let mut sum = [0.0; LANES];
    for j in 1..=n {
        let weight = factor * j as f64;
        for l in 0..LANES {
            sum[l] = (weight * a[j][l]).mul_add(b[n - j][l], sum[l]);
        }
    }
    sum
}

#[cfg(test)]
mod tests;

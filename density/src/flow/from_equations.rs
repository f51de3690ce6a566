//! Taylor series of a model's orbits, expanded by the operations that its equations are made of ([`super::equations`]).

use std::ops::Range;

use super::equations::{Operation, Outcome, Recorder, Slot, Term};
use super::series::Series;
use super::taylor::{LANES, Lanes};
use crate::model::earth::SUN_MEAN_MOTION;
use crate::model::{Coordinates, Model};

/// The series of any model, made from [`Model::rate`] and [`Model::clearance`].
///
/// The first slot is the time \[yr\], then come the coordinates, the operations of the rate and those of the clearance.
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
        for l in 0..LANES {
            self.slots[TIME].0[0][l] += steps[l] / SUN_MEAN_MOTION;
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

    /// The coefficients of order `n` of some operations.
    #[inline(always)]
    fn expand_operations(&mut self, range: Range<usize>, n: usize) {
        let first = 1 + self.coordinates;
        for k in range {
            let (operands, results) = self.slots.split_at_mut(first + k);
            results[0].0[n] = expand_one(self.operations[k], operands, results, n);
        }
    }
}

/// The coefficient of order `n` of the result of an operation, the first of `results`, from those of its operands and its own lower
/// ones.
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
        // The cosine stands in the slot after the sine, which has been expanded one order further.
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
mod tests {
    use super::*;
    use crate::flow::Flow;
    use crate::model::planar::Force;
    use crate::model::plane::{PlanarHamiltonian, State};
    use crate::model::{Kind, Quantity, Variable};

    /// The paper's model without its own recurrence.
    #[derive(Debug, Clone, Copy, PartialEq)]
    struct ByEquations(Force);

    impl PlanarHamiltonian for ByEquations {
        type Series<const P: usize> = FromEquations<Self, P>;

        fn motion<T: Quantity>(&self, state: State<T>) -> State<T> {
            self.0.motion(state)
        }

        fn hamiltonian(&self, state: State) -> f64 {
            self.0.hamiltonian(state)
        }

        fn hamiltonian_range(&self, phi: (f64, f64), e: (f64, f64)) -> (f64, f64) {
            self.0.hamiltonian_range(phi, e)
        }

        fn pull(&self) -> f64 {
            self.0.pull()
        }

        fn turning_rate(&self, state: State) -> f64 {
            self.0.turning_rate(state)
        }

        fn eccentricity_follows_x1(&self) -> bool {
            true
        }
    }

    #[test]
    fn the_papers_model_moves_alike_by_its_equations_and_by_its_own_recurrence() {
        let force = Force { radiation: 0.15, oblateness: 0.40921 };
        for (phi, e) in [(2.2069, 0.145), (0.3, 0.0), (4.0, 0.6)] {
            let start = State::from_polar(phi, e);
            for years in [2.0, -2.0] {
                let by_hand = Flow::new(force).advance_one(start, years).unwrap();
                let by_equations = Flow::new(ByEquations(force)).advance_one(start, years).unwrap();
                let apart = (by_hand.x1 - by_equations.x1).hypot(by_hand.x2 - by_equations.x2);
                assert!(apart < 1e-12, "{phi} {e} {years}: {apart:e}");
            }
        }
    }

    #[test]
    fn what_follows_from_the_equations_is_what_a_planar_model_says_of_itself() {
        let force = Force { radiation: 0.15, oblateness: 0.40921 };
        for (phi, e) in [(2.2069, 0.145), (0.3, 1e-3), (4.0, 0.6)] {
            let state = State::from_polar(phi, e);
            let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-10 * (1.0 + b.abs()), "{a} {b}");
            let (own, followed) = (force.polar_rates(phi, e), ByEquations(force).polar_rates(phi, e));
            close(followed.0, own.0);
            close(followed.1, own.1);
            let (own, followed) =
                (force.eccentricity_squared_rates(state), ByEquations(force).eccentricity_squared_rates(state));
            own.into_iter().zip(followed).for_each(|(own, followed)| close(followed, own));
            close(ByEquations(force).slope_on_axis(state.x2), force.slope_on_axis(state.x2));
        }
    }

    /// `x = sin(n t + a)`, `y = sqrt(y_0² + t)`: a model that has no Hamiltonian and depends on time.
    #[derive(Debug, Clone, Copy, PartialEq)]
    struct Clockwork {
        n: f64,
        a: f64,
    }

    impl Model for Clockwork {
        type State<T: Quantity> = [T; 2];
        type Variables = [f64; 2];
        type Series<const P: usize> = FromEquations<Self, P>;

        const VARIABLES: &'static [Variable] =
            &[Variable { name: "position", symbol: "x", unit: "", kind: Kind::Interval { low: -1e9, high: 1e9 } }; 2];
        const REENTRY: usize = 1;

        fn rate<T: Quantity>(&self, time: T, [_, y]: [T; 2]) -> [T; 2] {
            let (sin, cos) = (time * self.n + self.a).sin_cos();
            [cos * self.n * (sin * sin + cos * cos), T::from(0.5) / y + (y - y * y / y)]
        }

        fn is_inside(&self, _: [f64; 2]) -> bool {
            true
        }

        fn state(&self, _: f64, variables: [f64; 2]) -> [f64; 2] {
            variables
        }

        fn read_out(&self, _: f64, state: [f64; 2]) -> [f64; 2] {
            state
        }

        fn clearance<T: Quantity>(&self, [_, y]: [T; 2]) -> T {
            T::from(9.0) - y.powi(3)
        }

        fn critical_clearance(&self, critical: f64) -> f64 {
            9.0 - critical.powi(3)
        }
    }

    #[test]
    fn a_model_that_depends_on_time_is_followed_forwards_and_backwards_from_any_time() {
        let flow = Flow::new(Clockwork { n: 7.0, a: 0.4 });
        let x = |time: f64| (7.0 * time + 0.4).sin();
        for (from, to) in [(0.0, 2.0), (1.5, 3.0), (3.0, 0.5)] {
            let [end, root] = flow.carry_one([x(from), 2.0], from, to).unwrap();
            assert!((end - x(to)).abs() < 1e-12, "{from} {to}: {end}");
            assert!((root - (4.0 + to - from).sqrt()).abs() < 1e-12, "{root}");
        }
    }

    #[test]
    fn a_passage_is_where_the_re_entry_variable_reaches_its_critical_value() {
        let flow = Flow::new(Clockwork { n: 7.0, a: 0.4 });
        let mut times = [f64::INFINITY; 3];
        let passages = crate::flow::Passages { passages: &mut times, pending: f64::INFINITY, note: &|time| time };
        let (mut x, mut y) = ([0.0; 3], [1.0, 1.5, 0.5]);
        flow.carry_watching(&mut [&mut x, &mut y], (1.0, 2.0), 1.4, passages).unwrap();
        assert!((times[0] - (1.0 + 1.4 * 1.4 - 1.0)).abs() < 1e-12, "{times:?}");
        assert_eq!(times[1..], [1.0, f64::INFINITY]);
    }
}

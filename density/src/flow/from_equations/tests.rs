//! Series made from equations, compared with a recurrence written by hand and with closed forms.

use super::*;
use crate::flow::Flow;
use crate::model::planar::SrpJ2;
use crate::model::plane::{PlanarHamiltonian, State};
use crate::model::{Kind, Quantity, Variable};

/// The paper's model without its own recurrence.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ByEquations(SrpJ2);

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
    let force = SrpJ2 { radiation: 0.15, oblateness: 0.40921 };
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
    let force = SrpJ2 { radiation: 0.15, oblateness: 0.40921 };
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

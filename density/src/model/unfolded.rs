//! A model in space for clouds whose inclination may be below 0: what methods take that place points in a Gaussian
//! themselves.
//!
//! The Gaussian of a cloud in space reaches below `i = 0` without a cut, since `(phi, -i, node)` is the orbit `(phi, i,
//! node + π)` ([`crate::in_space`]), and the vectors of the orbit are smooth functions of all its variables. Here the
//! inclination is therefore a variable without a bound at 0. Orbits are read out as everywhere, with an inclination of
//! 0 or more.

use super::irradiated::{Irradiated, WithRadiation};
use super::uncertain_radiation::Scale;
use super::vectorial::{VARIABLES, Vectorial};
use super::{Coordinates, Kind, Lanes, Model, Quantity, Task, Variable};
use crate::flow::FromEquations;
use crate::flow::carry::{Carry, Loss};

/// The variables of a cloud in space, with an inclination that may be negative.
const WITHOUT_BOUND: [Variable; 4] = [
    VARIABLES[0],
    VARIABLES[1],
    Variable { kind: Kind::Interval { low: -std::f64::consts::PI, high: std::f64::consts::PI }, ..VARIABLES[2] },
    VARIABLES[3],
];

/// A model in space with `N` variables.
pub trait InSpace<const N: usize>: Model {
    /// Its variables, where the inclination may be negative.
    const UNFOLDED: &'static [Variable];
}

impl InSpace<4> for Vectorial {
    const UNFOLDED: &'static [Variable] = &WITHOUT_BOUND;
}

impl<S: Scale> InSpace<5> for WithRadiation<Vectorial, S>
where
    Vectorial: Irradiated<S>,
{
    const UNFOLDED: &'static [Variable] =
        &[WITHOUT_BOUND[0], WITHOUT_BOUND[1], WITHOUT_BOUND[2], WITHOUT_BOUND[3], S::VARIABLE];
}

/// The model, with its variables as an array.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unfolded<M, const N: usize>(pub M);

impl<M: InSpace<N>, const N: usize> Model for Unfolded<M, N> {
    type State<T: Quantity> = M::State<T>;
    type Variables = [f64; N];
    type Series<const P: usize> = FromEquations<Self, P>;

    const VARIABLES: &'static [Variable] = M::UNFOLDED;
    const REENTRY: usize = M::REENTRY;

    fn rate<T: Quantity>(&self, time: T, state: M::State<T>) -> M::State<T> {
        self.0.rate(time, state)
    }

    fn is_inside(&self, state: M::State<f64>) -> bool {
        self.0.is_inside(state)
    }

    fn state(&self, time: f64, variables: [f64; N]) -> M::State<f64> {
        self.0.state(time, Coordinates::from_fn(|k| variables[k]))
    }

    fn read_out(&self, time: f64, state: M::State<f64>) -> [f64; N] {
        let variables = self.0.read_out(time, state);
        std::array::from_fn(|k| variables.component(k))
    }

    fn read_out_lanes(&self, time: f64, states: &[Lanes], variables: &mut [Lanes]) {
        self.0.read_out_lanes(time, states, variables);
    }

    fn clearance<T: Quantity>(&self, state: M::State<T>) -> T {
        self.0.clearance(state)
    }

    fn critical_clearance(&self, critical: f64) -> f64 {
        self.0.critical_clearance(critical)
    }

    fn density_growth(&self, start: M::State<f64>, end: M::State<f64>) -> Option<f64> {
        self.0.density_growth(start, end)
    }

    fn conserved(&self, time: f64, state: M::State<f64>) -> Vec<(&'static str, f64)> {
        self.0.conserved(time, state)
    }

    /// Hands the task to the model itself, whose states these are, so that its own series moves the orbits.
    fn perform<T: Task>(&self, task: T) -> T::Output {
        self.0.perform(task)
    }

    fn carry(&self, orbits: Carry<'_, '_, '_>) -> Vec<(usize, Loss)> {
        self.0.carry(orbits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::Flow;
    use crate::in_space::example;

    #[test]
    fn an_orbit_below_no_inclination_is_the_one_above_it_with_the_node_on_the_other_side() {
        let model = Unfolded(example::problem().model.averaged());
        let end = |variables| {
            let flow = Flow::new(model);
            model.read_out(1.0, flow.carry_one(model.state(0.0, variables), 0.0, 1.0).unwrap())
        };
        let (below, above) = (end([2.0, 0.1, -0.2, 1.0]), end([2.0, 0.1, 0.2, 1.0 + std::f64::consts::PI]));
        assert!(below.iter().zip(above).all(|(a, b)| (a - b).abs() < 1e-11), "{below:?} {above:?}");
        assert!(Unfolded::<Vectorial, 4>::VARIABLES[2].allows(-0.2) && !Vectorial::VARIABLES[2].allows(-0.2));
    }
}

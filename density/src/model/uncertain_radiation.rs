//! A planar model whose radiation parameter differs from orbit to orbit: it is a variable of the orbit and stays
//! constant along it.
//!
//! Radiation pressure enters the motion linearly: `C` adds `n_sun C s` to the rate of `x1 = e sin(phi)`, with `s =
//! sqrt(1 - e²)` (Eqs. 1 and 7 of Sun et al. 2022). All else is the planar model's motion with `C = 0`.

use std::fmt::Debug;
use std::marker::PhantomData;

use super::earth::SUN_MEAN_MOTION;
use super::planar::SrpJ2;
use super::planar_recurrence::Recurrence;
use super::plane::{State, VARIABLES, density_growth};
use super::registry::{Planar, registered};
use super::sun_moon::SunMoon;
use super::{Kind, LANES, Lanes, Model, PlanarHamiltonian, Quantity, Series, Task, Variable};
use crate::flow::FromEquations;
use crate::flow::carry::{Carry, Loss};

/// What the third variable is.
pub trait Scale: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// The third variable.
    const VARIABLE: Variable;

    /// The radiation parameter at a value of the third variable.
    fn radiation(value: f64) -> f64;

    /// The third variable at a radiation parameter.
    fn value(radiation: f64) -> f64;
}

/// The third variable is the radiation parameter `C` itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linear;

impl Scale for Linear {
    const VARIABLE: Variable = Variable {
        name: "radiation parameter",
        symbol: "C",
        unit: "",
        kind: Kind::Interval { low: 0.0, high: 1000.0 },
    };

    fn radiation(value: f64) -> f64 {
        value
    }

    fn value(radiation: f64) -> f64 {
        radiation
    }
}

/// The third variable is the logarithm of the radiation parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Logarithmic;

impl Scale for Logarithmic {
    const VARIABLE: Variable = Variable {
        name: "log radiation parameter",
        symbol: "ln_C",
        unit: "",
        kind: Kind::Interval { low: -1000.0, high: 1000.0 },
    };

    fn radiation(value: f64) -> f64 {
        value.exp()
    }

    fn value(radiation: f64) -> f64 {
        radiation.ln()
    }
}

/// A planar model whose radiation parameter is a variable. The state is `(x1, x2, C)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UncertainRadiation<S, M = Planar> {
    without: M,
    scale: PhantomData<S>,
}

impl<S: Scale, M: OwnRadiation> UncertainRadiation<S, M> {
    /// From the planar model without radiation pressure.
    pub fn new(without: M) -> Self {
        Self { without, scale: PhantomData }
    }

    /// The planar model without radiation pressure.
    pub fn without(&self) -> &M {
        &self.without
    }
}

/// A planar model of which every orbit may have a radiation parameter of its own.
pub trait OwnRadiation: PlanarHamiltonian {
    /// The Taylor series of such orbits.
    type Series<S: Scale, const P: usize>: Series<P, Model = UncertainRadiation<S, Self>>;

    /// See [`Model::perform`].
    fn perform_with_own<S: Scale, T: Task>(model: &UncertainRadiation<S, Self>, task: T) -> T::Output {
        task.with(model)
    }

    /// Moves orbits whose third coordinate is the radiation parameter, and returns those that were lost. What the third
    /// variable is makes no difference to the states, so there is one loop for both, compiled with the model
    /// ([`Model::carry`]).
    fn carry_with_own(&self, orbits: Carry<'_, '_, '_>) -> Vec<(usize, Loss)>;
}

macro_rules! own_carried_here {
    () => {
        fn carry_with_own(&self, orbits: Carry<'_, '_, '_>) -> Vec<(usize, Loss)> {
            orbits.with(&UncertainRadiation::<Linear, Self>::new(*self))
        }
    };
}

impl OwnRadiation for SrpJ2 {
    type Series<S: Scale, const P: usize> = OwnRadiationSeries<P, S>;

    own_carried_here!();
}

impl OwnRadiation for SunMoon {
    type Series<S: Scale, const P: usize> = FromEquations<UncertainRadiation<S, Self>, P>;

    own_carried_here!();
}

/// Any planar model hands what it is asked to the one for which it stands.
macro_rules! whichever_model {
    ($($variant:ident),+) => {
        impl OwnRadiation for Planar {
            type Series<S: Scale, const P: usize> = FromEquations<UncertainRadiation<S, Self>, P>;

            fn perform_with_own<S: Scale, T: Task>(model: &UncertainRadiation<S, Self>, task: T) -> T::Output {
                match model.without {
                    $(Self::$variant(without) => task.with(&UncertainRadiation::<S, _>::new(without))),+
                }
            }

            fn carry_with_own(&self, orbits: Carry<'_, '_, '_>) -> Vec<(usize, Loss)> {
                match self { $(Self::$variant(without) => without.carry_with_own(orbits)),+ }
            }
        }
    };
}

registered!(whichever_model);

impl<S: Scale, M: OwnRadiation> Model for UncertainRadiation<S, M> {
    type State<T: Quantity> = [T; 3];
    type Variables = [f64; 3];
    type Series<const P: usize> = <M as OwnRadiation>::Series<S, P>;

    const VARIABLES: &'static [Variable] = &[VARIABLES[0], VARIABLES[1], S::VARIABLE];
    const REENTRY: usize = 1;

    fn rate<T: Quantity>(&self, _: T, [x1, x2, radiation]: [T; 3]) -> [T; 3] {
        let state = State { x1, x2 };
        let motion = self.without.motion(state);
        [motion.x1 + state.s() * radiation * SUN_MEAN_MOTION, motion.x2, T::from(0.0)]
    }

    fn is_inside(&self, [x1, x2, _]: [f64; 3]) -> bool {
        x1 * x1 + x2 * x2 < 1.0
    }

    fn state(&self, _: f64, [phi, e, third]: [f64; 3]) -> [f64; 3] {
        let State { x1, x2 } = State::from_polar(phi, e);
        [x1, x2, S::radiation(third)]
    }

    fn read_out(&self, _: f64, [x1, x2, radiation]: [f64; 3]) -> [f64; 3] {
        let state = State { x1, x2 };
        [state.solar_angle(), state.eccentricity(), S::value(radiation)]
    }

    fn clearance<T: Quantity>(&self, [x1, x2, _]: [T; 3]) -> T {
        State { x1, x2 }.s()
    }

    fn critical_clearance(&self, critical: f64) -> f64 {
        self.without.critical_clearance(critical)
    }

    fn density_growth(&self, [x1, x2, _]: [f64; 3], [y1, y2, _]: [f64; 3]) -> Option<f64> {
        Some(density_growth(State { x1, x2 }, State { x1: y1, x2: y2 }))
    }

    fn conserved(&self, _: f64, [x1, x2, radiation]: [f64; 3]) -> Vec<(&'static str, f64)> {
        let without = self.without.hamiltonian(State { x1, x2 });
        vec![("hamiltonian", without + radiation * x2), ("radiation", radiation)]
    }

    fn reversed(&self, [x1, x2, radiation]: [f64; 3]) -> Option<[f64; 3]> {
        Some([-x1, x2, radiation])
    }

    fn perform<T: Task>(&self, task: T) -> T::Output {
        M::perform_with_own(self, task)
    }

    fn carry(&self, orbits: Carry<'_, '_, '_>) -> Vec<(usize, Loss)> {
        self.without.carry_with_own(orbits)
    }
}

/// The series of the planar model whose radiation parameter is the third coordinate of an orbit's state.
#[derive(Debug)]
#[repr(C, align(64))]
pub struct OwnRadiationSeries<const P: usize, S> {
    motion: Recurrence<P, Lanes>,
    /// The radiation parameter, which stays as it is: all coefficients beyond the first are 0.
    third: [Lanes; P],
    scale: PhantomData<S>,
}

impl<const P: usize, S: Scale> Series<P> for OwnRadiationSeries<P, S> {
    type Model = UncertainRadiation<S, SrpJ2>;

    #[inline(always)]
    fn new(model: &Self::Model) -> Self {
        let motion = Recurrence::new([0.0; LANES], model.without().oblateness);
        Self { motion, third: [[0.0; LANES]; P], scale: PhantomData }
    }

    #[inline(always)]
    fn start(&mut self, lane: usize, [x1, x2, radiation]: [f64; 3], _: f64) {
        self.motion.start(lane, State { x1, x2 });
        (self.motion.radiation[lane], self.third[0][lane]) = (radiation, radiation);
    }

    #[inline(always)]
    fn expand(&mut self, _: bool) {
        self.motion.expand();
    }

    #[inline(always)]
    fn move_on(&mut self, step: &Lanes) {
        self.motion.move_on(step);
    }

    #[inline(always)]
    fn is_inside(&self, lane: usize) -> bool {
        self.motion.is_inside(lane)
    }

    #[inline(always)]
    fn coordinate(&self, k: usize) -> &[Lanes; P] {
        match k {
            0 => &self.motion.x1,
            1 => &self.motion.x2,
            _ => &self.third,
        }
    }

    #[inline(always)]
    fn clearance(&self) -> &[Lanes; P] {
        &self.motion.s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::Flow;

    #[test]
    fn every_orbit_moves_as_with_a_radiation_parameter_of_its_own() {
        let force = SrpJ2 { radiation: 0.15, oblateness: 0.40921 };
        for model in [Planar::from(force), SunMoon { force, sun: 4.8e-4, moon: 1e-3 }.into()] {
            let uncertain = UncertainRadiation::<Linear>::new(model.with("radiation", 0.0).unwrap());
            for radiation in [0.02, 0.15, 0.3] {
                let alone = Flow::new(model.with("radiation", radiation).unwrap());
                let end = alone.advance_one(State::from_polar(2.2, 0.145), 2.0).unwrap();
                let start = uncertain.state(0.0, [2.2, 0.145, radiation]);
                let [x1, x2, kept] = Flow::new(uncertain).carry_one(start, 0.0, 2.0).unwrap();
                assert!((x1 - end.x1).hypot(x2 - end.x2) < 1e-11 && kept == radiation, "{radiation}");
            }
        }
    }

    #[test]
    fn orbits_side_by_side_are_the_same_bytes_as_one_by_one_with_their_parameters() {
        let starts: Vec<[f64; 3]> = (0..40).map(f64::from).map(|k| [0.15 * k, 0.1 + 0.01 * k, 0.01 * k]).collect();
        for (oblateness, years) in [(0.40921, 2.0), (0.40921, -1.0), (0.0, 0.5)] {
            let force = |radiation| SrpJ2 { radiation, oblateness };
            let together = UncertainRadiation::<Linear>::new(force(0.0).into());
            let states: Vec<[f64; 3]> = starts.iter().map(|&start| together.state(0.0, start)).collect();
            let mut columns = [0, 1, 2].map(|k| states.iter().map(|state| state[k]).collect::<Vec<f64>>());
            Flow::new(together).carry_where_possible(&mut columns.each_mut().map(Vec::as_mut_slice), 0.0, years);
            for (i, &[x1, x2, radiation]) in states.iter().enumerate() {
                let end = Flow::new(force(radiation)).carry_one(State { x1, x2 }, 0.0, years);
                let expected = end.map_or([f64::NAN; 2], |end| [end.x1, end.x2]);
                let found = [columns[0][i], columns[1][i]];
                assert_eq!(found.map(f64::to_bits), expected.map(f64::to_bits), "{radiation} {oblateness} {years}");
            }
        }
    }

    #[test]
    fn the_logarithm_is_read_out_as_it_was_given() {
        let model = UncertainRadiation::<Logarithmic>::new(SrpJ2 { radiation: 0.0, oblateness: 0.4 }.into());
        let state = model.state(0.0, [1.0, 0.2, -1.9]);
        assert!((state[2] - (-1.9f64).exp()).abs() < 1e-16 && (model.read_out(0.0, state)[2] + 1.9).abs() < 1e-15);
    }
}

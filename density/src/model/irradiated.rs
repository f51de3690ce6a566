//! A model in space whose radiation parameter differs from orbit to orbit: it is a variable of the orbit and stays
//! constant along it.
//!
//! The planar counterpart is [`super::uncertain_radiation`]. Here the model keeps its own Taylor recurrence: only `C`,
//! which is one number for all orbits elsewhere, becomes one number for each lane.

use std::fmt::Debug;
use std::marker::PhantomData;

use super::uncertain_radiation::Scale;
use super::{Coordinates, LANES, Lanes, Model, Quantity, Series, Variable};
use crate::flow::carry::{Carry, Loss};

/// A model in which the radiation parameter may be another one for every orbit.
pub trait Irradiated<S: Scale>: CarryIrradiated {
    /// The model's variables, and the radiation parameter as the scale has it.
    const WITH_RADIATION: &'static [Variable];

    /// Time derivative of the state \[1/yr\] with this radiation parameter.
    fn rate_with<T: Quantity>(&self, radiation: T, time: T, state: Self::State<T>) -> Self::State<T>;

    /// Gives a lane of a series a radiation parameter of its own.
    fn irradiate<const P: usize>(series: &mut Self::Series<P>, lane: usize, radiation: f64);
}

/// The integrator's loop for orbits of a model with radiation parameters of their own. What the last variable is, `C`
/// or its logarithm, makes no difference to the states, so there is one loop for both, compiled with the model
/// ([`Model::carry`]).
pub trait CarryIrradiated: Model {
    /// Moves orbits whose last coordinate is the radiation parameter, and returns those that were lost.
    fn carry_irradiated(&self, orbits: Carry<'_, '_, '_>) -> Vec<(usize, Loss)>;
}

/// Has that loop compiled with a model.
macro_rules! irradiated_carried_here {
    ($model:ty) => {
        impl $crate::model::irradiated::CarryIrradiated for $model {
            fn carry_irradiated(
                &self,
                orbits: $crate::flow::carry::Carry<'_, '_, '_>,
            ) -> Vec<(usize, $crate::flow::carry::Loss)> {
                let model =
                    $crate::model::irradiated::WithRadiation::<Self, $crate::model::uncertain_radiation::Linear>::new(
                        *self,
                    );
                $crate::model::Task::with(orbits, &model)
            }
        }
    };
}

pub(super) use irradiated_carried_here;

/// Coordinates with one more at the end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extended<C, T> {
    /// All but the last.
    pub first: C,
    /// The last.
    pub last: T,
}

impl<T: Copy, C: Coordinates<T>> Coordinates<T> for Extended<C, T> {
    const COUNT: usize = C::COUNT + 1;

    #[inline(always)]
    fn from_fn(mut component: impl FnMut(usize) -> T) -> Self {
        Self { first: C::from_fn(&mut component), last: component(C::COUNT) }
    }

    #[inline(always)]
    fn component(&self, k: usize) -> T {
        if k < C::COUNT { self.first.component(k) } else { self.last }
    }
}

/// A model whose radiation parameter is the last of its variables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WithRadiation<M, S> {
    /// The model; its own radiation parameter is not used.
    pub model: M,
    scale: PhantomData<S>,
}

impl<M, S> WithRadiation<M, S> {
    /// From a model with any radiation parameter.
    pub fn new(model: M) -> Self {
        Self { model, scale: PhantomData }
    }
}

impl<S: Scale, M: Irradiated<S>> Model for WithRadiation<M, S> {
    type State<T: Quantity> = Extended<M::State<T>, T>;
    type Variables = Extended<M::Variables, f64>;
    type Series<const P: usize> = IrradiatedSeries<M, S, P>;

    const VARIABLES: &'static [Variable] = M::WITH_RADIATION;
    const REENTRY: usize = M::REENTRY;

    fn rate<T: Quantity>(&self, time: T, state: Self::State<T>) -> Self::State<T> {
        Extended { first: self.model.rate_with(state.last, time, state.first), last: T::from(0.0) }
    }

    fn is_inside(&self, state: Self::State<f64>) -> bool {
        self.model.is_inside(state.first)
    }

    fn state(&self, time: f64, variables: Self::Variables) -> Self::State<f64> {
        Extended { first: self.model.state(time, variables.first), last: S::radiation(variables.last) }
    }

    fn read_out(&self, time: f64, state: Self::State<f64>) -> Self::Variables {
        Extended { first: self.model.read_out(time, state.first), last: S::value(state.last) }
    }

    fn clearance<T: Quantity>(&self, state: Self::State<T>) -> T {
        self.model.clearance(state.first)
    }

    fn critical_clearance(&self, critical: f64) -> f64 {
        self.model.critical_clearance(critical)
    }

    fn density_growth(&self, start: Self::State<f64>, end: Self::State<f64>) -> Option<f64> {
        self.model.density_growth(start.first, end.first)
    }

    fn conserved(&self, time: f64, state: Self::State<f64>) -> Vec<(&'static str, f64)> {
        let mut conserved = self.model.conserved(time, state.first);
        conserved.push(("radiation", state.last));
        conserved
    }

    fn carry(&self, orbits: Carry<'_, '_, '_>) -> Vec<(usize, Loss)> {
        self.model.carry_irradiated(orbits)
    }
}

/// The model's own series, in whose lanes the radiation parameters differ.
pub struct IrradiatedSeries<M: Model, S, const P: usize> {
    series: M::Series<P>,
    radiation: [Lanes; P],
    scale: PhantomData<S>,
}

impl<S: Scale, M: Irradiated<S>, const P: usize> Series<P> for IrradiatedSeries<M, S, P> {
    type Model = WithRadiation<M, S>;

    #[inline(always)]
    fn new(model: &WithRadiation<M, S>) -> Self {
        Self { series: M::Series::new(&model.model), radiation: [[0.0; LANES]; P], scale: PhantomData }
    }

    #[inline(always)]
    fn start(&mut self, lane: usize, state: Extended<M::State<f64>, f64>, time: f64) {
        self.series.start(lane, state.first, time);
        M::irradiate(&mut self.series, lane, state.last);
        self.radiation[0][lane] = state.last;
    }

    #[inline(always)]
    fn head_for(&mut self, lane: usize, years: f64) {
        self.series.head_for(lane, years);
    }

    #[inline(always)]
    fn expand(&mut self, with_clearance: bool) {
        self.series.expand(with_clearance);
    }

    #[inline(always)]
    fn shorten(&mut self, planned: Lanes) -> Lanes {
        self.series.shorten(planned)
    }

    #[inline(always)]
    fn may_creep(&self, lane: usize) -> bool {
        self.series.may_creep(lane)
    }

    #[inline(always)]
    fn move_on(&mut self, steps: &Lanes) {
        self.series.move_on(steps);
    }

    #[inline(always)]
    fn is_inside(&self, lane: usize) -> bool {
        self.series.is_inside(lane)
    }

    #[inline(always)]
    fn coordinate(&self, k: usize) -> &[Lanes; P] {
        if k < M::State::<f64>::COUNT { self.series.coordinate(k) } else { &self.radiation }
    }

    #[inline(always)]
    fn clearance(&self) -> &[Lanes; P] {
        self.series.clearance()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::Flow;
    use crate::model::osculating::Osculating;
    use crate::model::planar::SrpJ2;
    use crate::model::sun_moon::SunMoon;
    use crate::model::uncertain_radiation::{Linear, Logarithmic};
    use crate::model::vectorial::Vectorial;
    use crate::orbits::Orbits;

    const RADIATIONS: [f64; 3] = [0.02, 0.15, 0.3];

    fn forces(radiation: f64) -> SunMoon {
        SunMoon { force: SrpJ2 { radiation, oblateness: 0.409 }, sun: 4.76e-4, moon: 1.037e-3 }
    }

    #[test]
    fn every_averaged_orbit_in_space_moves_as_with_a_radiation_parameter_of_its_own() {
        let model = |radiation| Vectorial { forces: forces(radiation), obliquity: 0.409, sun_longitude: 1.0 };
        let start = [2.2, 0.145, 0.3, 1.0];
        let columns = [[2.2; 3], [0.145; 3], [0.3; 3], [1.0; 3], RADIATIONS];
        let flow = Flow::new(WithRadiation::<_, Linear>::new(model(0.0)));
        let mut orbits = Orbits::from_variables(flow, &columns.each_ref().map(|column| column.as_slice()));
        orbits.advance_to(2.0).unwrap();
        for (i, radiation) in RADIATIONS.into_iter().enumerate() {
            let alone = Flow::new(model(radiation));
            let end = alone.carry_one(alone.model.state(0.0, start), 0.0, 2.0).unwrap();
            let found: Vec<f64> = orbits.columns().iter().map(|column| column[i]).collect();
            assert!(end.iter().zip(&found).all(|(a, b)| (a - b).abs() < 1e-12), "{radiation}: {end:?} {found:?}");
            assert_eq!(found[6], radiation);
        }
    }

    #[test]
    fn every_unaveraged_orbit_moves_as_with_a_radiation_parameter_of_its_own() {
        let model = |radiation| Osculating {
            semi_major_axis: 2.5,
            forces: forces(radiation),
            obliquity: 0.409,
            sun_longitude: 1.0,
            moon_longitude: 0.5,
        };
        let start = [2.2, 0.145, 0.3, 1.0, 4.0, 2.5];
        let flow = Flow::new(WithRadiation::<_, Logarithmic>::new(model(0.0)));
        for radiation in RADIATIONS {
            let alone = Flow::new(model(radiation));
            let end = alone.carry_one(alone.model.state(0.0, start), 0.0, 0.05).unwrap();
            let with = flow.model.state(0.0, Extended { first: start, last: radiation.ln() });
            let found = flow.carry_one(with, 0.0, 0.05).unwrap();
            assert!(end.iter().zip(found.first).all(|(a, b)| (a - b).abs() < 1e-12), "{radiation}");
            assert!((flow.model.read_out(0.05, found).last - radiation.ln()).abs() < 1e-15);
        }
    }

    #[test]
    fn the_series_is_that_of_the_equations_of_motion() {
        use crate::model::{Dual, acceleration};
        let model =
            WithRadiation::<_, Linear>::new(Vectorial { forces: forces(0.0), obliquity: 0.409, sun_longitude: 1.0 });
        let state = model.state(0.3, Extended { first: [2.2, 0.145, 0.3, 1.0], last: 0.2 });
        let second = acceleration(&model, 0.3, state);
        let mut series = <WithRadiation<Vectorial, Linear> as Model>::Series::<4>::new(&model);
        series.start(0, state, 0.3);
        series.expand(true);
        for k in 0..7 {
            let year = crate::model::earth::SUN_MEAN_MOTION;
            let found = 2.0 * series.coordinate(k)[2][0] * year * year;
            assert!((found - second.component(k)).abs() < 1e-11, "{k}: {found} {}", second.component(k));
        }
        // The rate is linear in C: a Dual in the last coordinate gives the coefficient of C.
        let dual = Extended::<[Dual; 6], Dual>::from_fn(|k| Dual::new(state.component(k), f64::from(u8::from(k == 6))));
        let slope = model.rate(Dual::from(0.3), dual);
        let other = Extended { last: 1.2, ..state };
        let difference = |k: usize| model.rate(0.3, other).component(k) - model.rate(0.3, state).component(k);
        assert!((0..7).all(|k| (slope.component(k).derivative - difference(k)).abs() < 1e-12));
    }
}

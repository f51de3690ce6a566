//! Models of an orbit's motion: what every model states and what it may offer beyond that.
//!
//! A [`Model`] says how orbits move and in which variables they are given and read out. Everything else in this crate
//! (the flow, the samples, the sigma points, the first passages) takes any model. Code that needs more of a model asks
//! for a capability, which is a trait bound: a [`PlanarHamiltonian`] for closed orbits in the plane, the exact density,
//! meshes and phase portraits. A model that lacks the capability is refused at compile time.
//!
//! There are two sets of coordinates:
//!
//! - the *state*, in which orbits are integrated. It is regular wherever satellites go: `(e sin phi, e cos phi)` in the
//!   plane, the eccentricity and angular momentum vectors in space;
//! - the *variables*, in which a cloud is given and read out: solar angle, eccentricity, inclination. They have names
//!   and units; a variable that is an angle has no natural start.
//!
//! A model writes its equations of motion once, in [`Model::rate`], over any [`Quantity`]. Evaluated with plain numbers
//! they give a rate; with [`Dual`] numbers they give its derivative; and recorded they become the Taylor series of the
//! integrator ([`FromEquations`](crate::flow::FromEquations)). A model of which millions of orbits are propagated may
//! give the integrator a recurrence of its own, as [`planar`] does.
//!
//! # A new planar model
//! Add one file here with an `impl` of [`PlanarHamiltonian`], of [`parameter::Named`] and of
//! [`uncertain_radiation::OwnRadiation`], and its name in the list of [`registry`].
//!
//! | file | idea |
//! |---|---|
//! | [`variable`] | the name, the unit and the kind of a variable |
//! | [`parameter`] | the name, the symbol and the range of a parameter |
//! | [`coordinates`] | a fixed number of coordinates |
//! | [`quantity`] | the types over which equations of motion are written: numbers, and numbers with a derivative |
//! | [`plane`] | states in the plane, and what a planar Hamiltonian model states beyond every other model |
//! | [`planar`] | solar radiation pressure and Earth's oblateness in the plane: the paper's model |
//! | [`planar_recurrence`] | the recurrence of its Taylor series, with one radiation parameter or one for each orbit |
//! | [`sun_moon`] | the same with the gravity of the Sun and the Moon |
//! | [`uncertain_radiation`] | a planar model whose radiation parameter is a variable of the orbit |
//! | [`vectorial`] | the same in space, with the obliquity of the ecliptic |
//! | [`osculating`] | the same in space without any average |
//! | [`shadow`] | the same with the Earth's shadow |
//! | [`irradiated`] | a model in space whose radiation parameter is a variable of the orbit |
//! | [`unfolded`] | a model in space for clouds whose inclination may be below 0 |
//! | [`vector`] | vectors in space |
//! | `part` | arithmetic on Taylor coefficients, for recurrences written by hand |
//! | [`elements`] | the elements of an orbit in space, and the vectors that stand for them |
//! | [`ecliptic`] | directions in the ecliptic |
//! | [`earth`] | constants of the Earth and the Sun |
//! | [`model_name`] | the models that a scenario file, or a case that simplifies its scenario, can name |
//! | [`registry`] | every planar model by its name |
//! | [`space_registry`] | every model in space by its name |

pub mod coordinates;
pub mod earth;
pub mod ecliptic;
pub mod elements;
pub mod irradiated;
pub mod model_name;
pub mod osculating;
pub mod parameter;
mod part;
pub mod planar;
pub mod planar_recurrence;
pub mod plane;
pub mod quantity;
pub mod registry;
pub mod shadow;
pub mod space_registry;
pub mod sun_moon;
pub mod uncertain_radiation;
pub mod unfolded;
pub mod variable;
pub mod vector;
pub mod vectorial;

use std::fmt::Debug;

pub use coordinates::Coordinates;
pub use plane::PlanarHamiltonian;
pub use quantity::{Dual, Quantity};
pub use variable::{Kind, Variable};

pub use crate::lanes::{LANES, Lanes};

use crate::flow::carry::{Carry, Loss};

/// A model of an orbit's motion. Time is in years.
pub trait Model: Copy + Debug + PartialEq + Send + Sync + 'static {
    /// The coordinates in which orbits are integrated.
    type State<T: Quantity>: Coordinates<T>;
    /// The variables in which orbits are given and read out, one for each of [`Model::VARIABLES`].
    type Variables: Coordinates<f64> + Debug + Send + Sync;
    /// The Taylor series of the integrator: [`FromEquations`](crate::flow::FromEquations), or a recurrence of the
    /// model's own.
    type Series<const P: usize>: Series<P, Model = Self>;

    /// The variables' names, units and kinds.
    const VARIABLES: &'static [Variable];
    /// Which of the variables grows to its critical value when the satellite re-enters.
    const REENTRY: usize;

    /// Time derivative of the state \[1/yr\] at a time \[yr\].
    fn rate<T: Quantity>(&self, time: T, state: Self::State<T>) -> Self::State<T>;

    /// Whether the equations of motion hold at a state.
    fn is_inside(&self, state: Self::State<f64>) -> bool;

    /// The state of an orbit with these variables at a time \[yr\].
    fn state(&self, time: f64, variables: Self::Variables) -> Self::State<f64>;

    /// The variables of an orbit in this state at a time \[yr\]. Those on a circle are in `[0, 2π)`.
    fn read_out(&self, time: f64, state: Self::State<f64>) -> Self::Variables;

    /// The variables of many orbits at a time \[yr\], one element per variable, from the coordinates of their states.
    /// The last bits may differ from those of [`Model::read_out`].
    fn read_out_lanes(&self, time: f64, states: &[Lanes], variables: &mut [Lanes]) {
        for lane in 0..LANES {
            let values = self.read_out(time, Coordinates::from_fn(|k| states[k][lane]));
            variables.iter_mut().enumerate().for_each(|(k, variable)| variable[lane] = values.component(k));
        }
    }

    /// A smooth function of the state that falls as the re-entry variable grows; it measures how far the satellite is
    /// from re-entry.
    fn clearance<T: Quantity>(&self, state: Self::State<T>) -> T;

    /// The clearance at a value of the re-entry variable.
    fn critical_clearance(&self, critical: f64) -> f64;

    /// The factor by which a density per unit of the variables has changed after the flow carried it from `start` to
    /// `end`. `Some` if the factor follows from these states alone, because the flow keeps a measure; `None` if it has
    /// to be integrated along the orbit, from [`Model::divergence`].
    fn density_growth(&self, _start: Self::State<f64>, _end: Self::State<f64>) -> Option<f64> {
        None
    }

    /// Divergence of the rate in the coordinates of the state \[1/yr\]: the relative rate at which a density per unit
    /// of them falls.
    fn divergence(&self, time: f64, state: Self::State<f64>) -> f64 {
        let along = |k: usize| {
            let state = Self::State::<Dual>::from_fn(|j| Dual::new(state.component(j), f64::from(j == k)));
            self.rate(Dual::from(time), state).component(k).derivative
        };
        (0..Self::State::<f64>::COUNT).map(along).sum()
    }

    /// The names and values of the quantities that are constant along every orbit, if there are any.
    fn conserved(&self, _time: f64, _state: Self::State<f64>) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// The mirror image of the state, whose motion forwards in time mirrors the motion of this state backwards; `None`
    /// if the model has no such symmetry.
    fn reversed(&self, _state: Self::State<f64>) -> Option<Self::State<f64>> {
        None
    }

    /// Does a task with this model, or with the model that it stands for. A registry of models overrides this, so that
    /// no choice between models is made within the task.
    fn perform<T: Task>(&self, task: T) -> T::Output {
        task.with(self)
    }

    /// Moves orbits with the integrator and returns those that were lost. A model without type parameters repeats this
    /// function in its own `impl` (`carried_here!`): the integrator's loop is then compiled with the model, once, and
    /// not again in every crate that moves its orbits. It takes most of the time in which this crate is compiled.
    fn carry(&self, orbits: Carry<'_, '_, '_>) -> Vec<(usize, Loss)> {
        self.perform(orbits)
    }
}

/// Has the integrator's loop compiled with a model, see [`Model::carry`].
macro_rules! carried_here {
    () => {
        carried_here!(carry);
    };
    ($name:ident) => {
        fn $name(&self, orbits: $crate::flow::carry::Carry<'_, '_, '_>) -> Vec<(usize, $crate::flow::carry::Loss)> {
            $crate::model::Task::with(orbits, self)
        }
    };
}
use carried_here;

/// Something that is done with any model; the integrator's loop is one such task.
pub trait Task {
    /// The result.
    type Output;

    /// Does the task with a given model.
    fn with<M: Model>(self, model: &M) -> Self::Output;
}

/// Taylor coefficients of [`LANES`] orbits of a model: `P` coefficients per coordinate, in the time unit `1/n_sun`. The
/// coefficients of order 0 are the states. A lane never looks at its neighbours.
///
/// Implementations mark every method `#[inline(always)]`: the methods become part of the integrator's loop, which is
/// compiled for several sets of vector instructions. Loops over lanes are written so that the compiler can vectorise
/// them.
pub trait Series<const P: usize> {
    /// The model.
    type Model: Model;

    /// Series for the orbits of a model, all lanes at rest.
    fn new(model: &Self::Model) -> Self;

    /// Puts an orbit into a lane, at a time \[yr\].
    fn start(&mut self, lane: usize, state: <Self::Model as Model>::State<f64>, time: f64);

    /// Says for how many years the orbit that was put into a lane will be moved, backwards if negative.
    #[inline(always)]
    fn head_for(&mut self, _lane: usize, _years: f64) {}

    /// Computes all coefficients from those of order 0; those of the clearance only if asked for.
    fn expand(&mut self, with_clearance: bool);

    /// The steps that may be taken where steps of these lengths are planned \[1/n_sun\]: shorter ones where something
    /// ends the series that its coefficients do not show, such as the edge of a shadow.
    #[inline(always)]
    fn shorten(&mut self, planned: Lanes) -> Lanes {
        planned
    }

    /// Whether a lane's steps may be tiny for a while, because its orbit is at such an edge, without being stuck.
    #[inline(always)]
    fn may_creep(&self, _lane: usize) -> bool {
        false
    }

    /// Moves each lane by its step \[1/n_sun\], backwards if negative.
    fn move_on(&mut self, steps: &Lanes);

    /// Whether the equations hold at a lane's state.
    fn is_inside(&self, lane: usize) -> bool;

    /// Coefficients of coordinate `k` of the state.
    fn coordinate(&self, k: usize) -> &[Lanes; P];

    /// Coefficients of the clearance ([`Model::clearance`]).
    fn clearance(&self) -> &[Lanes; P];
}

/// Second time derivatives of the state \[1/yr²\], by [`Dual`] numbers.
pub fn acceleration<M: Model>(model: &M, time: f64, state: M::State<f64>) -> M::State<f64> {
    let rate = model.rate(time, state);
    let moving = M::State::<Dual>::from_fn(|k| Dual::new(state.component(k), rate.component(k)));
    let accelerated = model.rate(Dual::new(time, 1.0), moving);
    M::State::<f64>::from_fn(|k| accelerated.component(k).derivative)
}

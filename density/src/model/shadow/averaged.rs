//! The averaged model in space with the Earth's shadow.
//!
//! The state is that of [`crate::model::vectorial`] and the semi-major axis `α` in units of the nominal one, for which
//! the parameters `C`, `W`, `A` and `B` are given. They change with it: `C ∝ α^(1/2)`, `W ∝ α^(-7/2)`, `A, B ∝
//! α^(3/2)`. Where an orbit begins to touch the shadow its rate has a kink, so that it is moved by [`RungeKutta`]
//! steps. In the equator without obliquity this is the planar model with the shadow.

use super::averages::{Lit, Rates};
use super::edges::{Dark, Ellipse};
use crate::flow::{Edged, RungeKutta};
use crate::model::earth::SUN_MEAN_MOTION;
use crate::model::irradiated::{Irradiated, irradiated_carried_here};
use crate::model::sun_moon::SunMoon;
use crate::model::uncertain_radiation::Scale;
use crate::model::vector::{Vector, dot};
use crate::model::vectorial::{self, Vectorial, vectors};
use crate::model::{Dual, Model, Quantity, Variable, carried_here, ecliptic, osculating};

/// The averaged model with the shadow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadowedVectorial {
    /// The forces at the nominal semi-major axis, and the Sun.
    pub model: Vectorial,
    /// Nominal semi-major axis \[Earth radii\].
    pub semi_major_axis: f64,
    /// Height of the pericentre above the Earth's centre at which the satellite re-enters \[Earth radii\]; where there
    /// is none, it re-enters at a critical eccentricity.
    pub reentry_radius: Option<f64>,
}

/// Solar angle, eccentricity, inclination, node, and semi-major axis.
pub const VARIABLES: [Variable; 5] = [
    vectorial::VARIABLES[0],
    vectorial::VARIABLES[1],
    vectorial::VARIABLES[2],
    vectorial::VARIABLES[3],
    osculating::VARIABLES[5],
];

/// The components of `e`, those of `h`, and the semi-major axis in units of the nominal one.
pub type State<T = f64> = [T; 7];

fn split<T: Copy>([e1, e2, e3, h1, h2, h3, axis]: State<T>) -> (vectorial::State<T>, T) {
    ([e1, e2, e3, h1, h2, h3], axis)
}

impl ShadowedVectorial {
    /// The orbit as sunlight meets it.
    fn lit<T: Quantity>(&self, time: T, state: State<T>) -> Lit<T> {
        let (six, axis) = split(state);
        let (e, h) = vectors(six);
        Lit::new(e, h, self.sunward(time), T::from(1.0 / self.semi_major_axis) / axis)
    }

    fn sunward<T: Quantity>(&self, time: T) -> Vector<T> {
        ecliptic::direction(self.model.longitude(time).sin_cos(), self.model.obliquity)
    }

    /// The ellipse as seen from the Sun.
    pub fn ellipse(&self, time: f64, state: State) -> Ellipse {
        self.lit(time, state).ellipse()
    }

    /// Time derivative of the state \[1/yr\] with another radiation parameter.
    fn rate_with<T: Quantity>(&self, radiation: T, time: T, state: State<T>) -> State<T> {
        let numbers = state.map(Quantity::number);
        let lit = self.lit(time, state);
        let dark = self.ellipse(time.number(), numbers).dark();
        self.rate_of(radiation, time, state, lit.rates(&dark))
    }

    fn rate_of<T: Quantity>(&self, radiation: T, time: T, state: State<T>, by_light: Rates<T>) -> State<T> {
        let SunMoon { force, sun, moon } = self.model.forces;
        let (six, axis) = split(state);
        let root = axis.sqrt();
        let (up, down) = (axis * root, T::from(1.0) / (axis * axis * axis * root));
        let others = [T::from(0.0), down * force.oblateness, up * sun, up * moon];
        let rate = self.model.rate_of(others, time, six);
        let strength = radiation * root * SUN_MEAN_MOTION;
        let Rates { e, h, axis: growth } = by_light;
        std::array::from_fn(|k| match k {
            0..3 => rate[k] + e[k] * strength,
            3..6 => rate[k] + h[k - 3] * strength,
            _ => axis * growth * strength,
        })
    }

    /// The dark stretches of a revolution.
    pub fn dark(&self, time: f64, state: State) -> Dark {
        self.ellipse(time, state).dark()
    }

    /// The state whose `h ± e` have the length 1 exactly.
    fn on_spheres<T: Quantity>(state: State<T>) -> State<T> {
        let sphere = |sign: f64| {
            let own: Vector<T> = std::array::from_fn(|k| state[3 + k] + state[k] * sign);
            own.map(|x| x / dot(own, own).sqrt())
        };
        let (u, v) = (sphere(1.0), sphere(-1.0));
        std::array::from_fn(|k| match k {
            0..3 => (u[k] - v[k]) * 0.5,
            3..6 => (u[k - 3] + v[k - 3]) * 0.5,
            _ => state[6],
        })
    }
}

/// A depth below this, in Earth radii, does not shorten a step further: the shadow that may be missed changes the orbit
/// by less than its power 3/2.
const SHALLOW: f64 = 1e-7;

impl Edged for ShadowedVectorial {
    /// The depth `S` at a place where a stretch may begin or end cannot reach 0 before `|S'| t + ½ |S''| t² = |S|`; its
    /// second derivative is bounded by that of a circle of the apocentre's radius that turns at the fastest pace of the
    /// orbit.
    fn free_time(&self, time: f64, state: State) -> f64 {
        let rate = self.rate(time, state);
        let moving: State<Dual> = std::array::from_fn(|k| Dual::new(state[k], rate[k]));
        let lit = self.lit(Dual::new(time, 1.0), moving);
        let (six, axis) = split(state);
        let (e, h) = vectors(six);
        let (h2, e2) = (dot(h, h), dot(e, e));
        let SunMoon { force, .. } = self.model.forces;
        let pace =
            SUN_MEAN_MOTION * (2.0 + 2.0 * force.radiation + 1.5 * force.oblateness / (axis.powf(3.5) * h2 * h2));
        let size = axis * self.semi_major_axis * (1.0 + e2.sqrt());
        let bend = size * pace * pace;
        let free = |(longitude, depth): (f64, f64)| {
            // On the shadow's axis the distance has a kink, but no slope is steeper than that of the fastest orbit.
            let slope = lit.distance(longitude).derivative.abs().min(size * pace);
            let depth = depth.abs().max(SHALLOW);
            2.0 * depth / (slope + (slope * slope + 2.0 * bend * depth).sqrt())
        };
        self.ellipse(time, state).depths().map(free).fold(1.0, f64::min)
    }
}

irradiated_carried_here!(ShadowedVectorial);

impl<S: Scale> Irradiated<S> for ShadowedVectorial {
    const WITH_RADIATION: &'static [Variable] =
        &[VARIABLES[0], VARIABLES[1], VARIABLES[2], VARIABLES[3], VARIABLES[4], S::VARIABLE];

    fn rate_with<T: Quantity>(&self, radiation: T, time: T, state: State<T>) -> State<T> {
        self.rate_with(radiation, time, state)
    }

    fn irradiate<const P: usize>(series: &mut RungeKutta<Self, P>, lane: usize, radiation: f64) {
        series.replace(lane, |model| model.model.forces.force.radiation = radiation);
    }
}

impl Model for ShadowedVectorial {
    type State<T: Quantity> = State<T>;
    type Variables = [f64; 5];
    type Series<const P: usize> = RungeKutta<Self, P>;

    const VARIABLES: &'static [Variable] = &VARIABLES;
    const REENTRY: usize = 1;

    carried_here!();

    fn rate<T: Quantity>(&self, time: T, state: State<T>) -> State<T> {
        self.rate_with(T::from(self.model.forces.force.radiation), time, state)
    }

    fn is_inside(&self, state: State) -> bool {
        let (six, axis) = split(state);
        self.model.is_inside(six) && axis > 0.0
    }

    fn state(&self, time: f64, [phi, e, inclination, node, axis]: [f64; 5]) -> State {
        let six = self.model.state(time, [phi, e, inclination, node]);
        std::array::from_fn(|k| if k < 6 { six[k] } else { axis / self.semi_major_axis })
    }

    fn read_out(&self, time: f64, state: State) -> [f64; 5] {
        let (six, axis) = split(state);
        let [phi, e, inclination, node] = self.model.read_out(time, six);
        [phi, e, inclination, node, axis * self.semi_major_axis]
    }

    /// `1 - e²`; or `(1 - r/a)² - e²` for a height `r` of the pericentre, whose sign is that of `a (1 - e) - r`.
    fn clearance<T: Quantity>(&self, state: State<T>) -> T {
        let (six, axis) = split(state);
        let (e, _) = vectors(six);
        let most = match self.reentry_radius {
            Some(radius) => -(T::from(radius / self.semi_major_axis) / axis) + 1.0,
            None => T::from(1.0),
        };
        most * most - dot(e, e)
    }

    fn critical_clearance(&self, critical: f64) -> f64 {
        match self.reentry_radius {
            Some(_) => 0.0,
            None => (1.0 - critical) * (1.0 + critical),
        }
    }

    /// The rate at which a density falls that is given per unit of the areas on the two unit spheres of `h + e` and
    /// `h - e` and of the semi-major axis: per unit of the variables, a density is `e sin(i)` times as large.
    fn divergence(&self, time: f64, state: State) -> f64 {
        let along = |k: usize| {
            let state = Self::on_spheres(std::array::from_fn(|j| Dual::new(state[j], f64::from(j == k))));
            self.rate(Dual::from(time), state)[k].derivative
        };
        (0..state.len()).map(along).sum()
    }

    fn conserved(&self, _: f64, state: State) -> Vec<(&'static str, f64)> {
        let (six, _) = split(state);
        let (e, h) = vectors(six);
        vec![("e² + h²", dot(e, e) + dot(h, h)), ("e·h", dot(e, h))]
    }
}

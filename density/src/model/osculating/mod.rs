//! An orbit in space without any average: every force acts on the satellite where it is.
//!
//! Solar radiation pressure, Earth's oblateness, and the gravity of the Sun and the Moon as point masses on circles in
//! the ecliptic. In units of the nominal semi-major axis `a` and the nominal mean motion `n`, with `N = n/n_sun`,
//!
//! ```text
//! r'' = -r/r³ - (W/N) [r (1 - 5 z²/r²) + 2 z p]/r⁵ - σ s + Σ q D³ [(D b - r)/|D b - r|³ - b/D²]
//! σ = C/(1.5 N)      q = (4/3) A/N for the Sun, (4/3) B/N for the Moon
//! ```
//!
//! with `s` the direction to the Sun, `p` the Earth's pole, and `b` and `D` the direction and the distance of the Sun
//! or the Moon. `C`, `W`, `A` and `B` are those of [`super::planar`] and [`super::sun_moon`]: `(2/3)(W/N) = J2 (R/a)²`,
//! and `q` is `mu_body a³/(mu D³)` (Montenbruck & Gill, Satellite Orbits, 2000, Sect. 3.2 to 3.4). There is no shadow:
//! sunlight has the same pressure everywhere.
//!
//! The variables are osculating elements: those of the ellipse on which the satellite would go on if all these forces
//! ended. They oscillate within a revolution; [`mean`] averages that away, for a comparison with averaged models.
//!
//! | file | idea |
//! |---|---|
//! | here | the model |
//! | [`kepler`] | position and velocity from the elements, and back |
//! | `series` | the Taylor series of many orbits |
//! | `recurrence` | its recurrence, written out for speed |
//! | [`mean`] | averages over a revolution |

pub mod kepler;
pub mod mean;
#[allow(clippy::needless_range_loop, reason = "loops over lanes and coordinates, all alike")]
mod recurrence;
#[allow(clippy::needless_range_loop, reason = "loops over lanes and coordinates, all alike")]
mod series;

pub use series::OsculatingSeries;

use super::earth::{self, SUN_MEAN_MOTION};
use super::elements::{Elements, turn};
use super::irradiated::{Irradiated, irradiated_carried_here};
use super::planar::SrpJ2;
use super::sun_moon::{MOON_DISTANCE, MOON_MU, SunMoon};
use super::uncertain_radiation::Scale;
use super::vector::{Vector, cross, dot, plus, times};
use super::{Kind, Model, Quantity, Variable, carried_here, ecliptic, vectorial};
use kepler::Motion;

/// The unaveraged model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Osculating {
    /// Nominal semi-major axis, for which `forces` are given \[Earth radii\].
    pub semi_major_axis: f64,
    /// The parameters `C`, `W`, `A` and `B`; a force whose parameter is 0 does not act.
    pub forces: SunMoon,
    /// Obliquity of the ecliptic \[rad\].
    pub obliquity: f64,
    /// Longitude of the Sun at `t = 0` \[rad\].
    pub sun_longitude: f64,
    /// Longitude of the Moon at `t = 0` \[rad\].
    pub moon_longitude: f64,
}

/// Solar angle, eccentricity, inclination, node, mean anomaly and semi-major axis, all osculating.
pub const VARIABLES: [Variable; 6] = [
    vectorial::VARIABLES[0],
    vectorial::VARIABLES[1],
    vectorial::VARIABLES[2],
    vectorial::VARIABLES[3],
    Variable { name: "mean anomaly", symbol: "M", unit: "rad", kind: Kind::Circle },
    Variable { name: "semi-major axis", symbol: "a", unit: "R_E", kind: Kind::Interval { low: 0.0, high: 1000.0 } },
];

/// The state: position, in units of the nominal semi-major axis, then velocity, in units of that times the nominal mean
/// motion.
pub type State<T = f64> = [T; 6];

/// The Sun or the Moon.
#[derive(Debug, Clone, Copy)]
struct Body {
    /// Its `q`.
    strength: f64,
    /// Its `D`, in nominal semi-major axes.
    distance: f64,
    /// Its mean motion \[rad per radian of the Sun\].
    pace: f64,
    /// Its longitude at `t = 0` \[rad\].
    longitude: f64,
}

impl Body {
    /// Longitude at a time \[yr\].
    fn longitude<T: Quantity>(&self, time: T) -> T {
        time * (SUN_MEAN_MOTION * self.pace) + self.longitude
    }
}

impl Osculating {
    /// The solar angle in `[0, 2π)` of an orbit with this longitude of pericentre at a time \[yr\].
    pub fn solar_angle(&self, time: f64, longitude_of_pericentre: f64) -> f64 {
        let [sun, _] = self.bodies();
        turn(longitude_of_pericentre - sun.longitude(time))
    }

    /// Nominal mean motion of the satellite, in units of the Sun's.
    pub(in crate::model) fn pace(&self) -> f64 {
        earth::mean_motion(self.semi_major_axis) * earth::YEAR / SUN_MEAN_MOTION
    }

    /// `σ`, the pressure of sunlight against the Earth's attraction.
    fn pressure(&self) -> f64 {
        self.pressure_of(self.forces.force.radiation)
    }

    /// `σ` of a radiation parameter `C`.
    fn pressure_of<T: Quantity>(&self, radiation: T) -> T {
        radiation / (1.5 * self.pace())
    }

    /// `W/N`, the oblateness as it acts.
    fn oblateness(&self) -> f64 {
        self.forces.force.oblateness / self.pace()
    }

    /// The Sun and the Moon.
    fn bodies(&self) -> [Body; 2] {
        // Radiation pressure and oblateness act in the rate; no force may be forgotten there or here.
        let SunMoon { force: SrpJ2 { radiation: _, oblateness: _ }, sun: of_sun, moon: of_moon } = self.forces;
        let axis = self.semi_major_axis * earth::RADIUS;
        let strength = |parameter: f64| 4.0 / 3.0 * parameter / self.pace();
        // Kepler's third law for two bodies.
        let moon_pace = ((earth::MU + MOON_MU) / MOON_DISTANCE.powi(3)).sqrt() * earth::YEAR / SUN_MEAN_MOTION;
        let (sun, moon) = (self.sun_longitude, self.moon_longitude);
        [
            Body { strength: strength(of_sun), distance: earth::SUN_DISTANCE / axis, pace: 1.0, longitude: sun },
            Body { strength: strength(of_moon), distance: MOON_DISTANCE / axis, pace: moon_pace, longitude: moon },
        ]
    }

    /// Time derivative of the state \[1/yr\] with another radiation parameter.
    pub(super) fn rate_with<T: Quantity>(&self, radiation: T, time: T, state: State<T>) -> State<T> {
        let (position, velocity) = halves(state);
        let acceleration = self.acceleration(radiation, time, position);
        let mean_motion = SUN_MEAN_MOTION * self.pace();
        std::array::from_fn(|k| if k < 3 { velocity[k] } else { acceleration[k - 3] } * mean_motion)
    }

    /// Longitude of the Sun at a time \[yr\].
    pub(super) fn longitude_of_sun(&self, time: f64) -> f64 {
        time * SUN_MEAN_MOTION + self.sun_longitude
    }

    /// Acceleration by everything, with this radiation parameter, in units of the nominal mean motion and semi-major
    /// axis.
    fn acceleration<T: Quantity>(&self, radiation: T, time: T, position: Vector<T>) -> Vector<T> {
        let r2 = dot(position, position);
        let inverse2 = T::from(1.0) / r2;
        let inverse3 = inverse2 / r2.sqrt();
        let inverse5 = inverse3 * inverse2;
        let z = position[2];
        let oblateness = self.oblateness();
        let mut toward_earth = inverse3 + (inverse5 - z * z * inverse5 * inverse2 * 5.0) * oblateness;
        let [sun, moon] = self.bodies();
        let direction = |body: &Body| ecliptic::direction(body.longitude(time).sin_cos(), self.obliquity);
        let mut others = times(direction(&sun), -self.pressure_of(radiation));
        for body in [sun, moon].into_iter().filter(|body| body.strength != 0.0) {
            let to_body = direction(&body);
            // |b - r/D|², so that no digit is lost where the body is far.
            let apart2 = r2 / body.distance.powi(2) - dot(to_body, position) * (2.0 / body.distance) + 1.0;
            let inverse = T::from(body.strength) / (apart2 * apart2.sqrt());
            toward_earth = toward_earth + inverse;
            others = plus(others, times(to_body, (inverse - body.strength) * body.distance));
        }
        others[2] = others[2] - z * inverse5 * (2.0 * oblateness);
        plus(others, times(position, -toward_earth))
    }
}

irradiated_carried_here!(Osculating);

impl<S: Scale> Irradiated<S> for Osculating {
    const WITH_RADIATION: &'static [Variable] =
        &[VARIABLES[0], VARIABLES[1], VARIABLES[2], VARIABLES[3], VARIABLES[4], VARIABLES[5], S::VARIABLE];

    fn rate_with<T: Quantity>(&self, radiation: T, time: T, state: State<T>) -> State<T> {
        self.rate_with(radiation, time, state)
    }

    #[inline(always)]
    fn irradiate<const P: usize>(series: &mut OsculatingSeries<P>, lane: usize, radiation: f64) {
        series.irradiate(lane, radiation);
    }
}

/// A function that is above 0 where the osculating pericentre is above a height over the Earth's centre, in nominal
/// semi-major axes: `h² - ρ (2 - ρ/a)`. An ellipse whose pericentre is at `ρ = a (1 - e)` has `h² = a (1 - e²) = ρ (2 -
/// ρ/a)`.
pub(super) fn above_pericentre<T: Quantity>(state: State<T>, radius: f64) -> T {
    let (position, velocity) = halves(state);
    let h = cross(position, velocity);
    let inverse_axis = T::from(2.0) / dot(position, position).sqrt() - dot(velocity, velocity);
    dot(h, h) + inverse_axis * (radius * radius) - 2.0 * radius
}

/// Position and velocity of a state.
pub(super) fn halves<T: Copy>([x, y, z, vx, vy, vz]: State<T>) -> (Vector<T>, Vector<T>) {
    ([x, y, z], [vx, vy, vz])
}

impl Model for Osculating {
    type State<T: Quantity> = State<T>;
    type Variables = [f64; 6];
    type Series<const P: usize> = OsculatingSeries<P>;

    const VARIABLES: &'static [Variable] = &VARIABLES;
    const REENTRY: usize = 1;

    carried_here!();

    fn rate<T: Quantity>(&self, time: T, state: State<T>) -> State<T> {
        self.rate_with(T::from(self.forces.force.radiation), time, state)
    }

    /// On an ellipse.
    fn is_inside(&self, state: State) -> bool {
        let (position, velocity) = halves(state);
        dot(velocity, velocity) * dot(position, position).sqrt() < 2.0
    }

    fn state(&self, time: f64, [phi, eccentricity, inclination, node, mean_anomaly, axis]: [f64; 6]) -> State {
        let [sun, _] = self.bodies();
        let longitude_of_pericentre = phi + sun.longitude(time);
        let elements = Elements { eccentricity, inclination, node, longitude_of_pericentre };
        let axis = axis / self.semi_major_axis;
        let (position, velocity) = kepler::place(&elements, axis, mean_anomaly);
        std::array::from_fn(|k| if k < 3 { position[k] } else { velocity[k - 3] })
    }

    fn read_out(&self, time: f64, state: State) -> [f64; 6] {
        let (position, velocity) = halves(state);
        let Motion { axis, vectors, mean_anomaly } = Motion::of(position, velocity);
        let Elements { eccentricity, inclination, node, longitude_of_pericentre } = vectors.elements();
        let phi = self.solar_angle(time, longitude_of_pericentre);
        [phi, eccentricity, inclination, node, turn(mean_anomaly), axis * self.semi_major_axis]
    }

    /// `1 - e² = |r × v|² (2/r - v²)`, which falls as the osculating eccentricity grows.
    fn clearance<T: Quantity>(&self, state: State<T>) -> T {
        let (position, velocity) = halves(state);
        let h = cross(position, velocity);
        dot(h, h) * (T::from(2.0) / dot(position, position).sqrt() - dot(velocity, velocity))
    }

    fn critical_clearance(&self, critical: f64) -> f64 {
        (1.0 - critical) * (1.0 + critical)
    }

    /// Volume in position and velocity is kept: `sqrt(a) e sin(i)` for each unit of the elements (Delaunay's
    /// variables).
    fn density_growth(&self, start: State, end: State) -> Option<f64> {
        let measure = |state: State| {
            let [_, e, i, _, _, a] = self.read_out(0.0, state);
            a.sqrt() * e * i.sin()
        };
        Some(measure(end) / measure(start))
    }
}

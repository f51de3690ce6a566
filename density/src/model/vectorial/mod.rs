//! An orbit in space under solar radiation pressure, Earth's oblateness and the gravity of the Sun and the Moon,
//! averaged over the satellite's revolution: the vectorial (Milankovitch) form.
//!
//! The state is the eccentricity vector `e` and the angular momentum vector `h`, in units of `sqrt(mu a)`, in
//! equatorial axes. They obey (Rosengren & Scheeres, Adv. Space Res. 52, 2013, and Celest. Mech. Dyn. Astron. 118,
//! 2014; Tremaine, Touma & Namouni, Astron. J. 137, 2009)
//!
//! ```text
//! e' = n_sun (e × ∂H/∂h + h × ∂H/∂e)      h' = n_sun (h × ∂H/∂h + e × ∂H/∂e)
//! H  = C e·s + (W/6) (3 (h·p)²/|h|⁵ - 1/|h|³)
//!      + A [5 (e·s)² - (h·s)² - 2 e²]
//!      + B [e²/2 - (5/2) (e·k)² - h²/2 + (h·k)²/2]
//! ```
//!
//! with `p` the Earth's pole, `k` the pole of the ecliptic, and `s = (cos l, sin l cos ε, sin l sin ε)` the direction
//! to the Sun at its longitude `l = n_sun t + l_0`; `ε` is the obliquity of the ecliptic. `C`, `W`, `A` and `B` are the
//! parameters of [`super::planar`] and [`super::sun_moon`], which this is for `ε = 0` and orbits in the equator. The
//! Moon's orbit is a circle in the ecliptic, averaged over its revolution; the Sun's is a circle.
//!
//! `e·h = 0` and `e² + h² = 1` are constant along every orbit. In `u = h + e`, `v = h - e` both vectors are turned on
//! unit spheres,
//!
//! ```text
//! u' = n_sun u × (∂H/∂h + ∂H/∂e)      v' = n_sun v × (∂H/∂h - ∂H/∂e)
//! ```
//!
//! so that the flow keeps the product of the areas on both, which is `e sin(i)` for each unit of the variables
//! `(phi, e, i, node)`. The solar angle is `phi = node + argument of pericentre - l`, which is regular in the equator.
//!
//! | file | idea |
//! |---|---|
//! | here | the model |
//! | `series` | its Taylor recurrence, written out for speed |

#[allow(clippy::needless_range_loop, reason = "loops over lanes and coordinates, all alike")]
mod series;

pub use series::VectorialSeries;

use super::earth::SUN_MEAN_MOTION;
use super::elements::{Elements, Vectors, turn};
use super::irradiated::{Irradiated, irradiated_carried_here};
use super::parameter::Parameter;
use super::planar::{OBLATENESS, RADIATION};
use super::sun_moon::{MOON, SUN, SunMoon};
use super::uncertain_radiation::Scale;
use super::vector::{Vector, cross, dot, plus, times};
use super::{Kind, Model, Quantity, Variable, carried_here, ecliptic, plane};

/// The averaged model in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vectorial {
    /// The parameters `C`, `W`, `A` and `B`.
    pub forces: SunMoon,
    /// Obliquity of the ecliptic \[rad\].
    pub obliquity: f64,
    /// Longitude of the Sun at `t = 0` \[rad\].
    pub sun_longitude: f64,
}

/// Solar angle, eccentricity, inclination and node.
pub const VARIABLES: [Variable; 4] = [
    plane::VARIABLES[0],
    plane::VARIABLES[1],
    Variable {
        name: "inclination",
        symbol: "i",
        unit: "rad",
        kind: Kind::Interval { low: 0.0, high: std::f64::consts::PI },
    },
    Variable { name: "node", symbol: "node", unit: "rad", kind: Kind::Circle },
];

/// The state: the components of `e`, then those of `h`.
pub type State<T = f64> = [T; 6];

/// The vectors of a state.
pub fn vectors<T: Copy>([e1, e2, e3, h1, h2, h3]: State<T>) -> (Vector<T>, Vector<T>) {
    ([e1, e2, e3], [h1, h2, h3])
}

impl Vectorial {
    /// Longitude of the Sun at a time \[yr\].
    pub(super) fn longitude<T: Quantity>(&self, time: T) -> T {
        time * SUN_MEAN_MOTION + self.sun_longitude
    }

    /// The parameters with their values.
    pub fn parameters(&self) -> [(Parameter, f64); 4] {
        let SunMoon { force, sun, moon } = self.forces;
        [(RADIATION, force.radiation), (OBLATENESS, force.oblateness), (SUN, sun), (MOON, moon)]
    }

    /// Time derivative of the state \[1/yr\] with another radiation parameter.
    ///
    /// Of `∂H/∂h` and `∂H/∂e`, the parts along `h` and along `e` turn the orbit in its plane alone. They are taken
    /// together as `in_plane`, the coefficient of `e × h` in `e'`.
    fn rate_with<T: Quantity>(&self, radiation: T, time: T, state: State<T>) -> State<T> {
        let SunMoon { force, sun, moon } = self.forces;
        self.rate_of([radiation, T::from(force.oblateness), T::from(sun), T::from(moon)], time, state)
    }

    /// Time derivative of the state \[1/yr\] with these parameters `C`, `W`, `A` and `B`.
    pub(super) fn rate_of<T: Quantity>(
        &self,
        [radiation, oblateness, sun, moon]: [T; 4],
        time: T,
        state: State<T>,
    ) -> State<T> {
        let (e, h) = vectors(state);
        let to_sun = ecliptic::direction(self.longitude(time).sin_cos(), self.obliquity);
        let pole = ecliptic::pole(self.obliquity).map(T::from);
        let h2 = dot(h, h);
        let inverse5 = T::from(1.0) / (h2 * h2 * h2.sqrt());
        let turning = h[2] * inverse5;
        let in_plane = (inverse5 - h[2] * turning * 5.0 / h2) * (oblateness * 0.5) + (sun * 4.0 - moon * 2.0);
        let by_e =
            plus(times(to_sun, dot(e, to_sun) * (sun * 10.0) + radiation), times(pole, dot(e, pole) * (moon * -5.0)));
        let mut by_h = plus(times(to_sun, dot(h, to_sun) * (sun * -2.0)), times(pole, dot(h, pole) * moon));
        by_h[2] = by_h[2] + turning * oblateness;
        let e_rate = plus(cross(e, plus(by_h, times(h, in_plane))), cross(h, by_e));
        let h_rate = plus(cross(h, by_h), cross(e, by_e));
        std::array::from_fn(|k| if k < 3 { e_rate[k] } else { h_rate[k - 3] } * SUN_MEAN_MOTION)
    }

    /// The Hamiltonian, which depends on time where the Sun acts on an orbit.
    pub fn hamiltonian(&self, time: f64, state: State) -> f64 {
        let SunMoon { force, sun, moon } = self.forces;
        let (e, h) = vectors(state);
        let to_sun = ecliptic::direction(self.longitude(time).sin_cos(), self.obliquity);
        let pole = ecliptic::pole(self.obliquity);
        let (e2, h2) = (dot(e, e), dot(h, h));
        let eta3 = h2 * h2.sqrt();
        let (along_e, along_h) = (dot(e, to_sun), dot(h, to_sun));
        force.radiation * along_e
            + force.oblateness / 6.0 * (3.0 * h[2] * h[2] / (h2 * eta3) - 1.0 / eta3)
            + sun * (5.0 * along_e * along_e - along_h * along_h - 2.0 * e2)
            + moon * (0.5 * e2 - 2.5 * dot(e, pole).powi(2) - 0.5 * h2 + 0.5 * dot(h, pole).powi(2))
    }
}

irradiated_carried_here!(Vectorial);

impl<S: Scale> Irradiated<S> for Vectorial {
    const WITH_RADIATION: &'static [Variable] = &[VARIABLES[0], VARIABLES[1], VARIABLES[2], VARIABLES[3], S::VARIABLE];

    fn rate_with<T: Quantity>(&self, radiation: T, time: T, state: State<T>) -> State<T> {
        self.rate_with(radiation, time, state)
    }

    #[inline(always)]
    fn irradiate<const P: usize>(series: &mut VectorialSeries<P>, lane: usize, radiation: f64) {
        series.irradiate(lane, radiation);
    }
}

impl Model for Vectorial {
    type State<T: Quantity> = State<T>;
    type Variables = [f64; 4];
    type Series<const P: usize> = VectorialSeries<P>;

    const VARIABLES: &'static [Variable] = &VARIABLES;
    const REENTRY: usize = 1;

    carried_here!();

    fn rate<T: Quantity>(&self, time: T, state: State<T>) -> State<T> {
        self.rate_with(T::from(self.forces.force.radiation), time, state)
    }

    fn is_inside(&self, state: State) -> bool {
        let (e, h) = vectors(state);
        dot(e, e) < 1.0 && dot(h, h) > 0.0
    }

    fn state(&self, time: f64, [phi, eccentricity, inclination, node]: [f64; 4]) -> State {
        let longitude_of_pericentre = phi + self.longitude(time);
        let Vectors { e, h } = Elements { eccentricity, inclination, node, longitude_of_pericentre }.vectors();
        std::array::from_fn(|k| if k < 3 { e[k] } else { h[k - 3] })
    }

    fn read_out(&self, time: f64, state: State) -> [f64; 4] {
        let (e, h) = vectors(state);
        let Elements { eccentricity, inclination, node, longitude_of_pericentre } = Vectors { e, h }.elements();
        [turn(longitude_of_pericentre - self.longitude(time)), eccentricity, inclination, node]
    }

    /// `h² = 1 - e²`, which falls as the eccentricity grows.
    fn clearance<T: Quantity>(&self, state: State<T>) -> T {
        let (_, h) = vectors(state);
        dot(h, h)
    }

    fn critical_clearance(&self, critical: f64) -> f64 {
        (1.0 - critical) * (1.0 + critical)
    }

    /// The measure is `e sin(i)` for each unit of the variables.
    fn density_growth(&self, start: State, end: State) -> Option<f64> {
        let measure = |state: State| {
            let (e, h) = vectors(state);
            (dot(e, e) / dot(h, h)).sqrt() * h[0].hypot(h[1])
        };
        Some(measure(end) / measure(start))
    }

    fn conserved(&self, _: f64, state: State) -> Vec<(&'static str, f64)> {
        let (e, h) = vectors(state);
        vec![("e² + h²", dot(e, e) + dot(h, h)), ("e·h", dot(e, h))]
    }
}

//! The paper's model with the gravity of the Sun and the Moon, in the plane.
//!
//! Both are taken as quadrupoles on circular orbits in the plane; the Moon's is averaged over its own revolution
//! (Hamilton & Krivov, Icarus 123, 1996, for the Sun). The Hamiltonian is that of [`super::planar`] plus
//!
//! ```text
//! (e²/2) [A (1 + 5 cos 2phi) + B] = ((6A + B) x2² + (B - 4A) x1²)/2
//! A = (3/4) n_sun/n      B = (3/4) (mu_moon/a_moon³)/(n n_sun)      n: mean motion of the satellite
//! ```
//!
//! so that with `x1 = e sin(phi)`, `x2 = e cos(phi)`, `s = sqrt(1 - e²)` and `g = W/s⁴ - 1`
//!
//! ```text
//! x1' =  n_sun (C s + x2 (g + (6A + B) s))
//! x2' = -n_sun x1 (g + (B - 4A) s)
//! e'  =  n_sun s sin(phi) (C + 10 A e cos(phi))
//! ```

use super::carried_here;
use super::earth::{self, SUN_MEAN_MOTION};
use super::parameter::{Named, Parameter};
use super::planar::{OBLATENESS, RADIATION, SrpJ2};
use super::plane::{PlanarHamiltonian, State, cosine_range, zero_between};
use super::quantity::Quantity;

use crate::flow::FromEquations;
use crate::problem_error::ProblemError;

/// Gravitational parameter of the Moon \[m³/s²\].
pub const MOON_MU: f64 = 4.9028e12;
/// Distance of the Moon \[m\].
pub const MOON_DISTANCE: f64 = 3.844e8;

/// Radiation pressure, oblateness, and the gravity of the Sun and the Moon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunMoon {
    /// Radiation and oblateness parameters.
    pub force: SrpJ2,
    /// The Sun's parameter `A`.
    pub sun: f64,
    /// The Moon's parameter `B`.
    pub moon: f64,
}

/// `A` as a scenario states it.
pub const SUN: Parameter = Parameter { name: "sun", symbol: "A", force: "sun", low: 0.0, high: 1.0 };
/// `B` as a scenario states it.
pub const MOON: Parameter = Parameter { name: "moon", symbol: "B", force: "moon", low: 0.0, high: 1.0 };

impl Named for SunMoon {
    const NAME: &'static str = "planar-sun-moon";
    const PARAMETERS: &'static [Parameter] = &[RADIATION, OBLATENESS, SUN, MOON];

    fn from_parameters(values: &[f64]) -> Option<Self> {
        let &[radiation, oblateness, sun, moon] = values else { return None };
        Some(Self { force: SrpJ2 { radiation, oblateness }, sun, moon })
    }

    fn of_satellite(semi_major_axis: f64, area_to_mass: f64, reflectivity: f64) -> Result<Self, ProblemError> {
        SrpJ2::from_orbit(semi_major_axis, area_to_mass, reflectivity).map(|force| Self::at(semi_major_axis, force))
    }
}

impl SunMoon {
    /// The Sun and the Moon as they act on a satellite with the given semi-major axis in Earth radii.
    pub fn at(semi_major_axis: f64, force: SrpJ2) -> Self {
        let (n, n_sun) = (earth::mean_motion(semi_major_axis), SUN_MEAN_MOTION / earth::YEAR);
        Self { force, sun: 0.75 * n_sun / n, moon: 0.75 * MOON_MU / MOON_DISTANCE.powi(3) / (n * n_sun) }
    }

    /// The same model with what `change` makes of each parameter and its value.
    pub fn changed(self, change: impl Fn(Parameter, f64) -> f64) -> Self {
        let Self { force: SrpJ2 { radiation, oblateness }, sun, moon } = self;
        let force = SrpJ2 { radiation: change(RADIATION, radiation), oblateness: change(OBLATENESS, oblateness) };
        Self { force, sun: change(SUN, sun), moon: change(MOON, moon) }
    }

    /// The forces that act, as `acts` says of each parameter's; the parameters of the others are 0.
    pub fn only(self, acts: impl Fn(&str) -> bool) -> Self {
        self.changed(|parameter, value| if acts(parameter.force) { value } else { 0.0 })
    }

    /// `B - 4A` and `6A + B`: the second derivatives of the added Hamiltonian with respect to `x1` and to `x2`.
    fn curvatures(&self) -> (f64, f64) {
        (self.moon - 4.0 * self.sun, 6.0 * self.sun + self.moon)
    }
}

impl PlanarHamiltonian for SunMoon {
    type Series<const P: usize> = FromEquations<Self, P>;

    carried_here!(carry_in_plane);

    fn motion<T: Quantity>(&self, state: State<T>) -> State<T> {
        let s = state.s();
        let g = T::from(self.force.oblateness) / s.powi(4) - 1.0;
        let (by_x1, by_x2) = self.curvatures();
        State {
            x1: (s * self.force.radiation + state.x2 * (g + s * by_x2)) * SUN_MEAN_MOTION,
            x2: state.x1 * (g + s * by_x1) * -SUN_MEAN_MOTION,
        }
    }

    fn hamiltonian(&self, state: State) -> f64 {
        let (by_x1, by_x2) = self.curvatures();
        self.force.hamiltonian(state) + 0.5 * (by_x2 * state.x2 * state.x2 + by_x1 * state.x1 * state.x1)
    }

    /// The added part is `5 A (e cos(phi))² + (B - 4A) e²/2`.
    fn hamiltonian_range(&self, phi: (f64, f64), e: (f64, f64)) -> (f64, f64) {
        let (low, high) = self.force.hamiltonian_range(phi, e);
        let (e_low, e_high) = (e.0.clamp(0.0, 1.0), e.1.clamp(0.0, 1.0));
        let cos = cosine_range(phi.0, phi.1);
        let least = if cos.0 <= 0.0 && cos.1 >= 0.0 { 0.0 } else { e_low * cos.0.abs().min(cos.1.abs()) };
        let most = e_high * cos.0.abs().max(cos.1.abs());
        let even = [e_low, e_high].map(|e| 0.5 * self.curvatures().0 * e * e);
        (
            low + 5.0 * self.sun * least * least + even[0].min(even[1]),
            high + 5.0 * self.sun * most * most + even[0].max(even[1]),
        )
    }

    fn parameters(&self) -> Vec<(Parameter, f64)> {
        [self.force.parameters(), vec![(SUN, self.sun), (MOON, self.moon)]].concat()
    }

    /// `C + 10 A` would bound the rate of the eccentricity itself; twice the Sun's part also bounds how that rate
    /// changes.
    fn pull(&self) -> f64 {
        self.force.pull() + 20.0 * self.sun
    }

    fn turning_rate(&self, state: State) -> f64 {
        self.force.turning_rate(state) + self.curvatures().1
    }

    fn eccentricity_follows_x1(&self) -> bool {
        self.sun == 0.0 || self.force.radiation > 10.0 * self.sun
    }

    fn slope_on_axis(&self, q: f64) -> f64 {
        self.force.slope_on_axis(q) + self.curvatures().1 * q
    }

    /// Where `x1` is not 0, `x2' = 0` says that `g + (B - 4A) s = 0`, and with that `x1' = 0` says that `x2 = -C/(10
    /// A)`.
    fn stationary_points_off_axis(&self) -> Vec<State> {
        const STEPS: u32 = 1000;
        if self.sun == 0.0 {
            return Vec::new();
        }
        let x2 = -self.force.radiation / (10.0 * self.sun);
        let excess = |s: f64| self.force.oblateness / s.powi(4) - 1.0 + self.curvatures().0 * s;
        // x1² = 1 - s² - x2² is positive.
        let highest = (1.0 - x2 * x2).max(0.0).sqrt();
        let node = |k: u32| (1e-6 + (1.0 - 1e-6) * f64::from(k) / f64::from(STEPS)) * highest;
        let changes = (0..STEPS).filter(|&k| excess(node(k)).signum() != excess(node(k + 1)).signum());
        let zeros = changes.map(|k| zero_between(excess, node(k), node(k + 1)));
        let x1 = zeros.map(|s| (1.0 - s * s - x2 * x2).max(0.0).sqrt()).filter(|x1| *x1 > 0.0);
        x1.flat_map(|x1| [State { x1, x2 }, State { x1: -x1, x2 }]).collect()
    }

    fn polar_rates(&self, phi: f64, e: f64) -> (f64, f64) {
        let (phi_rate, e_rate) = self.force.polar_rates(phi, e);
        let (sin, cos) = phi.sin_cos();
        let s = (1.0 - e * e).max(0.0).sqrt();
        let (by_x1, by_x2) = self.curvatures();
        (phi_rate + s * (by_x2 * cos * cos + by_x1 * sin * sin), e_rate + 10.0 * self.sun * s * e * sin * cos)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::Flow;
    use crate::model::acceleration;

    const FORCE: SrpJ2 = SrpJ2 { radiation: 0.15, oblateness: 0.40921 };
    const STRONG: SunMoon = SunMoon { force: FORCE, sun: 0.01, moon: 0.02 };

    fn states() -> impl Iterator<Item = (f64, f64)> {
        [(0.3, 0.2), (2.0, 0.6), (4.5, 0.8), (6.0, 1e-3)].into_iter()
    }

    #[test]
    fn a_weak_pull_leaves_points_off_the_axis_where_the_flow_stands_still() {
        let weak = SunMoon { force: SrpJ2 { radiation: 0.02, ..FORCE }, ..STRONG };
        let points = weak.stationary_points_off_axis();
        assert_eq!(points.len(), 2, "{points:?}");
        for point in points {
            assert!(point.x1.abs() > 0.1 && point.eccentricity() < 1.0, "{point:?}");
            let State { x1, x2 } = weak.motion(point);
            assert!(x1.abs() < 1e-12 && x2.abs() < 1e-12, "{point:?} moves by {x1} and {x2}");
        }
        assert_eq!(STRONG.stationary_points_off_axis(), [], "10 A is less than C");
    }

    #[test]
    fn parameters_at_two_and_a_half_earth_radii_are_those_of_the_reference() {
        let model = SunMoon::at(2.5, FORCE);
        assert!((model.sun / 4.76224231e-4 - 1.0).abs() < 1e-6, "{}", model.sun);
        assert!((model.moon / 1.036976367e-3 - 1.0).abs() < 1e-6, "{}", model.moon);
    }

    #[test]
    fn hamiltonian_is_constant_along_every_orbit() {
        for (phi, e) in states() {
            let start = State::from_polar(phi, e);
            let end = Flow::new(STRONG).advance_one(start, 2.0).unwrap();
            assert!((STRONG.hamiltonian(end) - STRONG.hamiltonian(start)).abs() < 1e-11);
        }
    }

    #[test]
    fn hamiltonian_range_encloses_the_hamiltonian() {
        for (phi, e) in [((0.2, 1.0), (0.1, 0.3)), ((2.0, 4.0), (0.0, 0.7)), ((-0.3, 0.4), (0.5, 0.9))] {
            let (low, high) = STRONG.hamiltonian_range(phi, e);
            for (i, j) in (0..21 * 21).map(|k| (f64::from(k / 21) / 20.0, f64::from(k % 21) / 20.0)) {
                let h = STRONG.hamiltonian(State::from_polar(phi.0 + i * (phi.1 - phi.0), e.0 + j * (e.1 - e.0)));
                assert!(h >= low - 1e-12 && h <= high + 1e-12, "{h} {low} {high}");
            }
        }
    }

    #[test]
    fn polar_rates_and_the_slope_on_the_axis_are_those_of_the_motion() {
        for (phi, e) in states() {
            let state = State::from_polar(phi, e);
            let State { x1, x2 } = STRONG.motion(state);
            let (phi_rate, e_rate) = STRONG.polar_rates(phi, e);
            let expected = ((x1 * phi.cos() - x2 * phi.sin()) / e, x1 * phi.sin() + x2 * phi.cos());
            assert!((SUN_MEAN_MOTION * phi_rate - expected.0).abs() < 1e-9 * (1.0 + expected.0.abs()));
            assert!((SUN_MEAN_MOTION * e_rate - expected.1).abs() < 1e-12);
            let on_axis = State { x1: 0.0, x2: state.x2 };
            let slope = STRONG.motion(on_axis).x1 / (SUN_MEAN_MOTION * on_axis.s());
            assert!((STRONG.slope_on_axis(state.x2) - slope).abs() < 1e-12);
        }
    }

    #[test]
    fn the_eccentricity_is_driven_by_no_more_than_the_pull() {
        for (phi, e) in states() {
            let state = State::from_polar(phi, e);
            let (_, e_rate) = STRONG.polar_rates(phi, e);
            assert!(e_rate.abs() <= STRONG.pull() * state.s());
            let [_, bend] = STRONG.eccentricity_squared_rates(state);
            let bound = STRONG.pull() * (2.0 * STRONG.pull() + STRONG.turning_rate(state) * e);
            assert!(bend.abs() <= 2.0 * SUN_MEAN_MOTION.powi(2) * bound, "{bend} {bound}");
            assert!(acceleration(&STRONG, 0.0, state).x1.is_finite());
        }
    }

    #[test]
    fn without_sun_and_moon_it_is_the_papers_model() {
        let model = SunMoon { force: FORCE, sun: 0.0, moon: 0.0 };
        let start = State::from_polar(2.2069, 0.145);
        let (here, there) = (Flow::new(model), Flow::new(FORCE));
        let (a, b) = (here.advance_one(start, 2.0).unwrap(), there.advance_one(start, 2.0).unwrap());
        assert!((a.x1 - b.x1).hypot(a.x2 - b.x2) < 1e-12);
    }
}

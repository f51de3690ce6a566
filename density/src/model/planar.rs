//! Secular dynamics of a planar orbit under solar radiation pressure and Earth's oblateness: the paper's model.
//!
//! The solar angle `phi` \[rad\] is the angle from the direction towards the Sun to the pericentre, `e` the
//! eccentricity. Averaged over an orbit they obey Eq. 1 of Sun et al. (2022), after Krivov & Getino (1997):
//!
//! ```text
//! e'   = n_sun  C sqrt(1 - e²) sin(phi)
//! phi' = n_sun (C sqrt(1 - e²)/e cos(phi) + W/(1 - e²)² - 1)
//! ```
//!
//! which is singular at `e = 0` only because polar coordinates are. In `x1 = e sin(phi)`, `x2 = e cos(phi)` it reads
//!
//! ```text
//! x1' = n_sun (C s + x2 g)      s = sqrt(1 - e²)
//! x2' = -n_sun x1 g             g = W/s⁴ - 1
//! ```
//!
//! and is regular everywhere inside the unit circle. The Hamiltonian is `H = s + C e cos(phi) + (W/3)/s³` (below Eq.
//! 3).
//!
//! Its Taylor series is the recurrence of [`super::planar_recurrence`].

use super::earth::{self, SUN_MEAN_MOTION};
use super::parameter::{Named, Parameter};
use super::planar_recurrence::Recurrence;
use super::plane::{PlanarHamiltonian, State, cosine_range};
use super::quantity::Quantity;
use super::{Lanes, Series, carried_here};
use crate::problem_error::{Field, ProblemError, check};

/// Solar radiation pressure and Earth's oblateness, by the two dimensionless parameters of the problem (Eq. 2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SrpJ2 {
    /// Radiation parameter `C`.
    pub radiation: f64,
    /// Oblateness parameter `W`.
    pub oblateness: f64,
}

impl Named for SrpJ2 {
    const NAME: &'static str = "planar";
    const PARAMETERS: &'static [Parameter] = &[RADIATION, OBLATENESS];

    fn from_parameters(values: &[f64]) -> Option<Self> {
        let &[radiation, oblateness] = values else { return None };
        Some(Self { radiation, oblateness })
    }

    fn of_satellite(semi_major_axis: f64, area_to_mass: f64, reflectivity: f64) -> Result<Self, ProblemError> {
        Self::from_orbit(semi_major_axis, area_to_mass, reflectivity)
    }
}

/// `C` as a scenario states it.
pub const RADIATION: Parameter = Parameter { name: "radiation", symbol: "C", force: "srp", low: 0.0, high: 100.0 };
/// `W` as a scenario states it.
pub const OBLATENESS: Parameter = Parameter { name: "oblateness", symbol: "W", force: "j2", low: 0.0, high: 100.0 };

impl PlanarHamiltonian for SrpJ2 {
    type Series<const P: usize> = PlanarSeries<P>;

    carried_here!(carry_in_plane);

    /// Eq. 7, with Eq. 1 inserted.
    fn motion<T: Quantity>(&self, state: State<T>) -> State<T> {
        let s = state.s();
        let g = T::from(self.oblateness) / s.powi(4) - 1.0;
        State { x1: (s * self.radiation + state.x2 * g) * SUN_MEAN_MOTION, x2: state.x1 * -SUN_MEAN_MOTION * g }
    }

    fn hamiltonian(&self, state: State) -> f64 {
        let s = state.s();
        s + self.radiation * state.x2 + self.oblateness / (3.0 * s.powi(3))
    }

    fn hamiltonian_range(&self, phi: (f64, f64), e: (f64, f64)) -> (f64, f64) {
        let (e_low, e_high) = (e.0.clamp(0.0, 1.0), e.1.clamp(0.0, 1.0));
        let cos = cosine_range(phi.0, phi.1);
        let products = [e_low * cos.0, e_low * cos.1, e_high * cos.0, e_high * cos.1];
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        products.iter().for_each(|&p| (low, high) = (low.min(p), high.max(p)));
        // s + (W/3)/s³ is convex in s, with its minimum at s⁴ = W.
        let even = |s: f64| s + self.oblateness / (3.0 * s.powi(3));
        let (s_low, s_high) = ((1.0 - e_high * e_high).sqrt(), (1.0 - e_low * e_low).sqrt());
        let even_high = if s_low > 0.0 || self.oblateness > 0.0 { even(s_low).max(even(s_high)) } else { s_high };
        let even_low =
            even(self.oblateness.sqrt().sqrt().clamp(s_low.max(f64::MIN_POSITIVE), s_high.max(f64::MIN_POSITIVE)));
        (even_low + self.radiation * low, even_high + self.radiation * high)
    }

    fn parameters(&self) -> Vec<(Parameter, f64)> {
        vec![(RADIATION, self.radiation), (OBLATENESS, self.oblateness)]
    }

    fn pull(&self) -> f64 {
        self.radiation
    }

    fn turning_rate(&self, state: State) -> f64 {
        (self.oblateness / state.s().powi(4) - 1.0).abs()
    }

    /// `e' = n_sun C s sin(phi)` (Eq. 1), and `C` is not negative.
    fn eccentricity_follows_x1(&self) -> bool {
        true
    }

    fn pace(&self, state: State) -> f64 {
        1.0 + self.radiation + self.oblateness / state.s().powi(4)
    }

    fn slope_on_axis(&self, q: f64) -> f64 {
        let s = ((1.0 - q) * (1.0 + q)).sqrt();
        self.radiation + q * (self.oblateness / s.powi(4) - 1.0) / s
    }

    fn polar_rates(&self, phi: f64, e: f64) -> (f64, f64) {
        let (sin, cos) = phi.sin_cos();
        let s2 = (1.0 - e * e).max(f64::MIN_POSITIVE);
        let s = s2.sqrt();
        let drift = self.oblateness / (s2 * s2) - 1.0;
        (self.radiation * s * cos / e.max(f64::MIN_POSITIVE) + drift, self.radiation * s * sin)
    }

    /// `(e²)' = 2 n_sun C s x1`, since `s' = -n_sun C x1`.
    fn eccentricity_squared_rates(&self, state: State) -> [f64; 2] {
        let scale = 2.0 * SUN_MEAN_MOTION * self.radiation;
        let s = state.s();
        let s_rate = -SUN_MEAN_MOTION * self.radiation * state.x1;
        [scale * s * state.x1, scale * (s * self.motion(state).x1 + s_rate * state.x1)]
    }
}

impl SrpJ2 {
    /// Eq. 2: `C` and `W` from the satellite's orbit and shape. All arguments must be in their ranges.
    ///
    /// # Errors
    /// [`ProblemError`] with the first argument that is not.
    pub fn from_orbit(semi_major_axis: f64, area_to_mass: f64, reflectivity: f64) -> Result<Self, ProblemError> {
        let given = |name, value, is_right, right: &str| check(Field::Parameter(name), value, is_right, right.into());
        let larger_than_earth = semi_major_axis > 1.0 && semi_major_axis <= 100.0;
        given("semi_major_axis", semi_major_axis, larger_than_earth, "more than 1 Earth radius, at most 100")?;
        let is_right = (0.0..=1000.0).contains(&area_to_mass);
        given("area_to_mass", area_to_mass, is_right, "0 or greater, at most 1000 m²/kg")?;
        given("reflectivity", reflectivity, (0.0..=2.0).contains(&reflectivity), "between 0 and 2")?;
        Ok(force_from_orbit(semi_major_axis, area_to_mass, reflectivity))
    }
}

/// Eq. 2: `C` and `W` from the satellite's orbit and shape.
///
/// `semi_major_axis` is in Earth radii and `area_to_mass` in m²/kg. `reflectivity` is the dimensionless coefficient
/// that multiplies the solar radiation pressure (1 absorbs all light, 2 reflects it all back).
pub fn force_from_orbit(semi_major_axis: f64, area_to_mass: f64, reflectivity: f64) -> SrpJ2 {
    let a = semi_major_axis * earth::RADIUS;
    let mean_motion = earth::mean_motion(semi_major_axis);
    let sun_mean_motion = SUN_MEAN_MOTION / earth::YEAR;
    let ratio = earth::SOLAR_FLUX * a * a * area_to_mass * reflectivity / (earth::MU * earth::LIGHT_SPEED);
    SrpJ2 {
        radiation: 1.5 * ratio * mean_motion / sun_mean_motion,
        oblateness: 1.5 * earth::J2 * (earth::RADIUS / a).powi(2) * mean_motion / sun_mean_motion,
    }
}

/// The series of the planar model: all orbits have the same radiation parameter.
#[derive(Debug)]
pub struct PlanarSeries<const P: usize>(Recurrence<P, f64>);

impl<const P: usize> Series<P> for PlanarSeries<P> {
    type Model = SrpJ2;

    #[inline(always)]
    fn new(force: &SrpJ2) -> Self {
        Self(Recurrence::new(force.radiation, force.oblateness))
    }

    #[inline(always)]
    fn start(&mut self, lane: usize, state: State, _: f64) {
        self.0.start(lane, state);
    }

    #[inline(always)]
    fn expand(&mut self, _: bool) {
        self.0.expand();
    }

    #[inline(always)]
    fn move_on(&mut self, step: &Lanes) {
        self.0.move_on(step);
    }

    #[inline(always)]
    fn is_inside(&self, lane: usize) -> bool {
        self.0.is_inside(lane)
    }

    #[inline(always)]
    fn coordinate(&self, k: usize) -> &[Lanes; P] {
        if k == 0 { &self.0.x1 } else { &self.0.x2 }
    }

    /// The clearance is `s` itself.
    #[inline(always)]
    fn clearance(&self) -> &[Lanes; P] {
        &self.0.s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Model;

    const PAPER: SrpJ2 = SrpJ2 { radiation: 0.15, oblateness: 0.40921 };

    #[test]
    fn hamiltonian_flow_is_tangent_to_its_contours() {
        for (phi, e) in [(0.3, 0.2), (2.0, 0.6), (4.5, 0.8), (6.0, 1e-8)] {
            let state = State::from_polar(phi, e);
            let rate = PAPER.motion(state);
            let h = 1e-6;
            let along = |sign: f64| {
                PAPER.hamiltonian(State { x1: state.x1 + sign * h * rate.x1, x2: state.x2 + sign * h * rate.x2 })
            };
            assert!((along(1.0) - along(-1.0)).abs() < 1e-11);
        }
    }

    #[test]
    fn divergence_is_the_negative_of_the_bracket_in_eq_8() {
        let state = State::from_polar(2.0, 0.6);
        let expected = -SUN_MEAN_MOTION * PAPER.radiation * state.x1 / state.s();
        assert!((PAPER.divergence(0.0, state) - expected).abs() < 1e-13);
    }

    #[test]
    fn stationary_points_are_those_of_the_papers_phase_portrait() {
        let found: Vec<(f64, f64)> = PAPER.stationary_points().iter().map(|&p| (p.x2, PAPER.hamiltonian(p))).collect();
        let expected = [(-0.641096, 0.973053), (0.277260, 1.156176), (0.509659, 1.150996)];
        assert_eq!(found.len(), expected.len());
        for ((x2, h), (expected_x2, expected_h)) in found.iter().zip(expected) {
            assert!((x2 - expected_x2).abs() < 1e-6 && (h - expected_h).abs() < 1e-6, "{x2} {h}");
        }
    }

    #[test]
    fn oblateness_at_two_and_a_half_earth_radii_is_the_papers() {
        // The paper does not print its constants; those above give 0.409204, one unit of the fifth digit away.
        let force = force_from_orbit(2.5, 10.0, 1.0);
        assert!((force.oblateness - 0.40921).abs() < 1e-5, "{}", force.oblateness);
    }
}

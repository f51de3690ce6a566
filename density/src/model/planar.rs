//! Secular dynamics of a planar orbit under solar radiation pressure and Earth's oblateness: the paper's model.
//!
//! The solar angle `phi` \[rad\] is the angle from the direction towards the Sun to the pericentre, `e` the eccentricity.
//! Averaged over an orbit they obey Eq. 1 of Sun et al. (2022), after Krivov & Getino (1997):
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
//! and is regular everywhere inside the unit circle. The Hamiltonian is `H = s + C e cos(phi) + (W/3)/s³` (below Eq. 3).
//!
//! # The Taylor recurrence, written out for speed
//!
//! With `s = sqrt(1 - e²)` as a third variable and `p = s⁻⁴`, in the time unit `1/n_sun` the equations of motion are
//!
//! ```text
//! x1' = C s + W x2 p - x2,   x2' = x1 - W x1 p,   s' = -C x1,   s p' = 4 C x1 p
//! ```
//!
//! so the Taylor coefficients of all four follow from three Cauchy products per order (`x1 p`, `x2 p`, `s p`), without a
//! square root and with one division per step. The conserved `H` would remove a variable, but no product: with `s` alone,
//! `s'' = (H - h(s)) h'(s) - C² s` needs three products as well, and `x2 = (H - h(s))/C` loses digits where `C` is small.
//!
//! The coefficients are aligned to cache lines: loads that straddle two cost a quarter of the speed.

use super::earth::{self, SUN_MEAN_MOTION};
use super::parameter::{Named, Parameter};
use super::plane::{PlanarHamiltonian, State, cosine_range};
use super::quantity::Quantity;
use super::{LANES, Lanes, Series};
use crate::problem_error::{Field, ProblemError, check};

/// The two dimensionless parameters of the problem (Eq. 2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Force {
    /// Radiation parameter `C`.
    pub radiation: f64,
    /// Oblateness parameter `W`.
    pub oblateness: f64,
}

impl Named for Force {
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

impl PlanarHamiltonian for Force {
    type Series<const P: usize> = PlanarSeries<P>;

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

impl Force {
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
pub fn force_from_orbit(semi_major_axis: f64, area_to_mass: f64, reflectivity: f64) -> Force {
    let a = semi_major_axis * earth::RADIUS;
    let mean_motion = earth::mean_motion(semi_major_axis);
    let sun_mean_motion = SUN_MEAN_MOTION / earth::YEAR;
    let ratio = earth::SOLAR_FLUX * a * a * area_to_mass * reflectivity / (earth::MU * earth::LIGHT_SPEED);
    Force {
        radiation: 1.5 * ratio * mean_motion / sun_mean_motion,
        oblateness: 1.5 * earth::J2 * (earth::RADIUS / a).powi(2) * mean_motion / sun_mean_motion,
    }
}

/// Taylor coefficients of [`LANES`] orbits; those of order 0 are the states.
#[derive(Debug)]
#[repr(C, align(64))]
pub struct PlanarSeries<const P: usize> {
    x1: [Lanes; P],
    x2: [Lanes; P],
    s: [Lanes; P],
    p: [Lanes; P],
    force: Force,
}

impl<const P: usize> PlanarSeries<P> {
    const ORDER: usize = P - 1;

    /// Puts orbits that have reached `e = 1` within a step outside the range of the equations. Without oblateness the
    /// equations turn `(x1, x2, s)` about `(0, C, 1)` and lead on beyond `e = 1`, where `s` is negative and the orbit
    /// is no longer one of a satellite; nothing else in the series shows this. An orbit is put outside if it has passed
    /// its most eccentric point within the step, where `x1` changes its sign, and had `s < 0` there.
    fn end_where_e_was_one(&mut self, before: &Lanes, step: &Lanes) {
        let radiation = self.force.radiation;
        for l in 0..LANES {
            let (x1, x2, s) = (self.x1[0][l], self.x2[0][l], self.s[0][l]);
            let has_passed = before[l] * step[l] > 0.0 && x1 * step[l] <= 0.0;
            // The axis has the length N, and the state lies at the distance d along it. So the least s is
            // (d - C sqrt(1 - d²))/N.
            let along = (s + radiation * x2) / (1.0 + radiation * radiation).sqrt();
            if has_passed && along < radiation * (1.0 - along * along).max(0.0).sqrt() {
                self.s[0][l] = f64::NAN;
            }
        }
    }
}

impl<const P: usize> Series<P> for PlanarSeries<P> {
    type Model = Force;

    #[inline(always)]
    fn new(force: &Force) -> Self {
        let zeros = [[0.0; LANES]; P];
        Self { x1: zeros, x2: zeros, s: [[1.0; LANES]; P], p: zeros, force: *force }
    }

    #[inline(always)]
    fn start(&mut self, lane: usize, state: State, _: f64) {
        (self.x1[0][lane], self.x2[0][lane], self.s[0][lane]) = (state.x1, state.x2, state.s());
    }

    #[inline(always)]
    fn expand(&mut self, _: bool) {
        let Self { x1, x2, s, p, force: Force { radiation, oblateness } } = self;
        let (radiation, oblateness) = (*radiation, *oblateness);
        let mut inverse_s = [0.0; LANES];
        for l in 0..LANES {
            inverse_s[l] = 1.0 / s[0][l];
            let square = inverse_s[l] * inverse_s[l];
            p[0][l] = square * square;
        }
        for n in 0..Self::ORDER {
            let (mut x1p, mut x2p, mut sp) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
            for l in 0..LANES {
                x1p[l] = x1[n][l] * p[0][l];
                x2p[l] = x2[n][l] * p[0][l];
            }
            for j in 0..n {
                for l in 0..LANES {
                    x1p[l] = x1[j][l].mul_add(p[n - j][l], x1p[l]);
                    x2p[l] = x2[j][l].mul_add(p[n - j][l], x2p[l]);
                    sp[l] = s[j + 1][l].mul_add(p[n - j][l], sp[l]);
                }
            }
            let next = 1.0 / (n + 1) as f64;
            for l in 0..LANES {
                let drift = radiation.mul_add(s[n][l], -x2[n][l]);
                s[n + 1][l] = -radiation * next * x1[n][l];
                x1[n + 1][l] = next * oblateness.mul_add(x2p[l], drift);
                x2[n + 1][l] = next * (-oblateness).mul_add(x1p[l], x1[n][l]);
                sp[l] = s[n + 1][l].mul_add(p[0][l], sp[l]);
                p[n + 1][l] = inverse_s[l] * (3.0 * radiation * next).mul_add(x1p[l], -sp[l]);
            }
        }
    }

    #[inline(always)]
    fn move_on(&mut self, step: &Lanes) {
        let (mut x1, mut x2, mut s) = (self.x1[Self::ORDER], self.x2[Self::ORDER], self.s[Self::ORDER]);
        for n in (0..Self::ORDER).rev() {
            for l in 0..LANES {
                x1[l] = x1[l].mul_add(step[l], self.x1[n][l]);
                x2[l] = x2[l].mul_add(step[l], self.x2[n][l]);
                s[l] = s[l].mul_add(step[l], self.s[n][l]);
            }
        }
        let before = self.x1[0];
        (self.x1[0], self.x2[0], self.s[0]) = (x1, x2, s);
        if self.force.oblateness == 0.0 {
            self.end_where_e_was_one(&before, step);
        }
    }

    #[inline(always)]
    fn is_inside(&self, lane: usize) -> bool {
        let (x1, x2) = (self.x1[0][lane], self.x2[0][lane]);
        self.s[0][lane] > 0.0 && x1 * x1 + x2 * x2 < 1.0
    }

    #[inline(always)]
    fn coordinate(&self, k: usize) -> &[Lanes; P] {
        if k == 0 { &self.x1 } else { &self.x2 }
    }

    /// The clearance is `s` itself.
    #[inline(always)]
    fn clearance(&self) -> &[Lanes; P] {
        &self.s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Model;

    const PAPER: Force = Force { radiation: 0.15, oblateness: 0.40921 };

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

//! Secular dynamics of a planar orbit under solar radiation pressure and Earth's oblateness.
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
//! and is regular everywhere inside the unit circle. All propagation happens in `(x1, x2)`; `(phi, e)` are read out at
//! snapshots. Time is in years, the Sun moves by 2π a year.

use std::f64::consts::{PI, TAU};

/// Mean motion of the Sun \[rad/yr\].
pub const SUN_MEAN_MOTION: f64 = TAU;

/// The two dimensionless parameters of the problem (Eq. 2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Force {
    /// Radiation parameter `C`.
    pub radiation: f64,
    /// Oblateness parameter `W`.
    pub oblateness: f64,
}

/// An orbit in coordinates that are regular at zero eccentricity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// `e sin(phi)`.
    pub x1: f64,
    /// `e cos(phi)`.
    pub x2: f64,
}

impl State {
    /// The state at solar angle `phi` \[rad\] and eccentricity `e`.
    pub fn from_polar(phi: f64, e: f64) -> Self {
        let (sin, cos) = phi.sin_cos();
        Self { x1: e * sin, x2: e * cos }
    }

    /// Solar angle in `[0, 2π)` \[rad\].
    pub fn solar_angle(self) -> f64 {
        let phi = self.x1.atan2(self.x2);
        if phi < 0.0 { (phi + TAU).min(TAU.next_down()) } else { phi }
    }

    /// Eccentricity.
    pub fn eccentricity(self) -> f64 {
        (self.x1 * self.x1 + self.x2 * self.x2).sqrt()
    }

    /// `sqrt(1 - e²)`.
    pub fn s(self) -> f64 {
        (1.0 - self.x1 * self.x1 - self.x2 * self.x2).sqrt()
    }
}

impl Force {
    /// Time derivatives of `(x1, x2)` \[1/yr\] (Eq. 7 with Eq. 1 inserted).
    pub fn rate(self, state: State) -> State {
        let s = state.s();
        let g = self.oblateness / s.powi(4) - 1.0;
        State { x1: SUN_MEAN_MOTION * (self.radiation * s + state.x2 * g), x2: -SUN_MEAN_MOTION * state.x1 * g }
    }

    /// The Hamiltonian `H = s + C e cos(phi) + (W/3)/s³` (below Eq. 3), constant along every trajectory.
    pub fn hamiltonian(self, state: State) -> f64 {
        let s = state.s();
        s + self.radiation * state.x2 + self.oblateness / (3.0 * s.powi(3))
    }

    /// Divergence of the flow in the `(x1, x2)` plane \[1/yr\]; the negative of the bracket in Eq. 8.
    pub fn divergence(self, state: State) -> f64 {
        -SUN_MEAN_MOTION * self.radiation * state.x1 / state.s()
    }

    /// Points where the flow stands still, ordered by `e cos(phi)`: zeros of `dH/dx2` on the axis `phi = 0` or `π`.
    /// (`e = 0` is a kink of the polar phase portrait, not an equilibrium of the flow, unless `C = 0`.)
    pub fn stationary_points(self) -> Vec<State> {
        let rate = |x2: f64| self.rate(State { x1: 0.0, x2 }).x1;
        let steps = 4000;
        let node = |i: usize| (f64::from(i as u32) / f64::from(steps as u32) * 2.0 - 1.0) * (1.0 - 1e-9);
        (0..steps)
            .filter(|&i| rate(node(i)).signum() != rate(node(i + 1)).signum())
            .map(|i| State { x1: 0.0, x2: bisect(rate, node(i), node(i + 1)) })
            .collect()
    }
}

/// The root of `f` between two points of opposite sign, to the last bit.
fn bisect(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let sign = f(low).signum();
    while low.midpoint(high) != low && low.midpoint(high) != high {
        let middle = low.midpoint(high);
        if f(middle).signum() == sign { low = middle } else { high = middle }
    }
    low
}

/// Factor by which a density per unit `phi`-`e` area has changed after the flow carried it from `start` to `end`:
/// `n(end)/n(start) = [e_t/s_t] / [e_0/s_0]`.
///
/// The flow keeps the measure `e/s dphi de` (Eq. 3 is quasi-canonical), which is the integral of Eq. 8 with the Jacobian
/// `e` of the polar coordinates. The paper leaves that Jacobian out, see [`density_growth_without_jacobian`].
pub fn density_growth(start: State, end: State) -> f64 {
    density_growth_without_jacobian(start, end) * end.eccentricity() / start.eccentricity()
}

/// As [`density_growth`], for a density per unit `x1`-`x2` area: `s_0/s_t`. Using it for densities per `phi`-`e` area is the
/// paper's first error (the `as-printed` mode reproduces it).
pub fn density_growth_without_jacobian(start: State, end: State) -> f64 {
    start.s() / end.s()
}

/// Eq. 2: `C` and `W` from the satellite's orbit and shape.
///
/// `semi_major_axis` in Earth radii, `area_to_mass` in m²/kg, `reflectivity` the dimensionless coefficient that multiplies
/// the solar radiation pressure (1 absorbs all light, 2 reflects it all back).
pub fn force_from_orbit(semi_major_axis: f64, area_to_mass: f64, reflectivity: f64) -> Force {
    let a = semi_major_axis * earth::RADIUS;
    let mean_motion = (earth::MU / a.powi(3)).sqrt();
    let sun_mean_motion = 2.0 * PI / earth::YEAR;
    let ratio = earth::SOLAR_FLUX * a * a * area_to_mass * reflectivity / (earth::MU * earth::LIGHT_SPEED);
    Force {
        radiation: 1.5 * ratio * mean_motion / sun_mean_motion,
        oblateness: 1.5 * earth::J2 * (earth::RADIUS / a).powi(2) * mean_motion / sun_mean_motion,
    }
}

/// Constants of Eq. 2, SI units.
pub mod earth {
    /// Equatorial radius \[m\] (WGS 84).
    pub const RADIUS: f64 = 6_378_137.0;
    /// Gravitational parameter \[m³/s²\] (WGS 84).
    pub const MU: f64 = 3.986_004_418e14;
    /// Second zonal harmonic (EGM 96).
    pub const J2: f64 = 1.082_626_68e-3;
    /// Solar flux at 1 AU \[W/m²\] (IAU 2015 nominal total irradiance).
    pub const SOLAR_FLUX: f64 = 1361.0;
    /// Speed of light \[m/s\].
    pub const LIGHT_SPEED: f64 = 299_792_458.0;
    /// Sidereal year \[s\] (IERS).
    pub const YEAR: f64 = 365.256_363 * 86_400.0;
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAPER: Force = Force { radiation: 0.15, oblateness: 0.40921 };

    #[test]
    fn hamiltonian_flow_is_tangent_to_its_contours() {
        for (phi, e) in [(0.3, 0.2), (2.0, 0.6), (4.5, 0.8), (6.0, 1e-8)] {
            let state = State::from_polar(phi, e);
            let rate = PAPER.rate(state);
            let h = 1e-6;
            let along = |sign: f64| {
                PAPER.hamiltonian(State { x1: state.x1 + sign * h * rate.x1, x2: state.x2 + sign * h * rate.x2 })
            };
            assert!((along(1.0) - along(-1.0)).abs() < 1e-11);
        }
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

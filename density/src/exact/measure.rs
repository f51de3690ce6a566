//! The initial probability measure on the cylinder of `phi` and `0 < e < 1`, and the one-form whose circulation measures it.
//!
//! The initial Gaussian is independent in `phi` and `e`. On the circle, `phi` has the wrapped normal density `w` (Mardia &
//! Jupp, *Directional Statistics*, 2000, Sect. 3.5.7), and `e` the truncated normal density `g` with distribution function
//! `G(e)`. By Green's theorem the probability of a region `D` of the disc is
//!
//! ```text
//! P(D) = ∮_∂D G(e) w(phi) dphi ,     phi increasing along the outer edge of D,
//! ```
//!
//! also when `D` holds the origin, since `G(0) = 0`. A flow carries `D`'s boundary along with `D`, so the probability of any
//! region at any time is an integral along ONE curve, smooth in its parameter: the two-dimensional quadrature of a cloud that
//! is stretched into a thin thread becomes a one-dimensional one.

use std::f64::consts::{PI, SQRT_2, TAU};

use crate::angle::nearest;
use crate::model::plane::{State, density_growth};
use crate::problem::InitialGaussian;

/// Standard deviations from the mean beyond which a Gaussian counts as zero: its tail there is 1e-19.
pub(super) const REACH: f64 = 9.0;

/// The initial Gaussian with the constants that its evaluation needs.
#[derive(Debug, Clone, Copy)]
pub struct Measure {
    /// The Gaussian it stands for.
    pub gaussian: InitialGaussian,
    mass: f64,
    below_zero: f64,
    turns: i32,
}

/// Probability that a standard normal variable exceeds `z`.
pub(crate) fn normal_tail(z: f64) -> f64 {
    0.5 * libm::erfc(z / SQRT_2)
}

pub(super) fn normal_density(z: f64) -> f64 {
    (-0.5 * z * z).exp() / TAU.sqrt()
}

impl Measure {
    /// The measure of `gaussian`, cut to `0 < e < 1`.
    pub fn new(gaussian: InitialGaussian) -> Self {
        let below_zero = normal_tail(gaussian.mean_e / gaussian.sigma_e);
        let above_one = normal_tail((1.0 - gaussian.mean_e) / gaussian.sigma_e);
        let turns = ((REACH * gaussian.sigma_phi - PI) / TAU).ceil().max(0.0) as i32;
        Self { gaussian, mass: 1.0 - below_zero - above_one, below_zero, turns }
    }

    /// Signed distance of `phi` from the mean on the circle, in standard deviations.
    pub fn phi_sigmas(&self, phi: f64) -> f64 {
        (nearest(phi, self.gaussian.mean_phi) - self.gaussian.mean_phi) / self.gaussian.sigma_phi
    }

    /// Distance of `e` from the mean, in standard deviations.
    pub fn e_sigmas(&self, e: f64) -> f64 {
        (e - self.gaussian.mean_e) / self.gaussian.sigma_e
    }

    /// A full turn of `phi` in standard deviations.
    pub fn turn_sigmas(&self) -> f64 {
        TAU / self.gaussian.sigma_phi
    }

    /// Density `w` of the solar angle on the circle \[1/rad\], `u` from [`Measure::phi_sigmas`].
    pub fn phi_density(&self, u: f64) -> f64 {
        let turn = self.turn_sigmas();
        let images = (-self.turns..=self.turns).map(|k| normal_density(u + f64::from(k) * turn));
        images.sum::<f64>() / self.gaussian.sigma_phi
    }

    /// Probability that the solar angle lies between `from` and `to` \[rad\]. `from <= to` are at most one turn apart,
    /// and `to` is at most one turn above the point opposite the mean.
    pub fn phi_between(&self, from: f64, to: f64) -> f64 {
        let (mean, sigma) = (self.gaussian.mean_phi, self.gaussian.sigma_phi);
        let turns = self.turns + 2;
        (-turns..=turns)
            .map(|k| {
                let [a, b] = [from, to].map(|phi| (phi + TAU * f64::from(k) - mean) / sigma);
                if a > 0.0 { normal_tail(a) - normal_tail(b) } else { normal_tail(-b) - normal_tail(-a) }
            })
            .sum()
    }

    /// Probability that the eccentricity is below the value `v` standard deviations from the mean.
    pub fn e_probability(&self, v: f64) -> f64 {
        ((normal_tail(-v) - self.below_zero) / self.mass).clamp(0.0, 1.0)
    }

    /// Initial density at a state \[1/rad\], summed over all turns of the solar angle; zero outside `0 < e < 1`.
    pub fn density(&self, state: State) -> f64 {
        let e = state.eccentricity();
        if !(e > 0.0 && e < 1.0) {
            return 0.0;
        }
        let e_density = normal_density(self.e_sigmas(e)) / (self.gaussian.sigma_e * self.mass);
        self.phi_density(self.phi_sigmas(state.solar_angle())) * e_density
    }

    /// Density at `end` \[1/rad\] of the cloud whose orbit through `end` began at `start`; zero if `start` is NaN (no
    /// such orbit).
    pub fn density_after(&self, start: State, end: State) -> f64 {
        let initial = self.density(start);
        if initial > 0.0 { initial * density_growth(start, end) } else { 0.0 }
    }

    /// The smallest length over which the measure varies in the `(x1, x2)` plane near its mean.
    pub fn scale(&self) -> f64 {
        let e = self.gaussian.mean_e.max(self.gaussian.sigma_e);
        self.gaussian.sigma_e.min(e * self.gaussian.sigma_phi.min(1.0))
    }
}

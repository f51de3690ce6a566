//! The initial probability measure on the cylinder of `phi` and `0 < e < 1`, and the one-form whose circulation
//! measures it.
//!
//! On the circle, the solar angle of a cloud in which `phi` and `e` are independent has the wrapped normal density `w`
//! (Mardia & Jupp, *Directional Statistics*, 2000, Sect. 3.5.7), and `e` the truncated normal density with distribution
//! function `G`. In general let `F(phi, e)` be the density of the solar angle together with an eccentricity below `e`:
//! `G(e) w(phi)` if they are independent, and otherwise a sum over the turns of the circle of a normal density of `phi`
//! times the distribution function of `e` given `phi`. By Green's theorem the probability of a region `D` of the disc
//! is
//!
//! ```text
//! P(D) = ∮_∂D F(phi, e) dphi ,     phi increasing along the outer edge of D,
//! ```
//!
//! also when `D` holds the origin, since `F(phi, 0) = 0`. A flow carries `D`'s boundary along with `D`, so the
//! probability of any region at any time is an integral along ONE curve, smooth in its parameter: the two-dimensional
//! quadrature of a cloud that is stretched into a thin thread becomes a one-dimensional one.

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

pub(crate) fn normal_density(z: f64) -> f64 {
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

    /// The standardised coordinates ([`InitialGaussian::standardise`]) of the point `(phi, e)`, with `phi` on the turn
    /// on which it is nearest to its mean given `e`.
    pub fn standardise(&self, phi: f64, e: f64) -> (f64, f64) {
        let v = self.e_sigmas(e);
        let mean = self.gaussian.mean_phi_given(v);
        ((nearest(phi, mean) - mean) / self.gaussian.sigma_phi_given_e(), v)
    }

    /// A full turn of `phi` in the standardised coordinate `u`.
    pub fn turn(&self) -> f64 {
        TAU / self.gaussian.sigma_phi_given_e()
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

    /// The sum of the standard normal density over all turns of the circle, from a distance in standard deviations.
    fn over_turns(&self, sigmas: f64, turn: f64) -> f64 {
        (-self.turns..=self.turns).map(|k| normal_density(sigmas + f64::from(k) * turn)).sum()
    }

    /// `F(phi, e)` of the [module](self), per standard deviation of the solar angle, from the distances of both
    /// variables from their means in standard deviations, [`Measure::phi_sigmas`] and [`Measure::e_sigmas`].
    pub fn below(&self, phi_sigmas: f64, e_sigmas: f64) -> f64 {
        let rho = self.gaussian.correlation;
        if rho == 0.0 {
            return self.over_turns(phi_sigmas, self.turn_sigmas()) * self.e_probability(e_sigmas);
        }
        // The distribution of `e` given `phi` is normal, with the mean and deviation of a regression (Anderson 2003,
        // Sect. 2.5).
        let (deviation, at_zero) = ((1.0 - rho * rho).sqrt(), -self.gaussian.mean_e / self.gaussian.sigma_e);
        let turn = self.turn_sigmas();
        let term = |k: i32| {
            let phi = phi_sigmas + f64::from(k) * turn;
            let [zero, e] = [at_zero, e_sigmas].map(|v| (v - rho * phi) / deviation);
            let share =
                if zero > 0.0 { normal_tail(zero) - normal_tail(e) } else { normal_tail(-e) - normal_tail(-zero) };
            normal_density(phi) * share.max(0.0)
        };
        (-self.turns..=self.turns).map(term).sum::<f64>() / self.mass
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
        let (u, v) = self.standardise(state.solar_angle(), e);
        let e_density = normal_density(v) / (self.gaussian.sigma_e * self.mass);
        self.over_turns(u, self.turn()) / self.gaussian.sigma_phi_given_e() * e_density
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
        let smallest_ratio = (1.0 - self.gaussian.correlation.powi(2)).sqrt();
        smallest_ratio * self.gaussian.sigma_e.min(e * self.gaussian.sigma_phi.min(1.0))
    }
}

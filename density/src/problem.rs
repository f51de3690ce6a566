//! The problem that every method solves: a force, an initial Gaussian in `(phi, e)`, the times at which the density is
//! wanted, and the eccentricity at which the satellite re-enters.

use std::f64::consts::{PI, SQRT_2};

use crate::gaussian::Gaussian;
use crate::model::planar::Force;

/// The initial Gaussian, independent in `phi` and `e`, cut to `0 < e < 1`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InitialGaussian {
    /// Mean solar angle \[rad\].
    pub mean_phi: f64,
    /// Mean eccentricity, before the cut.
    pub mean_e: f64,
    /// Standard deviation of the solar angle \[rad\], half of the paper's `Δphi`.
    pub sigma_phi: f64,
    /// Standard deviation of the eccentricity, half of the paper's `Δe`.
    pub sigma_e: f64,
}

impl InitialGaussian {
    /// Density at `(phi, e)` \[1/rad\]; zero outside `0 < e < 1`. `phi` counts as an unbounded variable here: choose the
    /// representative nearest to the mean.
    pub fn density(&self, phi: f64, e: f64) -> f64 {
        if e <= 0.0 || e >= 1.0 {
            return 0.0;
        }
        let (u, v) = self.standardise(phi, e);
        (-0.5 * (u * u + v * v)).exp() / (2.0 * PI * self.sigma_phi * self.sigma_e * self.mass_inside())
    }

    /// `(phi, e)` in standard deviations from the mean.
    pub fn standardise(&self, phi: f64, e: f64) -> (f64, f64) {
        ((phi - self.mean_phi) / self.sigma_phi, (e - self.mean_e) / self.sigma_e)
    }

    /// The point `(phi, e)` at `(u, v)` standard deviations from the mean.
    pub fn point(&self, u: f64, v: f64) -> (f64, f64) {
        (self.mean_phi + u * self.sigma_phi, self.mean_e + v * self.sigma_e)
    }

    /// The share of the uncut Gaussian in `0 < e < 1`.
    pub fn mass_inside(&self) -> f64 {
        1.0 - tail(self.mean_e / self.sigma_e) - tail((1.0 - self.mean_e) / self.sigma_e)
    }

    /// The probability that the eccentricity exceeds `e`.
    pub fn probability_above(&self, e: f64) -> f64 {
        let beyond = |e: f64| tail((e - self.mean_e) / self.sigma_e);
        ((beyond(e.max(0.0)) - beyond(1.0)) / self.mass_inside()).clamp(0.0, 1.0)
    }
}

impl From<InitialGaussian> for Gaussian<2> {
    /// Before the cut.
    fn from(InitialGaussian { mean_phi, mean_e, sigma_phi, sigma_e }: InitialGaussian) -> Self {
        Self::independent([mean_phi, mean_e], [sigma_phi, sigma_e])
    }
}

/// The probability that a standard normal variable exceeds `sigmas`.
fn tail(sigmas: f64) -> f64 {
    0.5 * libm::erfc(sigmas / SQRT_2)
}

/// A scenario's science: all that a method needs to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem<M = Force> {
    /// What moves the orbits.
    pub model: M,
    /// The cloud at `t = 0`.
    pub initial: InitialGaussian,
    /// Snapshot times \[yr\], ascending from zero.
    pub times: Vec<f64>,
    /// Eccentricity at which the satellite re-enters.
    pub critical_e: f64,
}

#[cfg(test)]
pub(crate) mod paper {
    //! The three scenarios of Table 1.
    use super::*;

    pub(crate) fn scenario(number: usize) -> Problem {
        let (mean_phi, mean_e, delta_phi, delta_e, snapshots) = match number {
            1 => (2.2069, 0.145, PI / 8.0, 0.05, 5),
            2 => (0.5419, 0.095, PI / 40.0, 0.01, 7),
            _ => (0.3004, 0.23, PI / 32.0, 0.02, 5),
        };
        Problem {
            model: Force { radiation: 0.15, oblateness: 0.40921 },
            initial: InitialGaussian { mean_phi, mean_e, sigma_phi: delta_phi / 2.0, sigma_e: delta_e / 2.0 },
            times: (0..snapshots).map(|k| 0.5 * f64::from(k)).collect(),
            critical_e: 0.6,
        }
    }
}

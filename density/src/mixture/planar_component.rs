//! A component of a mixture in the plane of solar angle and eccentricity, and what of it lies above `e = 0`.

use super::error::MixtureError;

/// One Gaussian of a mixture in the `(phi, e)` plane: one row of the snapshot that a propagator publishes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanarComponent {
    /// Share of the probability.
    pub weight: f64,
    /// Mean solar angle \[rad\], on the branch within π of the mixture's circular mean.
    pub mean_phi: f64,
    /// Mean eccentricity.
    pub mean_e: f64,
    /// Variance of the solar angle \[rad²\].
    pub var_phi: f64,
    /// Covariance of solar angle and eccentricity \[rad\].
    pub cov_phi_e: f64,
    /// Variance of the eccentricity.
    pub var_e: f64,
}

impl PlanarComponent {
    /// The row as it is published: `(w, m_phi, m_e, P_phiphi, P_phie, P_ee)`.
    pub fn to_array(self) -> [f64; 6] {
        [self.weight, self.mean_phi, self.mean_e, self.var_phi, self.cov_phi_e, self.var_e]
    }

    /// The inverse of [`PlanarComponent::to_array`].
    pub fn from_array([weight, mean_phi, mean_e, var_phi, cov_phi_e, var_e]: [f64; 6]) -> Self {
        Self { weight, mean_phi, mean_e, var_phi, cov_phi_e, var_e }
    }

    /// The part of the component above `e = 0`, below which there are no orbits: its probability, mean and covariance.
    pub(super) fn above_zero(self) -> Self {
        let sigma = self.var_e.sqrt();
        if sigma.is_nan() || sigma <= 0.0 {
            return self;
        }
        let part = Above::new(self.mean_e / sigma);
        let slope = self.cov_phi_e / sigma;
        Self {
            weight: self.weight * part.share,
            mean_phi: self.mean_phi + slope * part.mean,
            mean_e: self.mean_e + sigma * part.mean,
            var_phi: self.var_phi - slope * slope * (1.0 - part.variance),
            cov_phi_e: self.cov_phi_e * part.variance,
            var_e: self.var_e * part.variance,
        }
    }

    /// Whether the values are those of a Gaussian: finite, with a weight that is not negative and a covariance that is
    /// not indefinite.
    fn is_gaussian(&self) -> bool {
        let determinant = self.var_phi * self.var_e - self.cov_phi_e * self.cov_phi_e;
        self.to_array().iter().all(|x| x.is_finite())
            && self.weight >= 0.0
            && self.var_phi > 0.0
            && self.var_e > 0.0
            && determinant >= -1e-9 * self.var_phi * self.var_e
    }
}

/// The part of a standard normal variable above `-sigmas`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Above {
    /// Its probability.
    pub share: f64,
    /// Its mean.
    pub mean: f64,
    /// Its variance.
    pub variance: f64,
}

impl Above {
    pub fn new(sigmas: f64) -> Self {
        /// Beyond this the tail is below the rounding of one.
        const FAR: f64 = 8.5;
        if sigmas > FAR {
            return Self { share: 1.0, mean: 0.0, variance: 1.0 };
        }
        let share = 0.5 * libm::erfc(-sigmas * std::f64::consts::FRAC_1_SQRT_2);
        if sigmas < -FAR {
            // Nearly an exponential distribution.
            return Self { share, mean: -sigmas - 1.0 / sigmas, variance: 1.0 / (sigmas * sigmas) };
        }
        let mean = (-0.5 * sigmas * sigmas).exp() / (2.0 * std::f64::consts::PI).sqrt() / share;
        Self { share, mean, variance: (1.0 - mean * (mean + sigmas)).clamp(0.0, 1.0) }
    }
}

/// Checks rows that come from outside this library.
pub(super) fn check(components: &[PlanarComponent]) -> Result<(), MixtureError> {
    if let Some(index) = components.iter().position(|component| !component.is_gaussian()) {
        return Err(MixtureError::NoGaussian { index, row: components[index].to_array() });
    }
    let total: f64 = components.iter().map(|component| component.weight).sum();
    if total > 0.0 { Ok(()) } else { Err(MixtureError::Weightless) }
}

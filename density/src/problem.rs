//! The problem that every method solves: a force, an initial Gaussian, snapshot times and a critical eccentricity.
//!
//! The Gaussian is in `(phi, e)`, the density is wanted at the times, and the satellite re-enters at the critical
//! eccentricity.

use std::f64::consts::{PI, SQRT_2};

use crate::gaussian::Gaussian;
use crate::model::PlanarHamiltonian;
use crate::model::parameter::check_ranges;
use crate::model::planar::SrpJ2;
use crate::problem_error::{Field, ProblemError, check, check_angle};

/// The initial Gaussian in `phi` and `e`, cut to `0 < e < 1`: what lies outside is left out, and what is left is scaled
/// to a probability of 1. No point of it has a negative eccentricity, for any method.
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
    /// Correlation of the solar angle and the eccentricity, before the cut; 0 in the paper.
    pub correlation: f64,
}

impl InitialGaussian {
    /// Density at `(phi, e)` \[1/rad\]; zero outside `0 < e < 1`. `phi` is treated as an unbounded variable here: pass
    /// the representative nearest to the mean.
    pub fn density(&self, phi: f64, e: f64) -> f64 {
        if e <= 0.0 || e >= 1.0 {
            return 0.0;
        }
        let (u, v) = self.standardise(phi, e);
        (-0.5 * (u * u + v * v)).exp() / (2.0 * PI * self.sigma_phi_given_e() * self.sigma_e * self.mass_inside())
    }

    /// The standardised coordinates `(u, v)` of `(phi, e)`: before the cut they are independent, with mean 0 and
    /// deviation 1. `v` is the eccentricity's distance from its mean in standard deviations, and `u` that of the solar
    /// angle from its mean *given this eccentricity*, in standard deviations of the angle given the eccentricity.
    pub fn standardise(&self, phi: f64, e: f64) -> (f64, f64) {
        let v = (e - self.mean_e) / self.sigma_e;
        ((phi - self.mean_phi_given(v)) / self.sigma_phi_given_e(), v)
    }

    /// The point `(phi, e)` at the standardised coordinates `(u, v)`, see [`InitialGaussian::standardise`].
    pub fn point(&self, u: f64, v: f64) -> (f64, f64) {
        (self.mean_phi_given(v) + u * self.sigma_phi_given_e(), self.mean_e + v * self.sigma_e)
    }

    /// Mean of the solar angle \[rad\] given an eccentricity `v` standard deviations from its mean.
    pub fn mean_phi_given(&self, v: f64) -> f64 {
        self.mean_phi + self.correlation * v * self.sigma_phi
    }

    /// Standard deviation of the solar angle given the eccentricity \[rad\], whatever that is.
    pub fn sigma_phi_given_e(&self) -> f64 {
        (1.0 - self.correlation * self.correlation).sqrt() * self.sigma_phi
    }

    /// The area in `(phi, e)` of a unit square of the standardised coordinates \[rad\].
    pub fn unit_area(&self) -> f64 {
        self.sigma_phi_given_e() * self.sigma_e
    }

    /// Covariance of solar angle and eccentricity before the cut \[rad\].
    pub fn covariance(&self) -> f64 {
        self.correlation * self.sigma_phi * self.sigma_e
    }

    /// The share of the uncut Gaussian in `0 < e < 1`.
    pub fn mass_inside(&self) -> f64 {
        1.0 - tail(self.mean_e / self.sigma_e) - tail((1.0 - self.mean_e) / self.sigma_e)
    }

    /// The share of the uncut Gaussian above `e = 1`.
    pub fn mass_beyond_one(&self) -> f64 {
        tail((1.0 - self.mean_e) / self.sigma_e)
    }

    /// The probability that the eccentricity exceeds `e`.
    pub fn probability_above(&self, e: f64) -> f64 {
        let beyond = |e: f64| tail((e - self.mean_e) / self.sigma_e);
        ((beyond(e.max(0.0)) - beyond(1.0)) / self.mass_inside()).clamp(0.0, 1.0)
    }
}

impl From<InitialGaussian> for Gaussian<2> {
    /// The Gaussian before the cut.
    fn from(initial: InitialGaussian) -> Self {
        let InitialGaussian { mean_phi, mean_e, sigma_phi, sigma_e, correlation } = initial;
        let across = (1.0 - correlation * correlation).sqrt() * sigma_e;
        Self::from_root([mean_phi, mean_e], [[sigma_phi, 0.0], [correlation * sigma_e, across]])
    }
}

/// The probability that a standard normal variable exceeds `sigmas`.
fn tail(sigmas: f64) -> f64 {
    0.5 * libm::erfc(sigmas / SQRT_2)
}

/// The scientific part of a scenario: everything that a method needs to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem<M = SrpJ2> {
    /// The model that moves the orbits.
    pub model: M,
    /// The cloud at `t = 0`.
    pub initial: InitialGaussian,
    /// Snapshot times \[yr\], ascending from zero.
    pub times: Vec<f64>,
    /// Eccentricity at which the satellite re-enters.
    pub critical_e: f64,
}

/// The strongest correlation of `phi` and `e`. A stronger one makes a line of the cloud.
pub const STRONGEST_CORRELATION: f64 = 0.999;

/// The latest permitted snapshot time \[yr\].
pub const MOST_YEARS: f64 = 1000.0;

impl<M: PlanarHamiltonian> Problem<M> {
    /// A problem, if every number is in the range for which the methods are made.
    ///
    /// # Errors
    /// [`ProblemError`] with the first field that is wrong and the values that are allowed.
    pub fn new(model: M, initial: InitialGaussian, times: Vec<f64>, critical_e: f64) -> Result<Self, ProblemError> {
        check_ranges(&model.parameters())?;
        initial.check()?;
        check_times(&times)?;
        check_fraction(Field::CriticalE, critical_e)?;
        Ok(Self { model, initial, times, critical_e })
    }
}

impl InitialGaussian {
    fn check(&self) -> Result<(), ProblemError> {
        const NARROWEST: f64 = 1e-9;
        let (delta_phi, delta_e) = (2.0 * self.sigma_phi, 2.0 * self.sigma_e);
        check_angle(Field::MeanPhi, self.mean_phi, f64::NEG_INFINITY, "between -2π and 2π")?;
        check_fraction(Field::MeanE, self.mean_e)?;
        check_angle(Field::DeltaPhi, delta_phi, NARROWEST, "at least 1e-9 and at most 2π")?;
        let is_right = (NARROWEST..=1.0).contains(&delta_e);
        check(Field::DeltaE, delta_e, is_right, "at least 1e-9 and at most 1".into())?;
        let right = format!("between -{STRONGEST_CORRELATION} and {STRONGEST_CORRELATION}");
        check(Field::Correlation, self.correlation, self.correlation.abs() <= STRONGEST_CORRELATION, right)
    }
}

fn check_fraction(field: Field, value: f64) -> Result<(), ProblemError> {
    check(field, value, value > 0.0 && value < 1.0, "between 0 and 1, both excluded".into())
}

/// Checks that times ascend from 0.
///
/// # Errors
/// [`ProblemError`] with the first time that is wrong.
pub fn check_times(times: &[f64]) -> Result<(), ProblemError> {
    let first = times.first().copied().unwrap_or(f64::NAN);
    check(Field::Times, first, first == 0.0, "0.0 for the first of the times, which must ascend".into())?;
    for pair in times.windows(2) {
        check(Field::Times, pair[1], pair[0] < pair[1], format!("later than {}: times must ascend", pair[0]))?;
        check(Field::Times, pair[1], pair[1] <= MOST_YEARS, format!("at most {MOST_YEARS} yr"))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::paper::scenario;
    use super::*;

    fn checked(change: impl Fn(&mut Problem)) -> Result<Problem, ProblemError> {
        let mut problem = scenario(1);
        change(&mut problem);
        let Problem { model, initial, times, critical_e } = problem;
        Problem::new(model, initial, times, critical_e)
    }

    #[test]
    fn the_papers_scenarios_are_right() {
        assert_eq!(checked(|_| {}), Ok(scenario(1)));
    }

    #[test]
    fn a_wrong_field_is_told_with_its_value_and_what_would_be_right() {
        let refused = |change: fn(&mut Problem), field: Field, words: &str| {
            let error = checked(change).unwrap_err();
            assert_eq!(error.field, field, "{error}");
            assert!(error.to_string().contains(words), "{error}");
        };
        refused(
            |p| p.model.radiation = -1.0,
            Field::Parameter("radiation"),
            "-1 is not allowed, it must be 0 or greater",
        );
        refused(|p| p.model.oblateness = f64::NAN, Field::Parameter("oblateness"), "at most 100");
        refused(|p| p.initial.mean_phi = 100.0, Field::MeanPhi, "if 100 degrees are meant, write 1.7453293");
        refused(|p| p.initial.mean_phi = 7.0, Field::MeanPhi, "between -2π and 2π; if 7 degrees are meant");
        refused(|p| p.initial.mean_e = 1.0, Field::MeanE, "between 0 and 1");
        refused(|p| p.initial.sigma_phi = 10.0, Field::DeltaPhi, "if 20 degrees are meant, write 0.3490659");
        refused(|p| p.initial.sigma_e = 0.0, Field::DeltaE, "at least 1e-9");
        refused(|p| p.critical_e = f64::INFINITY, Field::CriticalE, "between 0 and 1");
        refused(|p| p.times = vec![], Field::Times, "0.0 for the first");
        refused(|p| p.times = vec![0.0, 2.0, 1.0], Field::Times, "1 is not allowed, it must be later than 2");
        refused(|p| p.times = vec![0.0, 2000.0], Field::Times, "at most 1000 yr");
    }
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
            model: SrpJ2 { radiation: 0.15, oblateness: 0.40921 },
            initial: InitialGaussian {
                mean_phi,
                mean_e,
                sigma_phi: delta_phi / 2.0,
                sigma_e: delta_e / 2.0,
                correlation: 0.0,
            },
            times: (0..snapshots).map(|k| 0.5 * f64::from(k)).collect(),
            critical_e: 0.6,
        }
    }
}

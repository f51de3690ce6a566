//! A problem whose radiation parameter is known with an uncertainty only.
//!
//! `C` is proportional to the area-to-mass ratio times the reflectivity and constant along an orbit. An uncertain `C`
//! adds a dimension to the start and none to the flow: the space is a stack of planes, called leaves here, one for each
//! value of `C`. The density in `(phi, e)` is the mean of the leaves' densities over `C`.
//!
//! The third variable of such a cloud is `C` itself, or its logarithm, and is a Gaussian independent of `phi` and `e`.
//! The variable `z` below is that Gaussian's distance from its mean in standard deviations.

use crate::exact::measure::{normal_density, normal_tail};
use crate::gaussian::Gaussian;
use crate::model::Variable;
use crate::model::registry::Planar;
use crate::model::uncertain_radiation::{Linear, Logarithmic, Scale, UncertainRadiation};
use crate::problem::Problem;
use crate::problem_error::{Field, ProblemError, check};

/// How the radiation parameter is distributed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Distribution {
    /// A Gaussian, cut at `C = 0`.
    Gaussian,
    /// `C` is log-normal: its logarithm is a Gaussian.
    LogNormal,
}

impl Distribution {
    /// The variable that is a Gaussian.
    pub fn variable(self) -> Variable {
        match self {
            Self::Gaussian => Linear::VARIABLE,
            Self::LogNormal => Logarithmic::VARIABLE,
        }
    }
}

/// The uncertainty of the radiation parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Standard deviation of `C` as a share of its mean, before the cut.
    pub relative: f64,
    /// Its distribution.
    pub distribution: Distribution,
}

impl Spread {
    /// Mean and standard deviation, before the cut, of the variable that is a Gaussian, where the radiation parameter
    /// has this mean.
    pub fn parameters(&self, mean: f64) -> (f64, f64) {
        let relative = self.relative;
        match self.distribution {
            Distribution::Gaussian => (mean, relative * mean),
            // The mean of a log-normal variable is exp(mu + sigma²/2), its relative variance exp(sigma²) - 1 (Johnson,
            // Kotz & Balakrishnan, Continuous Univariate Distributions 1, 1994, Sect. 14.3).
            Distribution::LogNormal => {
                let variance = (relative * relative).ln_1p();
                (mean.ln() - 0.5 * variance, variance.sqrt())
            }
        }
    }

    /// The distance from the mean, in standard deviations, at which the distribution is cut.
    pub fn lowest(&self) -> f64 {
        match self.distribution {
            Distribution::Gaussian => -1.0 / self.relative,
            Distribution::LogNormal => f64::NEG_INFINITY,
        }
    }

    /// The radiation parameter at `z` standard deviations, where its mean is `mean`.
    pub fn radiation(&self, mean: f64, z: f64) -> f64 {
        let third = self.third(mean, z);
        match self.distribution {
            Distribution::Gaussian => third,
            Distribution::LogNormal => third.exp(),
        }
    }

    /// The third variable, `C` or `ln C`, at `z` standard deviations, where the mean of `C` is `mean`. It is zero where
    /// the distribution is cut there, whatever the rounding of `z` is.
    pub fn third(&self, mean: f64, z: f64) -> f64 {
        const ROUNDING: f64 = 8.0 * f64::EPSILON;
        let (middle, sigma) = self.parameters(mean);
        let third = middle + sigma * z;
        let is_at_cut = self.distribution == Distribution::Gaussian && third.abs() <= ROUNDING * middle.abs();
        if is_at_cut { 0.0 } else { third }
    }
}

/// A planar problem with an uncertain radiation parameter, of which the problem's model has the mean.
#[derive(Debug, Clone, PartialEq)]
pub struct UncertainProblem {
    /// The problem with the mean of the radiation parameter.
    pub plane: Problem<Planar>,
    /// The uncertainty of that parameter.
    pub spread: Spread,
}

/// The widest spread.
pub const WIDEST: f64 = 1.0;
/// The narrowest spread.
pub const NARROWEST: f64 = 1e-6;

impl UncertainProblem {
    /// A problem whose radiation parameter is uncertain.
    ///
    /// # Errors
    /// [`ProblemError`] if the spread is out of range, or if there is no radiation pressure that could be uncertain.
    pub fn new(plane: Problem<Planar>, spread: Spread) -> Result<Self, ProblemError> {
        let is_right = (NARROWEST..=WIDEST).contains(&spread.relative);
        let right = format!("at least {NARROWEST:e} and at most {WIDEST}, a share of the radiation parameter");
        check(Field::SigmaRadiation, spread.relative, is_right, right)?;
        let problem = Self { plane, spread };
        let acts = problem.mean() > 0.0;
        let right = "left out where there is no radiation pressure: its parameter is 0".into();
        check(Field::SigmaRadiation, spread.relative, acts, right)?;
        Ok(problem)
    }

    /// The mean of the radiation parameter, before the cut.
    pub fn mean(&self) -> f64 {
        self.plane.model.value("radiation").unwrap_or(0.0)
    }

    /// Mean and standard deviation of the third variable, which is `C` or `ln C`, before the cut.
    pub fn third(&self) -> (f64, f64) {
        self.spread.parameters(self.mean())
    }

    /// The radiation parameter at `z`.
    pub fn radiation(&self, z: f64) -> f64 {
        self.spread.radiation(self.mean(), z)
    }

    /// The third variable at `z`.
    pub fn third_at(&self, z: f64) -> f64 {
        self.spread.third(self.mean(), z)
    }

    /// The density of the third variable.
    pub fn third_density(&self, third: f64) -> f64 {
        let (mean, sigma) = self.third();
        normal_density((third - mean) / sigma) / (sigma * self.mass_inside())
    }

    /// The value of `z` at which the distribution is cut.
    pub fn lowest(&self) -> f64 {
        self.spread.lowest()
    }

    /// The share of the uncut Gaussian that the cut leaves.
    pub fn mass_inside(&self) -> f64 {
        normal_tail(self.lowest())
    }

    /// The planar problem at `z`; `None` where the radiation parameter is out of the range of the model.
    pub fn leaf(&self, z: f64) -> Option<Problem<Planar>> {
        let radiation = self.radiation(z);
        let is_possible = radiation >= 0.0 && radiation.is_finite();
        let model = is_possible.then(|| self.plane.model.with("radiation", radiation).ok()).flatten()?;
        Some(Problem { model, ..self.plane.clone() })
    }

    /// The initial Gaussian over `phi`, `e` and the third variable.
    pub fn gaussian(&self) -> Gaussian<3> {
        let plane = Gaussian::<2>::from(self.plane.initial);
        let ([phi, across], (third, sigma)) = ([plane.direction(0), plane.direction(1)], self.third());
        let [mean_phi, mean_e] = plane.mean;
        Gaussian::from_root(
            [mean_phi, mean_e, third],
            [[phi[0], 0.0, 0.0], [phi[1], across[1], 0.0], [0.0, 0.0, sigma]],
        )
    }

    /// Does a task with the model in three variables.
    pub fn perform<T: UncertainTask>(&self, task: T) -> T::Output {
        let without = self.plane.model.with("radiation", 0.0).unwrap_or(self.plane.model);
        match self.spread.distribution {
            Distribution::Gaussian => task.with(UncertainRadiation::<Linear>::new(without)),
            Distribution::LogNormal => task.with(UncertainRadiation::<Logarithmic>::new(without)),
        }
    }
}

/// Something that is done with the model in three variables, whichever the third one is.
pub trait UncertainTask {
    /// The result.
    type Output;

    /// Does the task with a given model.
    fn with<S: Scale>(self, model: UncertainRadiation<S>) -> Self::Output;
}

/// Moments of the third variable, `C` or `ln C`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThirdMoments {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub deviation: f64,
    /// Covariance with the solar angle \[rad\].
    pub with_phi: f64,
    /// Covariance with the eccentricity.
    pub with_e: f64,
}

impl ThirdMoments {
    /// Mean and standard deviation alone, after the cut (Johnson, Kotz & Balakrishnan, *Continuous Univariate
    /// Distributions* 1, 1994, Sect. 13.10.1).
    pub fn at_start(problem: &UncertainProblem) -> Self {
        let ((mean, sigma), lowest) = (problem.third(), problem.lowest());
        let (shift, variance) = match lowest.is_finite() {
            true => {
                let hazard = normal_density(lowest) / problem.mass_inside();
                (hazard, 1.0 + lowest * hazard - hazard * hazard)
            }
            false => (0.0, 1.0),
        };
        Self { mean: mean + sigma * shift, deviation: sigma * variance.sqrt(), with_phi: 0.0, with_e: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `C - 5 (0.2 C)` is a little below zero for about a third of all values of `C`.
    #[test]
    fn the_parameter_is_zero_where_its_distribution_is_cut() {
        for relative in [0.2, 0.25, 0.3, 0.7] {
            let spread = Spread { relative, distribution: Distribution::Gaussian };
            for k in 1..400 {
                let mean = 1e-3 * f64::from(k);
                assert_eq!(spread.radiation(mean, spread.lowest()), 0.0, "{mean} {relative}");
            }
            assert!(spread.radiation(0.1, spread.lowest() + 1e-9) > 0.0);
        }
    }
}

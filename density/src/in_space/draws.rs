//! The orbits of a cloud in space by their numbers.
//!
//! Orbit `i` has six shares of probability, for eccentricity, solar angle, inclination, node, radiation parameter and
//! mean anomaly, in this order ([`SamplingPlan::shares`]). A share that its problem has no use for is left unused, so
//! that problems with fewer uncertain variables, and simpler models, have the same orbits otherwise. The eccentricity
//! comes first, since it is cut: it has the quantiles of a cut normal variable, and the others are normal given the
//! ones before them.

use std::f64::consts::TAU;

use super::{InitialInSpace, SpaceProblem};
use crate::gaussian::Gaussian;
use crate::problem::InitialGaussian;
use crate::problem_error::ProblemError;
use crate::sampling::{SamplingPlan, normal_quantile_of_tail, normal_tail};
use crate::uncertain::{Distribution, Spread, UncertainProblem};

/// Number of shares of an orbit.
const SHARES: usize = 6;

/// The order in which variables are drawn: eccentricity, solar angle, inclination, node.
const ORDER: [usize; 4] = [1, 0, 2, 3];

/// An orbit of a cloud at `t = 0`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// Solar angle, eccentricity, inclination and node. The inclination may be below 0, see [`super`].
    pub variables: [f64; 4],
    /// The radiation parameter, or its logarithm if that is the variable of the cloud.
    pub radiation: f64,
    /// A mean anomaly, spread evenly over the revolution \[rad\].
    pub mean_anomaly: f64,
}

/// The cloud's distribution, in the order in which variables are drawn.
#[derive(Debug, Clone, Copy)]
pub struct Distributed {
    gaussian: Gaussian<4>,
    /// Tails of the eccentricity beyond 0 and beyond 1.
    below_zero: f64,
    above_one: f64,
    /// Mean and deviation of the radiation parameter or its logarithm, and the tail below its cut.
    radiation: (f64, f64),
    below_cut: f64,
}

impl Distributed {
    /// The distribution of a problem's cloud.
    ///
    /// # Errors
    /// [`ProblemError`] if its correlations exclude one another.
    pub fn of(problem: &SpaceProblem) -> Result<Self, ProblemError> {
        Self::new(&problem.initial, problem.spread, problem.model.forces().force.radiation)
    }

    /// The distribution of a cloud in the plane whose radiation parameter is uncertain: inclination and node are
    /// certain.
    ///
    /// # Errors
    /// [`ProblemError`] if solar angle and eccentricity have no Gaussian.
    pub fn of_plane(problem: &UncertainProblem) -> Result<Self, ProblemError> {
        Self::in_plane(problem.plane.initial, Some(problem.spread), problem.mean())
    }

    /// The same for a radiation parameter of this mean, uncertain or not.
    ///
    /// # Errors
    /// As [`Distributed::of_plane`].
    pub fn in_plane(
        initial: InitialGaussian,
        spread: Option<Spread>,
        mean_radiation: f64,
    ) -> Result<Self, ProblemError> {
        let InitialGaussian { mean_phi, mean_e, sigma_phi, sigma_e, correlation } = initial;
        let initial = InitialInSpace {
            mean: [mean_phi, mean_e, 0.0, 0.0],
            sigma: [sigma_phi, sigma_e, 0.0, 0.0],
            correlation: [correlation, 0.0, 0.0, 0.0, 0.0, 0.0],
        };
        Self::new(&initial, spread, mean_radiation)
    }

    fn new(initial: &InitialInSpace, spread: Option<Spread>, mean_radiation: f64) -> Result<Self, ProblemError> {
        let covariance = initial.covariance();
        let reordered = ORDER.map(|a| ORDER.map(|b| covariance[a][b]));
        let gaussian = Gaussian::with_certain_variables(ORDER.map(|k| initial.mean[k]), reordered);
        let gaussian = gaussian.map_err(|_| super::contradiction())?;
        let (mean_e, sigma_e) = (initial.mean[1], initial.sigma[1]);
        let radiation = spread.map_or((mean_radiation, 0.0), |spread| spread.parameters(mean_radiation));
        let is_cut = spread.is_some_and(|spread| spread.distribution == Distribution::Gaussian);
        Ok(Self {
            gaussian,
            below_zero: normal_tail(mean_e / sigma_e),
            above_one: normal_tail((1.0 - mean_e) / sigma_e),
            radiation,
            below_cut: if is_cut { normal_tail(radiation.0 / radiation.1) } else { 0.0 },
        })
    }

    /// The orbit above which these shares of probability lie.
    pub fn at(&self, shares: [f64; SHARES]) -> Start {
        let [e, phi, inclination, node, radiation, anomaly] = shares;
        let within = 1.0 - self.below_zero - self.above_one;
        let standard = [self.above_one + e * within, phi, inclination, node].map(quantile);
        let mut variables = [0.0; 4];
        for (value, k) in self.gaussian.point(standard).into_iter().zip(ORDER) {
            variables[k] = value;
        }
        // Rounding may leave the cut by a last digit.
        variables[1] = variables[1].clamp(f64::MIN_POSITIVE, 1.0f64.next_down());
        let (mean, sigma) = self.radiation;
        let radiation = mean + sigma * quantile(radiation * (1.0 - self.below_cut));
        let radiation = if self.below_cut > 0.0 { radiation.max(f64::MIN_POSITIVE) } else { radiation };
        Start { variables, radiation, mean_anomaly: TAU * anomaly }
    }

    /// Orbit number `i` of a plan as a function of `i`.
    pub fn draw(self, plan: &SamplingPlan) -> impl Fn(usize) -> Start + Sync + Send + use<> {
        let shares = plan.shares::<SHARES>();
        move |index| self.at(shares(index))
    }
}

/// The quantile of a tail that rounding may have moved out of `(0, 1)`.
fn quantile(tail: f64) -> f64 {
    normal_quantile_of_tail(tail.clamp(f64::MIN_POSITIVE, 1.0f64.next_down()))
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroUsize;

    use super::super::example;
    use super::*;
    use crate::sampling::Draws;

    const DRAWS: usize = 40_000;

    fn starts(problem: &SpaceProblem) -> Vec<Start> {
        let plan = SamplingPlan { draws: Draws::Independent, seed: 3, replicates: NonZeroUsize::MIN };
        let draw = Distributed::of(problem).unwrap().draw(&plan);
        (0..DRAWS).map(draw).collect()
    }

    #[test]
    fn draws_have_the_means_and_the_covariance_of_the_gaussian() {
        let problem = example::problem();
        let (means, covariance) = problem.moments();
        let starts = starts(&problem);
        let values = |start: &Start| {
            let [phi, e, i, node] = start.variables;
            [phi, e, i, node, start.radiation]
        };
        let mean = |f: &dyn Fn(&Start) -> f64| starts.iter().map(f).sum::<f64>() / DRAWS as f64;
        for a in 0..5 {
            let unit = |k: usize| covariance[k][k].sqrt();
            assert!((mean(&|s| values(s)[a]) - means[a]).abs() < 5.0 * unit(a) / (DRAWS as f64).sqrt());
            for b in 0..5 {
                let found = mean(&|s| (values(s)[a] - means[a]) * (values(s)[b] - means[b]));
                let error = 8.0 * unit(a) * unit(b) / (DRAWS as f64).sqrt();
                assert!((found - covariance[a][b]).abs() < error, "{a} {b}: {found} {}", covariance[a][b]);
            }
        }
    }

    #[test]
    fn the_eccentricity_is_that_of_the_cut_gaussian_and_nothing_else_is_changed_by_the_cut() {
        let mut problem = example::problem();
        problem.initial.mean[1] = 0.01;
        problem.initial.correlation = [0.0; 6];
        let starts = starts(&problem);
        assert!(starts.iter().all(|start| start.variables[1] > 0.0));
        // The mean of a normal variable cut below `a = -1/2` is `f(a)/(1 - F(a))` above its own mean.
        let density = (-0.125f64).exp() / TAU.sqrt();
        let expected = 0.01 + 0.02 * density / normal_tail(-0.5);
        let mean = starts.iter().map(|start| start.variables[1]).sum::<f64>() / DRAWS as f64;
        assert!((mean - expected).abs() < 5.0 * 0.02 / (DRAWS as f64).sqrt(), "{mean} {expected}");
        let phi = starts.iter().map(|start| start.variables[0]).sum::<f64>() / DRAWS as f64;
        assert!((phi - 2.2069).abs() < 5.0 * 0.1 / (DRAWS as f64).sqrt());
    }

    #[test]
    fn an_inclination_below_zero_is_one_above_it_with_the_node_on_the_other_side() {
        use crate::model::elements::Elements;
        let of = |inclination, node| {
            Elements { eccentricity: 0.3, inclination, node, longitude_of_pericentre: 1.2 }.vectors()
        };
        let (below, above) = (of(-0.2, 0.7), of(0.2, 0.7 + std::f64::consts::PI));
        let apart = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart(below.e, above.e) < 1e-15 && apart(below.h, above.h) < 1e-15);
    }

    #[test]
    fn a_certain_variable_is_the_same_in_every_draw() {
        let mut problem = example::problem();
        problem.initial.sigma[2] = 0.0;
        problem.initial.correlation = [0.3, 0.0, 0.0, 0.0, 0.0, 0.0];
        problem.spread = None;
        let starts = starts(&problem);
        assert!(starts.iter().all(|start| start.variables[2] == 0.2 && start.radiation == 0.15));
        let other = Start { mean_anomaly: 0.0, ..starts[0] };
        assert_ne!(other, Start { mean_anomaly: 0.0, ..starts[1] });
    }
}

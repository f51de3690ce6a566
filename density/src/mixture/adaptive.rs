//! A mixture over the variables of any model, whose components are split where the flow over them is not linear.
//!
//! The Gaussian is split at the start ([`super::splitting`]), and its components are moved from time to time.
//!
//! What remains is the mixture's disagreement at each snapshot, the larger of `D = Σ w D_c`, twists included, and of
//! ten times the estimated error of the moments and of the probability in parts that were left out at a bound: a
//! mixture is trusted to give moments to a tenth of its disagreement ([`crate::trust`]). In up to four variables that
//! error is estimated from the components' points ([`super::fifth_degree`]); in more it is `Σ w E_c`.

use super::any_model::{MixturePropagator, SigmaPointRule};
use super::component::Component;
use super::error::MixtureError;
use super::fifth_degree;
use super::part::Part;
pub use super::splitting::Fineness;
use super::splitting::Splitting;
use super::unscented::Unscented;
use crate::flow::Flow;
use crate::gaussian::Gaussian;
use crate::model::Model;

/// Disagreement for each unit of the moments' error.
const DISAGREEMENT_PER_ERROR: f64 = 10.0;

/// A mixture that has been planned, and is moved from time to time.
#[derive(Debug, Clone)]
pub struct AdaptiveMixture<M, const N: usize> {
    propagator: MixturePropagator<M, N>,
    /// `D` at each of the times for which it was planned.
    disagreements: Vec<f64>,
    /// Share of the Gaussian's probability in components that were left out since they reach across the bound of a
    /// variable.
    left_out: f64,
    trajectories: usize,
}

/// A mixture that is being planned, round by round.
#[derive(Debug, Clone)]
pub struct MixturePlan<M, const N: usize> {
    splitting: Splitting<M, N>,
    unscented: Unscented,
}

impl<M: Model<Variables = [f64; N]>, const N: usize> MixturePlan<M, N> {
    /// The plan of a mixture whose components stay Gaussians at all `times` \[yr\].
    ///
    /// # Errors
    /// [`MixtureError`], if the settings are out of range, or a point cannot be followed.
    pub fn new(
        flow: Flow<M>,
        initial: &Gaussian<N>,
        times: &[f64],
        unscented: Unscented,
        fineness: Fineness,
    ) -> Result<Self, MixtureError> {
        unscented.check_in(N)?;
        Ok(Self { splitting: Splitting::new(flow, *initial, times.to_vec(), unscented, fineness)?, unscented })
    }

    /// Goes through one round and returns the share of the probability whose components are settled; `None` if all of
    /// them are.
    ///
    /// # Errors
    /// [`MixtureError`], if a point cannot be followed.
    pub fn go_on(&mut self) -> Result<Option<f64>, MixtureError> {
        let has_more = self.splitting.split_once()?;
        Ok(has_more.then(|| self.splitting.share_done()))
    }

    /// The mixture of all components that there are so far.
    ///
    /// # Errors
    /// [`MixtureError`], if no component lies inside the ranges of the variables.
    pub fn mixture(&self) -> Result<AdaptiveMixture<M, N>, MixtureError> {
        let Self { splitting, unscented } = self;
        let Splitting { flow, initial, times, done: parts, .. } = splitting;
        let total: f64 = parts.iter().map(|part| part.piece.weight).sum();
        if !(total > 0.0 && total.is_finite()) {
            return Err(MixtureError::NothingInside);
        }
        let mean = |of: &dyn Fn(&Part<N>) -> f64| parts.iter().map(|p| p.piece.weight * of(p)).sum::<f64>() / total;
        let rule = match N <= fifth_degree::MOST_VARIABLES {
            true => SigmaPointRule::FifthDegree,
            false => SigmaPointRule::Unscented(*unscented),
        };
        let of_transform = |k: usize| match rule {
            SigmaPointRule::FifthDegree => 0.0,
            SigmaPointRule::Unscented(_) => DISAGREEMENT_PER_ERROR * mean(&|part| part.moment_errors[k]),
        };
        let share = |weight: f64| weight / (total + splitting.left_out);
        // What is left out moves a mean by at most about as many deviations.
        let least = DISAGREEMENT_PER_ERROR * share(splitting.left_out);
        let disagreement = |k: usize| mean(&|part| part.disagreements[k]).max(of_transform(k)).max(least);
        let places = match rule {
            SigmaPointRule::FifthDegree => fifth_degree::places(),
            SigmaPointRule::Unscented(_) => splitting.places[..rule.count(N)].to_vec(),
        };
        let sigma_points = |part: &Part<N>| -> Vec<[f64; N]> {
            places.iter().map(|&place| part.piece.point(initial, place)).collect()
        };
        let components = parts.iter().map(|part| (share(part.piece.weight), sigma_points(part)));
        Ok(AdaptiveMixture {
            propagator: MixturePropagator::of_components(*flow, rule, components),
            disagreements: (0..times.len()).map(disagreement).collect(),
            left_out: share(splitting.left_out),
            trajectories: splitting.trajectories + parts.len() * rule.count(N),
        })
    }
}

impl<M: Model<Variables = [f64; N]>, const N: usize> AdaptiveMixture<M, N> {
    /// Splits a Gaussian at `t = 0` so that its components stay Gaussians at all `times` \[yr\].
    ///
    /// # Errors
    /// [`MixtureError`], if the settings are out of range, a point cannot be followed, or no component lies inside the
    /// ranges of the variables.
    pub fn new(
        flow: Flow<M>,
        initial: &Gaussian<N>,
        times: &[f64],
        unscented: Unscented,
        fineness: Fineness,
    ) -> Result<Self, MixtureError> {
        let mut plan = MixturePlan::new(flow, initial, times, unscented, fineness)?;
        while plan.go_on()?.is_some() {}
        plan.mixture()
    }

    /// Moves the components to `time` \[yr\].
    ///
    /// # Errors
    /// As [`MixturePropagator::advance_to`].
    pub fn advance_to(&mut self, time: f64) -> Result<(), MixtureError> {
        self.propagator.advance_to(time)
    }

    /// The mixture at the present time.
    pub fn mixture(&self) -> Vec<Component<N>> {
        self.propagator.mixture()
    }

    /// `D` at time number `index` of those for which the mixture was planned, without what is known of its points only
    /// when they are there; NaN if there is no such time.
    pub fn disagreement(&self, index: usize) -> f64 {
        self.disagreements.get(index).copied().unwrap_or(f64::NAN)
    }

    /// The disagreement at the present time, which is number `index`, and at least ten times the estimated error of the
    /// moments.
    pub fn present_disagreement(&self, index: usize) -> f64 {
        self.disagreement(index).max(DISAGREEMENT_PER_ERROR * self.moment_error().unwrap_or(0.0))
    }

    /// An estimate of the error of the moments at the present time, in standard deviations and products of them; `None`
    /// in more than four variables, where the mixture's points say nothing of it.
    pub fn moment_error(&self) -> Option<f64> {
        self.propagator.moment_error()
    }

    /// The share of the probability that was left out at the bounds of the variables; the weights of the components add
    /// up to the rest.
    pub fn left_out(&self) -> f64 {
        self.left_out
    }

    /// Number of components.
    pub fn components(&self) -> usize {
        self.propagator.components()
    }

    /// Number of orbits propagated, for the plan and for the components.
    pub fn trajectories(&self) -> usize {
        self.trajectories
    }
}

//! Importance sampling with a proposal found from a pilot.
//!
//! 1. A fifth of the orbits explores the ball of [`REACH`] standard deviations: directions at random, radii spread
//!    evenly. So every region of the event that is seen from the mean under more than a few degrees is found, also if
//!    there are several.
//! 2. Three tenths refine: kernels about the points found, then twice a mixture of Gaussians that is fitted to the
//!    points with the event, each weighted by the normal density over the density from which it was drawn (the
//!    cross-entropy method: Rubinstein & Kroese 2004; for failure probabilities Papaioannou, Geyer & Straub 2019).
//! 3. The rest is drawn from the last mixture, with wider copies of its components and the first kernels beside them,
//!    so that no weight is large (a defensive mixture, Hesterberg 1995). Only these count. They are independent, so
//!    that
//!
//! ```text
//! P = 1/n Σ w_i 1(event),   w = φ(z)/q(z) / P(inside),   standard error = sqrt((<w² 1> - P²)/(n - 1))
//! ```
//!
//! is unbiased with a standard error of its own (Owen, *Monte Carlo theory, methods and examples*, 2013, Chapter 9).
//!
//! No proposal is better than the Gaussian itself for an event that is not rare. Where the refinement says that it is
//! more probable than [`COMMON`], the rest is drawn from the Gaussian, and counted.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::proposal::{Proposal, effective, log_normal};
use super::{Answer, Question, Refused};
use crate::model::Model;

/// How far the pilot reaches from the mean, in standard deviations: beyond lie 6e-13 of two dimensions, 2e-11 of four.
pub(super) const REACH: f64 = 7.5;
/// The least number of orbits.
pub(super) const LEAST: usize = 500;
/// Shares of the orbits that explore, and that refine in each of the three steps.
const EXPLORE: f64 = 0.2;
const REFINE: f64 = 0.1;
/// Number of refinements.
const REFINEMENTS: usize = 3;
/// Deviation of the first kernels: the distance of neighbouring points of the pilot.
const KERNEL: f64 = 0.5;
/// Most components of a fitted mixture, and points for each.
const COMPONENTS: usize = 8;
const POINTS_EACH: f64 = 10.0;
/// How the weight is shared: the fitted mixture a little widened, much widened, and the first kernels.
const WIDTHS: [(f64, f64); 2] = [(1.25, 0.8), (2.5, 0.15)];
const FIRST: f64 = 0.05;
/// Probability above which an event is counted.
const COMMON: f64 = 0.3;
/// The least effective number of orbits with the event.
const NEEDED: f64 = 50.0;

/// Points that were drawn from mixtures one after the other, and their margins.
struct Drawn<const N: usize> {
    points: Vec<[f64; N]>,
    margins: Vec<f64>,
    /// Each mixture with the number of points drawn from it.
    sources: Vec<(Proposal<N>, usize)>,
}

/// The probability of the event, from `orbits` orbits.
///
/// # Errors
/// [`Refused`] says why there is no answer.
pub fn importance<M: Model, const N: usize>(
    question: &Question<M, N>,
    orbits: usize,
    seed: u64,
) -> Result<Answer, Refused> {
    if orbits < LEAST {
        return Err(Refused::TooFewOrbits { orbits, least: LEAST });
    }
    let inside = question.mass_inside()?;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let share = |share: f64| (share * orbits as f64) as usize;
    let (first, mut used) = explore(question, share(EXPLORE), &mut random)?;
    let mut proposal = first.clone();
    let mut drawn = Drawn { points: Vec::new(), margins: Vec::new(), sources: Vec::new() };
    for _ in 0..REFINEMENTS {
        used += drawn.add(question, &proposal, share(REFINE), &mut random)?;
        proposal = drawn.fit(&first).unwrap_or(proposal);
    }
    let count = orbits.saturating_sub(used);
    if drawn.probability() / inside > COMMON {
        return counted(question, count, used, &mut random);
    }
    let points: Vec<[f64; N]> = (0..count).map(|_| proposal.draw(&mut random)).collect();
    let margins = question.margins(&points)?;
    used += margins.orbits;
    let weight = |(point, margin): (&[f64; N], &f64)| match *margin <= 0.0 {
        true => (log_normal(point) - proposal.log_density(point)).exp() / inside,
        false => 0.0,
    };
    let weights: Vec<f64> = points.iter().zip(&margins.values).map(weight).collect();
    let effective = effective(weights.iter().copied());
    if effective < NEEDED {
        return Err(Refused::TooFew { effective, needed: NEEDED, orbits: used });
    }
    let n = count as f64;
    let mean = weights.iter().sum::<f64>() / n;
    let variance = weights.iter().map(|w| (w - mean).powi(2)).sum::<f64>() / (n - 1.0);
    Answer::new(mean, (variance / n).sqrt(), used)
}

/// The share of `count` independent points of the cut Gaussian that have the event; `used` orbits have been propagated
/// before.
fn counted<M: Model, const N: usize>(
    question: &Question<M, N>,
    count: usize,
    used: usize,
    random: &mut ChaCha8Rng,
) -> Result<Answer, Refused> {
    let points = question.draw(count, random);
    let margins = question.margins(&points)?;
    let happened = margins.values.iter().filter(|&&margin| margin <= 0.0).count();
    let answer = Answer::of_share(happened as f64 / count as f64, count);
    Ok(Answer { orbits: used + margins.orbits, ..answer })
}

/// Looks for regions of the event; returns kernels about the points found and the number of orbits.
fn explore<M: Model, const N: usize>(
    question: &Question<M, N>,
    count: usize,
    random: &mut ChaCha8Rng,
) -> Result<(Proposal<N>, usize), Refused> {
    let mut point = |i: usize| -> [f64; N] {
        let direction: [f64; N] = std::array::from_fn(|_| StandardNormal.sample(&mut *random));
        let length = direction.iter().map(|z| z * z).sum::<f64>().sqrt();
        direction.map(|z| z * REACH * (i as f64 + 0.5) / (count as f64 * length))
    };
    let points: Vec<[f64; N]> = (0..count).map(&mut point).collect();
    let margins = question.margins(&points)?;
    let found: Vec<[f64; N]> =
        points.iter().zip(&margins.values).filter(|(_, margin)| **margin <= 0.0).map(|(point, _)| *point).collect();
    if found.is_empty() {
        return Err(Refused::NothingFound { orbits: margins.orbits, reach: REACH });
    }
    // A point stands for a volume that grows with its radius. The square root of the normal density keeps regions in
    // play that are a little farther from the mean: how near they come is not known yet.
    let radius = |point: &[f64; N]| point.iter().map(|z| z * z).sum::<f64>().sqrt();
    let logs: Vec<f64> =
        found.iter().map(|point| 0.5 * log_normal(point) + (N - 1) as f64 * radius(point).ln()).collect();
    Ok((Proposal::kernels(&found, &normalised(&logs), KERNEL), margins.orbits))
}

impl<const N: usize> Drawn<N> {
    /// Draws points from a mixture; returns the number of orbits.
    fn add<M: Model>(
        &mut self,
        question: &Question<M, N>,
        proposal: &Proposal<N>,
        count: usize,
        random: &mut ChaCha8Rng,
    ) -> Result<usize, Refused> {
        let points: Vec<[f64; N]> = (0..count).map(|_| proposal.draw(random)).collect();
        let margins = question.margins(&points)?;
        self.points.extend(points);
        self.margins.extend(margins.values);
        self.sources.push((proposal.clone(), count));
        Ok(margins.orbits)
    }

    /// The logarithm of a point's weight: the normal density over those of all sources together (the balance heuristic,
    /// Veach & Guibas 1995).
    fn log_weight(&self, point: &[f64; N]) -> f64 {
        let terms: Vec<f64> =
            (self.sources.iter()).map(|(source, count)| (*count as f64).ln() + source.log_density(point)).collect();
        log_normal(point) - super::proposal::log_sum(&terms)
    }

    /// An estimate of the probability of the event.
    fn probability(&self) -> f64 {
        let happened = self.points.iter().zip(&self.margins).filter(|(_, margin)| **margin <= 0.0);
        happened.map(|(point, _)| self.log_weight(point).exp()).sum()
    }

    /// The mixture fitted to all points with the event, made defensive; `None` if there are none.
    fn fit(&self, first: &Proposal<N>) -> Option<Proposal<N>> {
        let happened = |(point, margin): (&[f64; N], &f64)| (*margin <= 0.0).then_some(*point);
        let points: Vec<[f64; N]> = self.points.iter().zip(&self.margins).filter_map(happened).collect();
        if points.is_empty() {
            return None;
        }
        let weights = normalised(&points.iter().map(|point| self.log_weight(point)).collect::<Vec<_>>());
        let most = (effective(weights.iter().copied()) / POINTS_EACH).clamp(1.0, COMPONENTS as f64) as usize;
        let fitted = Proposal::fit(&points, &weights, most);
        let mut components: Vec<_> =
            WIDTHS.iter().flat_map(|&(factor, share)| fitted.widened(factor, share).collect::<Vec<_>>()).collect();
        components.extend(first.widened(1.0, FIRST));
        Some(Proposal { components })
    }
}

/// Weights that add up to 1, from their logarithms.
fn normalised(logs: &[f64]) -> Vec<f64> {
    let sum = super::proposal::log_sum(logs);
    logs.iter().map(|log| (log - sum).exp()).collect()
}

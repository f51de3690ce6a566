//! Subset simulation (Au & Beck, Prob. Eng. Mech. 16, 2001).
//!
//! The event is the last of a sequence of events that hold one another: `P = P(F_1) P(F_2 | F_1) ... P(F_m | F_m-1)`. Each
//! `F_k` is the tenth of the points of the level before that comes nearest to the event. Points of the next level are made
//! from these by Markov chains that leave the Gaussian as it is within `F_k`: `z' = ρ z + sqrt(1 - ρ²) ξ`, taken if `z'` lies in `F_k`
//! (Papaioannou, Betz, Zwirglmaier & Straub 2015). The coefficient of variation is Au & Beck's, Eqs. 25 to 29, with the
//! correlation within each chain.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::importance::REACH;
use super::{Answer, Question, Refused};
use crate::model::Model;

/// The conditional probability of a level.
const SHARE: usize = 10;
/// Correlation of neighbours in a chain.
const CORRELATION: f64 = 0.8;
/// Most levels: fewer than 1e-12 are not looked for.
const MOST_LEVELS: usize = 12;
/// The least number of points of a level.
const LEAST: usize = 100;

/// Points with their margins, chain by chain, each chain of the same length.
struct Level<const N: usize> {
    points: Vec<[f64; N]>,
    margins: Vec<f64>,
    /// Length of a chain; 1 where points are independent.
    length: usize,
}

/// The probability of the event, from levels of `points` orbits each, which is rounded down to a multiple of ten. An event
/// of `1e-k` takes about `k` levels.
///
/// # Errors
/// [`Refused`] says why there is no answer.
pub fn subset<M: Model, const N: usize>(
    question: &Question<M, N>,
    points: usize,
    seed: u64,
) -> Result<Answer, Refused> {
    let points = points / SHARE * SHARE;
    if points < LEAST {
        return Err(Refused::TooFewOrbits { orbits: points, least: LEAST });
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (mut level, mut orbits) = first_level(question, points, &mut random)?;
    let (mut probability, mut variation) = (1.0, 0.0);
    for _ in 0..MOST_LEVELS {
        let threshold = level.threshold().max(0.0);
        let (share, square) = level.share(threshold);
        probability *= share;
        variation += square;
        if threshold == 0.0 {
            if share == 0.0 {
                break;
            }
            return Ok(Answer::new(probability, probability * f64::sqrt(variation), orbits));
        }
        let (next, taken) = level.next(question, threshold, &mut random)?;
        orbits += taken;
        level = next;
    }
    Err(Refused::NothingFound { orbits, reach: REACH })
}

/// Independent points of the cut Gaussian.
fn first_level<M: Model, const N: usize>(
    question: &Question<M, N>,
    count: usize,
    random: &mut ChaCha8Rng,
) -> Result<(Level<N>, usize), Refused> {
    let mut points = Vec::with_capacity(count);
    while points.len() < count {
        let point = std::array::from_fn(|_| StandardNormal.sample(random));
        if question.allows(&point) {
            points.push(point);
        }
    }
    let margins = question.margins(&points)?;
    Ok((Level { points, margins: margins.values, length: 1 }, margins.orbits))
}

impl<const N: usize> Level<N> {
    /// The margin that a tenth of the points do not exceed.
    fn threshold(&self) -> f64 {
        let mut sorted = self.margins.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / SHARE - 1]
    }

    /// The share of points with a margin up to `threshold`, and the square of its coefficient of variation.
    fn share(&self, threshold: f64) -> (f64, f64) {
        let (count, length) = (self.points.len(), self.length);
        let is_in: Vec<f64> = self.margins.iter().map(|&margin| f64::from(margin <= threshold)).collect();
        let share = is_in.iter().sum::<f64>() / count as f64;
        // Eqs. 25 to 29: the covariance at each lag within a chain.
        let covariance = |lag: usize| {
            let chains = is_in.chunks_exact(length);
            let products = chains.flat_map(|chain| (0..length - lag).map(|i| chain[i] * chain[i + lag]));
            products.sum::<f64>() / (count - lag * (count / length)) as f64 - share * share
        };
        let variance = share * (1.0 - share);
        let term = |lag: usize| (1.0 - lag as f64 / length as f64) * covariance(lag) / variance;
        let factor = if variance > 0.0 { 1.0 + 2.0 * (1..length).map(term).sum::<f64>() } else { 1.0 };
        (share, (1.0 - share) / (share * count as f64) * factor.max(1.0))
    }

    /// The next level, whose points have margins up to `threshold`, and the number of orbits that it took.
    fn next<M: Model>(
        &self,
        question: &Question<M, N>,
        threshold: f64,
        random: &mut ChaCha8Rng,
    ) -> Result<(Self, usize), Refused> {
        let mut seeds: Vec<usize> = (0..self.points.len()).collect();
        seeds.sort_by(|&a, &b| self.margins[a].total_cmp(&self.margins[b]));
        seeds.truncate(self.points.len() / SHARE);
        let mut current: Vec<([f64; N], f64)> = seeds.iter().map(|&i| (self.points[i], self.margins[i])).collect();
        let mut steps = vec![current.clone()];
        let mut orbits = 0;
        let fresh = (1.0 - CORRELATION * CORRELATION).sqrt();
        for _ in 1..SHARE {
            let mut candidate = |(point, _): &([f64; N], f64)| -> [f64; N] {
                point.map(|z| {
                    let noise: f64 = StandardNormal.sample(&mut *random);
                    CORRELATION * z + fresh * noise
                })
            };
            let candidates: Vec<[f64; N]> = current.iter().map(&mut candidate).collect();
            let margins = question.margins(&candidates)?;
            orbits += margins.orbits;
            for ((state, candidate), margin) in current.iter_mut().zip(candidates).zip(margins.values) {
                if margin <= threshold {
                    *state = (candidate, margin);
                }
            }
            steps.push(current.clone());
        }
        let chains = (0..current.len()).flat_map(|chain| steps.iter().map(move |step| step[chain]));
        let (points, margins) = chains.unzip();
        Ok((Self { points, margins, length: SHARE }, orbits))
    }
}

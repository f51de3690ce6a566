//! Subset simulation (Au & Beck, Prob. Eng. Mech. 16, 2001).
//!
//! The event is the last of a sequence of events that hold one another: `P = P(F_1) P(F_2 | F_1) ... P(F_m | F_m-1)`. Each
//! `F_k` is the tenth of the points of the level before that comes nearest to the event. Points of the next level are made
//! from these by Markov chains that leave the Gaussian as it is within `F_k`: `z' = ρ z + sqrt(1 - ρ²) ξ`, taken if `z'` lies in `F_k`
//! (Papaioannou, Betz, Zwirglmaier & Straub 2015).
//!
//! Points of a chain resemble one another, and so do chains that start from points of the same chain. Au & Beck's coefficient of variation
//! (Eqs. 25 to 29) counts the first alone and takes the levels as independent, from which it is a fifth too small at 1e-9. Here the variance is
//! that of the sums over families: the points that descend from the same chain of the level before, and that chain itself (the genealogy of a
//! particle filter, cut after one generation: Lee & Whiteley, Biometrika 105, 2018; Olsson & Douc, Bernoulli 25, 2019):
//!
//! ```text
//! D_k(f) = Σ_(points of family f) (1(F_k) - p_k)/(n p_k)
//! Var(ln P) = Σ_k Σ_f D_k(f)² + 2 Σ_k Σ_f D_(k-1)(f) D_k(f)
//! ```

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
    /// For each chain the chain of the level before in which its first point lies; empty at the first level.
    parents: Vec<usize>,
}

/// The variance of the logarithm of the probability, level by level.
#[derive(Default)]
struct Variance {
    /// By families.
    of_families: f64,
    /// That of independent points, below which it cannot be.
    of_points: f64,
    /// What each chain of the level before adds to the logarithm.
    before: Vec<f64>,
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
    let (mut probability, mut variance) = (1.0, Variance::default());
    for _ in 0..MOST_LEVELS {
        let threshold = level.threshold().max(0.0);
        let share = level.share(threshold);
        if share == 0.0 {
            break;
        }
        probability *= share;
        variance.add(&level, threshold, share);
        if threshold == 0.0 {
            return Answer::new(probability, probability * variance.value().sqrt(), orbits);
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
    Ok((Level { points, margins: margins.values, length: 1, parents: Vec::new() }, margins.orbits))
}

impl<const N: usize> Level<N> {
    /// The margin that a tenth of the points do not exceed.
    fn threshold(&self) -> f64 {
        let mut sorted = self.margins.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / SHARE - 1]
    }

    /// The share of points with a margin up to `threshold`.
    fn share(&self, threshold: f64) -> f64 {
        self.margins.iter().filter(|&&margin| margin <= threshold).count() as f64 / self.margins.len() as f64
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
        let parents = seeds.iter().map(|seed| seed / self.length).collect();
        Ok((Self { points, margins, length: SHARE, parents }, orbits))
    }
}

impl Variance {
    /// Adds a level, of whose points `share` have a margin up to `threshold`.
    fn add<const N: usize>(&mut self, level: &Level<N>, threshold: f64, share: f64) {
        let count = level.margins.len() as f64;
        let of_point = |margin: &f64| (f64::from(*margin <= threshold) - share) / (count * share);
        let of_chain = |chain: &[f64]| chain.iter().map(of_point).sum::<f64>();
        let chains: Vec<f64> = level.margins.chunks_exact(level.length).map(of_chain).collect();
        self.of_points += (1.0 - share) / (share * count);
        if level.parents.is_empty() {
            self.of_families += chains.iter().map(|d| d * d).sum::<f64>();
        } else {
            let mut families = vec![0.0; self.before.len()];
            level.parents.iter().zip(&chains).for_each(|(&parent, d)| families[parent] += d);
            self.of_families +=
                families.iter().zip(&self.before).map(|(d, before)| d * d + 2.0 * d * before).sum::<f64>();
        }
        self.before = chains;
    }

    fn value(&self) -> f64 {
        self.of_families.max(self.of_points)
    }
}

//! Subset simulation (Au & Beck, Prob. Eng. Mech. 16, 2001).
//!
//! The event is the last of a sequence of events that hold one another: `P = P(F_1) P(F_2 | F_1) ... P(F_m | F_m-1)`.
//! Each `F_k` is the tenth of the points of the level before that comes nearest to the event. Points of the next level
//! are made from these by Markov chains that leave the Gaussian as it is within `F_k`: `z' = ρ z + sqrt(1 - ρ²) ξ`,
//! taken if `z'` lies in `F_k` (Papaioannou, Betz, Zwirglmaier & Straub 2015).
//!
//! Points of a chain resemble one another, and so do chains that start from points of the same chain. Au & Beck's
//! coefficient of variation (Eqs. 25 to 29) counts the first alone and takes the levels as independent, which leaves
//! out a fifth of the spread at 1e-9. Here the variance is that of the sums over families: the points whose chains go
//! back, `g` levels before, to the same chain (the genealogy of a particle filter, cut after `g` generations: Lee &
//! Whiteley, Biometrika 105, 2018; Olsson & Douc, Bernoulli 25, 2019):
//!
//! ```text
//! D_k(f) = Σ_(points of level k in family f) (1(F_k) - p_k)/(n p_k)
//! Var(ln P) = Σ_k Σ_f D_k(f)² + 2 Σ_k Σ_(l = k-g)^(k-1) Σ_f D_l(f) D_k(f)
//! ```
//!
//! A family of too few generations leaves out resemblance, and one of many is a sum of few terms, so the largest of
//! one, two and three generations is taken.

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
/// Largest variance of the logarithm of the probability. Beyond, the answer rests on a few chains that have happened to
/// come to the event, and their spread says little of the others.
const MOST_VARIANCE: f64 = 1.0;
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

/// Most generations by which chains are taken together.
const GENERATIONS: usize = 3;

/// What the levels add to the logarithm of the probability, chain by chain.
#[derive(Default)]
struct Genealogy {
    levels: Vec<Generation>,
    /// The variance of as many independent points, below which it cannot be.
    of_points: f64,
}

/// The chains of a level.
struct Generation {
    /// What each adds to the logarithm.
    added: Vec<f64>,
    /// See [`Level::parents`].
    parents: Vec<usize>,
}

/// The probability of the event, from levels of `points` orbits each, which is rounded down to a multiple of ten. An
/// event of `1e-k` takes about `k` levels.
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
    let (mut probability, mut genealogy) = (1.0, Genealogy::default());
    for _ in 0..MOST_LEVELS {
        let threshold = level.threshold().max(0.0);
        let share = level.share(threshold);
        if share == 0.0 {
            break;
        }
        probability *= share;
        genealogy.add(&level, threshold, share);
        if threshold == 0.0 && level.length == 1 {
            return Ok(Answer::of_share(share, level.points.len()));
        }
        if threshold == 0.0 {
            let variance = genealogy.variance();
            if variance > MOST_VARIANCE {
                return Err(Refused::FewChains { orbits });
            }
            return Answer::new(probability, probability * variance.sqrt(), orbits);
        }
        let (next, taken) = level.next(question, threshold, &mut random)?;
        orbits += taken;
        level = next;
    }
    Err(Refused::NotReached { levels: MOST_LEVELS, orbits, reach: REACH })
}

/// Independent points of the cut Gaussian.
fn first_level<M: Model, const N: usize>(
    question: &Question<M, N>,
    count: usize,
    random: &mut ChaCha8Rng,
) -> Result<(Level<N>, usize), Refused> {
    let points = question.draw(count, random);
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

impl Genealogy {
    /// Adds a level, of whose points `share` have a margin up to `threshold`.
    fn add<const N: usize>(&mut self, level: &Level<N>, threshold: f64, share: f64) {
        let count = level.margins.len() as f64;
        let of_point = |margin: &f64| (f64::from(*margin <= threshold) - share) / (count * share);
        let of_chain = |chain: &[f64]| chain.iter().map(of_point).sum::<f64>();
        let added = level.margins.chunks_exact(level.length).map(of_chain).collect();
        self.of_points += (1.0 - share) / (share * count);
        self.levels.push(Generation { added, parents: level.parents.clone() });
    }

    /// The variance of the logarithm of the probability.
    fn variance(&self) -> f64 {
        (1..=GENERATIONS).map(|generations| self.over(generations)).fold(self.of_points, f64::max)
    }

    /// The variance by families of so many generations.
    fn over(&self, generations: usize) -> f64 {
        let of_level = |level: usize| {
            let eldest = level.saturating_sub(generations);
            let families = self.families(level, eldest);
            let before = (eldest..level).map(|before| 2.0 * product(&families, &self.families(before, eldest)));
            product(&families, &families) + before.sum::<f64>()
        };
        (0..self.levels.len()).map(of_level).sum()
    }

    /// What a level adds, by the chains of the level `eldest` to which its chains go back.
    fn families(&self, level: usize, eldest: usize) -> Vec<f64> {
        let mut sums = self.levels[level].added.clone();
        for younger in (eldest + 1..=level).rev() {
            let mut of_parents = vec![0.0; self.levels[younger - 1].added.len()];
            self.levels[younger].parents.iter().zip(&sums).for_each(|(&parent, sum)| of_parents[parent] += sum);
            sums = of_parents;
        }
        sums
    }
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

//! Rare events: the probability that an orbit of a cloud ever re-enters, or exceeds an eccentricity at a time, down to
//! 1e-9, with an interval. Of a million independent samples one would see an event of 1e-6 once.
//!
//! Everything is done in the standardised coordinates `z` of the initial Gaussian, in which it is the standard normal
//! distribution, cut where the variables end. The *margin* of a point is how far its orbit stays from the event; it is
//! zero or less where the event happens. Two methods ask for margins alone and work for every [`Model`]:
//!
//! - [`mod@importance`]: importance sampling. A pilot looks for all regions of the event, a mixture of Gaussians is
//!   fitted to the probability in them, and independent draws from that mixture, weighted, give an unbiased estimate
//!   with a standard error.
//! - [`mod@subset`]: subset simulation (Au & Beck, Prob. Eng. Mech. 16, 2001), as used by Romano, Losacco, Colombo & Di
//!   Lizia (2020) for collisions and re-entries. It needs no pilot and gives a less accurate answer for the same number
//!   of orbits.
//!
//! | file | idea |
//! |---|---|
//! | `margin` | the margins of points |
//! | `proposal` | mixtures of Gaussians: their density, draws from them, and a fit to weighted points |
//! | `importance`, `subset` | the two methods |

mod importance;
mod margin;
mod proposal;
mod subset;
#[cfg(test)]
mod tests;

pub use importance::importance;
pub use subset::subset;

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::first_passage::empirical::wilson_interval;
use crate::flow::Flow;
use crate::gaussian::Gaussian;
use crate::model::variable::Place;
use crate::model::{Kind, Model};

/// 97.5 % quantile of the standard normal distribution.
const QUANTILE: f64 = 1.959_963_984_540_054;

/// What happens to an orbit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// The re-entry variable reaches its critical value at some time up to the end.
    Ever,
    /// The re-entry variable is above its critical value at the end.
    AtEnd,
}

/// What is asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Question<M, const N: usize> {
    /// The flow that moves the orbits.
    pub flow: Flow<M>,
    /// The cloud at the start: a Gaussian over the model's variables, cut to their ranges.
    pub gaussian: Gaussian<N>,
    /// The end \[yr\].
    pub years: f64,
    /// The critical value of the re-entry variable.
    pub critical: f64,
    /// The event.
    pub event: Event,
}

/// An estimated probability.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// The probability.
    pub probability: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Its 95 % interval, symmetric in the logarithm, in which the estimate of a small probability is nearer to a
    /// normal variable.
    pub interval: (f64, f64),
    /// Number of orbits propagated.
    pub orbits: usize,
}

/// The least probability that is told. Rarer events begin to lie beyond the reach of the pilot, and intervals would be
/// too narrow.
pub const RAREST: f64 = 1e-10;

impl Answer {
    /// From independent orbits of the cloud, of which this share has the event; the interval is Wilson's.
    fn of_share(share: f64, orbits: usize) -> Self {
        let standard_error = (share * (1.0 - share) / orbits as f64).sqrt();
        Self { probability: share, standard_error, interval: wilson_interval(share, orbits as f64), orbits }
    }

    fn new(probability: f64, standard_error: f64, orbits: usize) -> Result<Self, Refused> {
        if probability < RAREST {
            return Err(Refused::TooRare { least: RAREST, orbits });
        }
        let probability = probability.min(1.0);
        let factor = (QUANTILE * standard_error / probability).exp();
        let interval = (probability / factor, (probability * factor).min(1.0));
        Ok(Self { probability, standard_error, interval, orbits })
    }
}

/// Why there is no answer.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Refused {
    /// No orbit of the pilot has the event.
    #[error(
        "none of {orbits} orbits up to {reach} standard deviations from the mean has the event; it is impossible, or rarer than can \
         be found"
    )]
    NothingFound {
        /// Number of orbits tried.
        orbits: usize,
        /// How far they reach.
        reach: f64,
    },
    /// The levels of subset simulation do not come to the event.
    #[error(
        "after {levels} levels with {orbits} orbits no chain had come to the event: it is impossible or rarer than 1e-{levels}, or it \
         lies apart from where the margin leads, which importance sampling finds if it is within {reach} standard deviations"
    )]
    NotReached {
        /// Number of levels.
        levels: usize,
        /// Number of orbits propagated.
        orbits: usize,
        /// How far importance sampling looks.
        reach: f64,
    },
    /// The estimate of subset simulation rests on too few chains.
    #[error(
        "the estimate would rest on a few of the chains that happened to come to the event, and its standard error would be larger than \
         itself; take more than {orbits} orbits, or trust importance sampling"
    )]
    FewChains {
        /// Number of orbits propagated.
        orbits: usize,
    },
    /// The estimate is below what can be told.
    #[error("the estimate from {orbits} orbits is below {least:e}, where intervals would be too narrow to be told")]
    TooRare {
        /// The least probability that is told.
        least: f64,
        /// Number of orbits propagated.
        orbits: usize,
    },
    /// The estimate rests on too few orbits.
    #[error(
        "the estimate would rest on {effective:.0} orbits with the event, which is fewer than the {needed} that an interval needs; \
         take more than {orbits} orbits"
    )]
    TooFew {
        /// Effective number of orbits with the event.
        effective: f64,
        /// The least number.
        needed: f64,
        /// Number of orbits propagated.
        orbits: usize,
    },
    /// The number of orbits asked for.
    #[error("{orbits} orbits are too few to look for an event, at least {least} are needed")]
    TooFewOrbits {
        /// The number asked for.
        orbits: usize,
        /// The least number.
        least: usize,
    },
    /// An orbit could not be followed.
    #[error(
        "the orbit that starts at {place} cannot be followed for {years} yr, so that nothing is known of its event"
    )]
    Lost {
        /// Where it starts.
        place: Place,
        /// The end \[yr\].
        years: f64,
    },
    /// The probability of the cloud itself is not known.
    #[error(
        "more than one variable of the initial Gaussian is cut ({first:.1e} and {second:.1e} of it), so that the probability of what \
         is left is not known; make the cloud narrower, or use subset simulation"
    )]
    CutTwice {
        /// The largest share that is cut.
        first: f64,
        /// The next.
        second: f64,
    },
}

impl<M: Model, const N: usize> Question<M, N> {
    /// Whether the model's variables take the values at a point.
    fn allows(&self, point: &[f64; N]) -> bool {
        let values = self.gaussian.point(*point);
        M::VARIABLES.iter().zip(&values).all(|(variable, &value)| variable.allows(value))
    }

    /// Independent points of the cut Gaussian.
    fn draw(&self, count: usize, random: &mut ChaCha8Rng) -> Vec<[f64; N]> {
        let mut points = Vec::with_capacity(count);
        while points.len() < count {
            let point = std::array::from_fn(|_| StandardNormal.sample(random));
            if self.allows(&point) {
                points.push(point);
            }
        }
        points
    }

    /// The share of the Gaussian that is within the ranges of the variables.
    fn mass_inside(&self) -> Result<f64, Refused> {
        const NEGLIGIBLE: f64 = 1e-4;
        let mut cuts: Vec<f64> = (0..N)
            .map(|k| match M::VARIABLES[k].kind {
                Kind::Circle => 0.0,
                Kind::Interval { low, high } => {
                    let (mean, deviation) = (self.gaussian.mean[k], self.gaussian.deviation(k));
                    normal_tail((mean - low) / deviation) + normal_tail((high - mean) / deviation)
                }
            })
            .collect();
        cuts.sort_by(|a, b| b.total_cmp(a));
        match cuts[..] {
            [first, second, ..] if second > NEGLIGIBLE => Err(Refused::CutTwice { first, second }),
            _ => Ok(1.0 - cuts.iter().sum::<f64>()),
        }
    }
}

/// The probability that a standard normal variable exceeds `z`.
fn normal_tail(z: f64) -> f64 {
    0.5 * libm::erfc(z * std::f64::consts::FRAC_1_SQRT_2)
}

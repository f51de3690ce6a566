//! The radiation parameters with which orbits that start all over the cloud re-enter.
//!
//! Each start of a quasi-random sample is followed with many radiation parameters; where it passes the critical
//! eccentricity with one and not with the next, the border is found by halving. The probability of re-entry for an
//! uncertain parameter is then the mean, over the starts, of the probability of the parameters with which they pass:
//! smooth in everything, so that two thousand starts are mostly enough for an error below 1e-3. Independent replicates
//! of the sample show the error; where it is too large, each replicate gets twice as many starts, up to
//! [`MOST_STARTS`].
//!
//! A band of parameters with which a start passes, or does not, may be narrower than the distance `h` of the logarithms
//! of the parameters that are tried. A band of width `w < h` is seen with the probability `w/h`, since the parameters
//! of each start are shifted by a share of their distance that is even over the starts. So each band that is seen
//! counts `h/w` times, and the mean has no bias (Horvitz & Thompson, J. Am. Stat. Assoc. 47, 1952).

use crate::exact::Estimated;
use crate::exact::measure::normal_tail;
use crate::in_space::draws::Start;
use crate::uncertain::{Distribution, Spread};

use super::cloud::{Cloud, StartWithRadiation};
use super::replicates::{Numbers, REPLICATES, estimated};

/// Most starts of each replicate.
pub const MOST_STARTS: usize = 2048;
/// Distance of the parameters of a start, as a factor.
const FACTOR: f64 = 1.12;
/// What is left of the distance in which a border lies, as a share of the narrowest relative deviation of the
/// parameter; of the parameter itself where that is certain.
const SHARPNESS: f64 = 0.01;
const SHARPEST: f64 = 1e-4;

/// The parameters with which a start passes: ascending borders, and whether it passes below the first.
#[derive(Debug, Clone)]
struct Borders {
    passes_first: bool,
    /// The logarithm of each.
    logarithms: Vec<f64>,
}

/// Which radiation parameters are asked about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asked {
    /// The least and the largest.
    pub ends: (f64, f64),
    /// The narrowest relative deviation of an uncertain one; 0 if one is certain.
    pub narrowest: f64,
    /// Within which orbits pass \[yr\].
    pub years: f64,
}

/// What is known of the starts of a cloud.
#[derive(Debug, Clone)]
pub struct ByOrbits {
    replicates: Vec<Vec<Borders>>,
    /// Distance of the logarithms of the parameters.
    distance: f64,
    /// Starts with a parameter with which nothing is known of the orbit.
    lost: usize,
}

impl ByOrbits {
    /// Starts that are enough by `error`, which says the largest error of what is wanted of them, for an error of
    /// `tolerance`; or the most that there can be.
    pub fn new(cloud: &Cloud, asked: Asked, tolerance: f64, error: impl Fn(&Self) -> f64) -> Self {
        let mut found = Self::none(asked);
        for numbers in Numbers::up_to(MOST_STARTS) {
            found.add(cloud, asked, numbers);
            if error(&found) <= tolerance {
                break;
            }
        }
        found
    }

    /// Without starts.
    fn none(asked: Asked) -> Self {
        Self { replicates: vec![Vec::new(); REPLICATES], distance: lattice(asked).1, lost: 0 }
    }

    /// Adds the starts of these numbers to each replicate.
    fn add(&mut self, cloud: &Cloud, asked: Asked, numbers: std::ops::Range<usize>) {
        for (replicate, known) in self.replicates.iter_mut().enumerate() {
            let starts = cloud.starts(replicate, numbers.clone());
            let (found, lost) = borders(cloud, asked, &starts, replicate * MOST_STARTS + numbers.start);
            known.extend(found);
            self.lost += lost;
        }
    }

    /// How many starts had to be left out of account.
    pub fn lost(&self) -> usize {
        self.lost
    }

    /// The probability of re-entry for a radiation parameter of this mean and spread.
    pub fn probability(&self, mean: f64, spread: Option<Spread>) -> Estimated {
        let found = self.figure(&self.means(mean, spread));
        Estimated { value: found.value.clamp(0.0, 1.0), ..found }
    }

    /// A figure from those of the replicates.
    fn figure(&self, means: &[f64]) -> Estimated {
        estimated(means, self.replicates.iter().map(Vec::len).sum(), self.lost)
    }

    /// The probability of each replicate.
    fn means(&self, mean: f64, spread: Option<Spread>) -> Vec<f64> {
        let above = tail_above(mean, spread);
        let of = |starts: &Vec<Borders>| {
            starts.iter().map(|start| start.share(&above, self.distance)).sum::<f64>() / starts.len().max(1) as f64
        };
        self.replicates.iter().map(of).collect()
    }
}

impl Borders {
    /// The probability of the parameters with which it passes, if `above` is the probability of those above a
    /// logarithm.
    fn share(&self, above: &impl Fn(f64) -> f64, distance: f64) -> f64 {
        let mut passes = self.passes_first;
        let mut share = f64::from(u8::from(passes));
        let mut next = 0;
        while let Some(&border) = self.logarithms.get(next) {
            // Above a border there is re-entry, if there is none below it.
            let sign = if passes { -1.0 } else { 1.0 };
            match self.logarithms.get(next + 1) {
                Some(&end) if end - border < distance => {
                    share += sign * (above(border) - above(end)) * distance / (end - border).max(f64::MIN_POSITIVE);
                    next += 2;
                }
                _ => {
                    share += sign * above(border);
                    passes = !passes;
                    next += 1;
                }
            }
        }
        share
    }
}

/// The probability that a radiation parameter is larger than one whose logarithm is given.
fn tail_above(mean: f64, spread: Option<Spread>) -> impl Fn(f64) -> f64 {
    move |logarithm: f64| {
        let Some(spread) = spread else { return f64::from(u8::from(mean.ln() >= logarithm)) };
        let (middle, sigma) = spread.parameters(mean);
        let variable = match spread.distribution {
            Distribution::Gaussian => logarithm.exp(),
            Distribution::LogNormal => logarithm,
        };
        let lowest = spread.lowest();
        normal_tail(((variable - middle) / sigma).max(lowest)) / normal_tail(lowest)
    }
}

/// Number and distance of the logarithms of the parameters that are tried.
fn lattice(Asked { ends: (low, high), .. }: Asked) -> (u32, f64) {
    let length = (high / low).ln();
    let parts = (length / FACTOR.ln()).ceil().max(1.0);
    (parts as u32, length / parts)
}

/// The fractional part of the golden ratio, whose multiples are spread evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// The borders of some starts, the first of which has this number, and how many of them have an orbit of which nothing
/// is known.
fn borders(cloud: &Cloud, asked: Asked, starts: &[Start], first: usize) -> (Vec<Borders>, usize) {
    let (parts, distance) = lattice(asked);
    let (low, high) = (asked.ends.0.ln(), asked.ends.1.ln());
    // Each start has parameters of its own, so that together they are everywhere.
    let logarithms = |start: usize| {
        let shift = (0.5 + (first + start) as f64 * GOLDEN).fract();
        let inside = (0..parts).map(move |k| low + distance * (f64::from(k) + shift));
        let is_single = high <= low;
        [low].into_iter().chain(inside.chain([high]).filter(move |_| !is_single))
    };
    let asks: Vec<(usize, f64)> =
        (0..starts.len()).flat_map(|start| logarithms(start).map(move |c| (start, c))).collect();
    let mut lost = vec![false; starts.len()];
    let mut pass = |asks: &[(usize, f64)]| {
        let orbits: Vec<StartWithRadiation> = asks.iter().map(|&(start, log)| (starts[start], log.exp())).collect();
        let times = cloud.passages(&orbits, asked.years);
        asks.iter().zip(&times).filter(|(_, time)| time.is_nan()).for_each(|(&(start, _), _)| lost[start] = true);
        times.into_iter().map(|time| time <= asked.years).collect::<Vec<bool>>()
    };
    let passes = pass(&asks);
    let mut brackets: Vec<(usize, f64, f64, bool)> = Vec::new();
    for (pair, passes) in asks.windows(2).zip(passes.windows(2)) {
        if pair[0].0 == pair[1].0 && passes[0] != passes[1] {
            brackets.push((pair[0].0, pair[0].1, pair[1].1, passes[0]));
        }
    }
    for _ in 0..halvings(asked, distance) {
        let middles: Vec<(usize, f64)> = brackets.iter().map(|&(s, low, high, _)| (s, low.midpoint(high))).collect();
        let passes = pass(&middles);
        for ((_, low, high, first), ((_, middle), passes)) in brackets.iter_mut().zip(middles.iter().zip(passes)) {
            if passes == *first { *low = *middle } else { *high = *middle }
        }
    }
    let per_start = asks.len() / starts.len().max(1);
    let mut found: Vec<Borders> = (0..starts.len())
        .map(|start| Borders { passes_first: passes[start * per_start], logarithms: Vec::new() })
        .collect();
    for (start, low, high, _) in brackets {
        found[start].logarithms.push(low.midpoint(high));
    }
    (found, lost.into_iter().filter(|lost| *lost).count())
}

/// How often the distance in which a border lies is halved.
fn halvings(asked: Asked, distance: f64) -> u32 {
    let width = if asked.narrowest > 0.0 { SHARPNESS * asked.narrowest } else { SHARPEST };
    (distance / width).log2().ceil().max(0.0) as u32
}

#[cfg(test)]
mod tests {
    use super::super::rows::{Point, evaluate};
    use super::*;
    use crate::model::planar::force_from_orbit;
    use crate::model::registry::Planar;
    use crate::problem::{InitialGaussian, Problem};
    use crate::reliability::Quantity;

    fn problem(area: f64, years: f64) -> Problem<Planar> {
        let initial = InitialGaussian { mean_phi: 3.0, mean_e: 0.03, sigma_phi: 0.4, sigma_e: 0.008, correlation: 0.0 };
        Problem { model: force_from_orbit(2.5, area, 1.3).into(), initial, times: vec![0.0, years], critical_e: 0.5925 }
    }

    /// Also where part of the cloud re-enters within the years and the rest later.
    #[test]
    #[ignore = "long; .ci/long runs it"]
    fn its_probabilities_are_those_of_the_exact_curve_within_its_errors() {
        for years in [0.9, 4.0] {
            let row: Vec<Point> = [4.0, 6.5, 7.0, 8.0, 12.0, 30.0]
                .into_iter()
                .map(|area| Point {
                    problem: problem(area, years),
                    spread: Some(Spread { relative: 0.06, distribution: Distribution::LogNormal }),
                })
                .collect();
            let exact = evaluate(&row, Quantity::Reentry { within: years }, 1e-4);
            let radiation = |k: usize| row[k].problem.model.value("radiation").unwrap();
            let asked = Asked { ends: (0.7 * radiation(0), 1.4 * radiation(5)), narrowest: 0.06, years };
            let cloud = Cloud::in_plane(&row[0].problem, row[0].spread).unwrap();
            let sampled = ByOrbits::new(&cloud, asked, 1.0, |_| 0.0);
            for (k, (point, exact)) in row.iter().zip(exact).enumerate() {
                let found = sampled.probability(radiation(k), point.spread);
                let difference = (found.value - exact.value).abs();
                assert!(difference <= found.error + exact.error, "{years} yr: {found:?} {exact:?}");
                assert!(found.error < 3e-3, "{found:?}");
            }
        }
    }
}

//! Orbits of a quasi-random sample, followed to the end of a quantity.

use std::ops::Range;

use crate::exact::Estimated;
use crate::first_passage::empirical::wilson_within;

use super::cloud::{Cloud, StartWithRadiation};
use super::quantity::Quantity;
use super::replicates::{REPLICATES, STANDARD_ERRORS, estimated};

/// Most orbits of each replicate.
pub const MOST_ORBITS: usize = 4096;
/// Where fewer orbits have passed, or all but as few, the spread of the replicates says little of the error.
const FEW: f64 = 20.0;

/// What was found of the orbits of each replicate: when each passes, or the eccentricity that it has in the end.
#[derive(Debug, Clone)]
pub struct Followed {
    quantity: Quantity,
    replicates: Vec<Vec<f64>>,
    /// Orbits that cannot be followed.
    lost: usize,
}

impl Followed {
    /// Without orbits.
    pub fn none(quantity: Quantity) -> Self {
        Self { quantity, replicates: vec![Vec::new(); REPLICATES], lost: 0 }
    }

    /// Follows the starts of these numbers of each replicate.
    pub fn add(&mut self, cloud: &Cloud, numbers: Range<usize>) {
        let starts = (0..REPLICATES).flat_map(|replicate| cloud.starts(replicate, numbers.clone()));
        let orbits: Vec<StartWithRadiation> = starts.map(|start| cloud.with_its_radiation(start)).collect();
        let found = follow(cloud, &orbits, self.quantity);
        for (known, found) in self.replicates.iter_mut().zip(found.chunks(numbers.len())) {
            self.lost += found.iter().filter(|value| value.is_nan()).count();
            known.extend(found);
        }
    }

    /// The figures from which the quantity follows, of each replicate.
    pub(super) fn of_replicates(&self) -> Vec<Vec<f64>> {
        self.replicates.iter().map(|found| figures_of(self.quantity, found)).collect()
    }

    /// The figures from which the quantity follows.
    pub fn figures(&self) -> Vec<Estimated> {
        self.estimated(&self.of_replicates())
    }

    /// Figures from those of the replicates. A probability, or a difference of probabilities, to which few orbits say
    /// anything has at least the error of as many independent ones (Wilson's interval).
    pub(super) fn estimated(&self, of_replicates: &[Vec<f64>]) -> Vec<Estimated> {
        let starts = self.replicates.iter().map(Vec::len).sum();
        let is_mean = matches!(self.quantity, Quantity::MeanEccentricity { .. });
        let figure = |k: usize| {
            let each: Vec<f64> = of_replicates.iter().map(|figures| figures[k]).collect();
            let found = estimated(&each, starts, self.lost);
            let share = found.value.abs();
            if is_mean || share.min(1.0 - share) * starts as f64 >= FEW {
                return found;
            }
            let (low, high) = wilson_within(share.min(1.0), starts as f64, STANDARD_ERRORS);
            Estimated { error: found.error.max(high - share).max(share - low), ..found }
        };
        (0..of_replicates.first().map_or(0, Vec::len)).map(figure).collect()
    }
}

/// When each orbit passes, or its eccentricity in the end.
pub(super) fn follow(cloud: &Cloud, orbits: &[StartWithRadiation], quantity: Quantity) -> Vec<f64> {
    let end = quantity.times().last().copied().unwrap_or(0.0);
    match quantity {
        Quantity::MeanEccentricity { .. } => cloud.eccentricities(orbits, end),
        _ => cloud.passages(orbits, end),
    }
}

/// The figures from which the quantity follows, of orbits of which this was found.
pub(super) fn figures_of(quantity: Quantity, found: &[f64]) -> Vec<f64> {
    let known = || found.iter().copied().filter(|value| !value.is_nan());
    let count = known().count().max(1) as f64;
    match quantity {
        Quantity::MeanEccentricity { .. } => vec![known().sum::<f64>() / count],
        _ => {
            let share = |time: f64| known().filter(|passage| *passage <= time).count() as f64 / count;
            quantity.times().into_iter().map(share).collect()
        }
    }
}

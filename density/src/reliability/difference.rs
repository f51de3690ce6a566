//! The difference of a quantity between two models, or between two methods.

use crate::exact::Estimated;
use crate::first_passage::empirical::wilson_within;
use crate::in_space::SpaceProblem;

use super::UNKNOWN;
use super::cloud::Cloud;
use super::followed::{Followed, MOST_ORBITS, figures_of, follow};
use super::quantity::Quantity;
use super::replicates::{Numbers, STANDARD_ERRORS};
use super::rows::Row;

/// What is subtracted from the quantity of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Other {
    /// The same quantity in the planar model: as if orbit, Sun and Moon were in one plane.
    Planar,
    /// The same quantity by plain Monte Carlo in the same model.
    MonteCarlo {
        /// Orbits of each point.
        samples: usize,
        /// Seed of the draws.
        seed: u64,
    },
}

/// The probability of re-entry, or the mean eccentricity, by Monte Carlo, with an error of three standard errors.
pub fn monte_carlo(cloud: &Cloud, quantity: Quantity, samples: usize, seed: u64) -> Estimated {
    let found = follow(cloud, &cloud.independent(seed, samples), quantity);
    let lost = found.iter().filter(|value| value.is_nan()).count() as f64 / samples.max(1) as f64;
    let value = figures_of(quantity, &found).first().copied().unwrap_or(f64::NAN);
    let error = match quantity {
        Quantity::MeanEccentricity { .. } => {
            let squares: f64 = found.iter().filter(|e| !e.is_nan()).map(|e| (e - value).powi(2)).sum();
            STANDARD_ERRORS * squares.sqrt() / samples.max(1) as f64
        }
        _ => {
            let (low, high) = wilson_within(value, samples as f64, STANDARD_ERRORS);
            (high - value).max(value - low)
        }
    };
    Estimated { value, error: error + lost }
}

/// One figure less another, neither of which says anything about the error of the other.
pub fn less(one: Estimated, other: Estimated) -> Estimated {
    Estimated { value: one.value - other.value, error: one.error + other.error }
}

/// The quantity in space less that in the plane at each of some points, to about `tolerance`. Both have the same
/// starts, so that the error is that of the difference alone.
pub fn space_less_plane(points: &[SpaceProblem], quantity: Quantity, tolerance: f64) -> Row {
    points.iter().map(|point| of_point(point, quantity, tolerance)).collect()
}

fn of_point(point: &SpaceProblem, quantity: Quantity, tolerance: f64) -> Estimated {
    let (Ok(space), Ok(plane)) = (Cloud::in_space(point), Cloud::flattened(point)) else { return UNKNOWN };
    let (mut in_space, mut in_plane) = (Followed::none(quantity), Followed::none(quantity));
    let mut found = UNKNOWN;
    for numbers in Numbers::up_to(MOST_ORBITS) {
        in_space.add(&space, numbers.clone());
        in_plane.add(&plane, numbers);
        let pairs = in_space.of_replicates().into_iter().zip(in_plane.of_replicates());
        let each: Vec<Vec<f64>> =
            pairs.map(|(one, other)| one.iter().zip(other).map(|(one, other)| one - other).collect()).collect();
        let of = |orbits: &Followed| orbits.estimated(&each).first().copied().unwrap_or(UNKNOWN);
        found = Estimated { error: of(&in_space).error.max(of(&in_plane).error), ..of(&in_space) };
        if found.error <= tolerance {
            break;
        }
    }
    found
}

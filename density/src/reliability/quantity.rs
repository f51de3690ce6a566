//! What a map shows of a cloud.

use crate::disposal::time_of;
use crate::exact::{Estimated, Exact, ExactSettings, is_possible};
use crate::first_passage::exact::curve_within;
use crate::flow::{Accuracy, Flow};
use crate::model::registry::Planar;
use crate::problem::Problem;

use super::UNKNOWN;

/// A quantity of a cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Quantity {
    /// The probability that the eccentricity has reached its critical value within these years.
    Reentry {
        /// The years.
        within: f64,
    },
    /// The time \[yr\] by which that probability is reached; infinite if it is not within these years.
    TimeOfReentry {
        /// The probability.
        probability: f64,
        /// The years.
        within: f64,
    },
    /// The factor on the radiation parameter, and so on the area-to-mass ratio, with which that probability is reached
    /// within these years; infinite if not even [`LARGEST_FACTOR`] suffices, 0 if [`SMALLEST_FACTOR`] does.
    RequiredFactor {
        /// The probability.
        probability: f64,
        /// The years.
        within: f64,
    },
    /// The mean eccentricity after these years.
    MeanEccentricity {
        /// The years.
        after: f64,
    },
}

/// Largest factor on the radiation parameter that is tried.
pub const LARGEST_FACTOR: f64 = 20.0;
/// Smallest factor on the radiation parameter that is tried.
pub const SMALLEST_FACTOR: f64 = 0.05;

/// Number of steps into which the years are divided to find a time.
const STEPS: u32 = 200;
/// Largest number of orbits for the figures of a single radiation parameter.
const MOST_ORBITS: usize = 3_000;

impl Quantity {
    /// How many figures of a cloud it is computed from.
    pub(super) fn count(self) -> usize {
        match self {
            Self::TimeOfReentry { .. } => STEPS as usize + 1,
            _ => 1,
        }
    }

    /// Least and largest factor on the radiation parameter whose figures it needs.
    pub(super) fn factors(self) -> (f64, f64) {
        match self {
            Self::RequiredFactor { .. } => (SMALLEST_FACTOR, LARGEST_FACTOR),
            _ => (1.0, 1.0),
        }
    }

    pub(super) fn times(self) -> Vec<f64> {
        match self {
            Self::Reentry { within } | Self::RequiredFactor { within, .. } => vec![within],
            Self::TimeOfReentry { within, .. } => {
                (0..=STEPS).map(|k| within * f64::from(k) / f64::from(STEPS)).collect()
            }
            Self::MeanEccentricity { after } => vec![after],
        }
    }

    /// The figures of a cloud with a certain radiation parameter, to about `tolerance`; `None` if the exact method has
    /// no answer.
    pub(super) fn figures(self, problem: &Problem<Planar>, tolerance: f64) -> Option<Vec<Estimated>> {
        is_possible(&problem.model).ok()?;
        let times = self.times();
        let accuracy = if tolerance > 1e-5 { Accuracy::Coarse } else { Accuracy::Medium };
        let flow = Flow { model: problem.model, accuracy };
        let found = match self {
            Self::MeanEccentricity { after } => {
                let settings =
                    ExactSettings { moment_error: tolerance, most_orbits: MOST_ORBITS, ..ExactSettings::default() };
                let found = Exact::new(problem, &flow, settings).moments(after).ok()?;
                vec![Estimated { value: found.mean_e, error: found.e_error * found.std_e }]
            }
            _ => curve_within(problem, &flow, &times, (tolerance, MOST_ORBITS)).ok()?,
        };
        found.iter().all(|figure| figure.value.is_finite()).then_some(found)
    }

    /// The quantity of a cloud with these figures.
    pub(super) fn of(self, figures: &[Estimated]) -> Estimated {
        match self {
            Self::TimeOfReentry { probability, .. } => self.time(figures, probability),
            _ => figures.first().copied().unwrap_or(UNKNOWN),
        }
    }

    /// The time of a probability, with half the distance between the times at which the curve less and plus its error
    /// has it.
    fn time(self, figures: &[Estimated], probability: f64) -> Estimated {
        if figures.iter().any(|figure| figure.value.is_nan()) {
            return UNKNOWN;
        }
        let times = self.times();
        let with = |sign: f64| {
            let points = times.iter().zip(figures).map(|(&time, p)| (time, p.value + sign * p.error));
            time_of(&points.collect::<Vec<_>>(), probability).unwrap_or(f64::INFINITY)
        };
        let value = with(0.0);
        if value.is_infinite() {
            // It is certain that the time is later only if the curve stays below even with its errors.
            return Estimated { value, error: if with(1.0).is_infinite() { 0.0 } else { f64::INFINITY } };
        }
        let step = times.get(1).copied().unwrap_or(0.0);
        Estimated { value, error: 0.5 * (with(-1.0) - with(1.0)) + 0.05 * step }
    }
}

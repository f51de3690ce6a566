//! DEE in space: characteristics on a lattice, whose interpolated flow is read out at many points of equal probability.
//!
//! A density over four or five variables on a mesh would take more characteristics than anyone can follow. What is
//! asked of it are moments and densities of one variable or two, which are integrals over all others. So the
//! characteristics are the orbits of a flow map ([`density::flow_map`]): Chebyshev points of boxes that are halved
//! where the flow bends. The map takes points of a scrambled Sobol sequence through the initial Gaussian to where they
//! are at a snapshot. Each carries its share of the probability, which the flow keeps, also one that does not keep the
//! measure. Independent replicates of the points show the error of what is read out.

use std::num::NonZeroUsize;

use density::flow_map::Settings as MapSettings;
use density::in_space::SpaceProblem;
use density::sampling::{Draws, SamplingPlan};
use kit::Form;
use kit::assignment::Assignment;
use kit::failure::Failure;
use kit::shard::Shard;
use messages::content::Samples;

use super::settings::{POINTS, Settings};
use crate::methods::map_refusal::By;
use crate::methods::mapped_samples::{MappedSamples, Mapping};

/// Independent replicates of the points at which the flow is read out.
const REPLICATES: usize = 16;
/// The largest error of the map, as a share of the smallest deviation at the start, and its bounds.
const SHARE: f64 = 5e-4;
const ERRORS: (f64, f64) = (1e-10, 1e-5);
/// A box that holds less probability is not halved again: its points are propagated directly.
const SMALLEST_SHARE: f64 = 1e-3;
/// How far the boxes reach from the mean, in standard deviations; 3e-5 of the points lie beyond, and are propagated
/// directly.
const REACH: f64 = 4.5;
/// A map that covers less is refused: it would not be DEE any more.
const LEAST_MAPPED: f64 = 0.2;

/// The points of the scenario under way.
#[derive(Debug)]
pub struct InSpace(MappedSamples);

impl InSpace {
    /// The points at the start, and what is sent of them.
    ///
    /// # Errors
    /// A setting that is for the plane, or a flow that bends too much for the characteristics allowed.
    pub fn new(
        problem: &SpaceProblem,
        settings: &Settings,
        shard: Shard,
        assignment: &Assignment,
    ) -> Result<(Self, Form), Failure> {
        settings.check_in_space(shard)?;
        let replicates = NonZeroUsize::new(REPLICATES).unwrap_or(NonZeroUsize::MIN);
        let mapping = Mapping {
            by: By::Cells,
            plan: SamplingPlan { draws: Draws::Sobol, seed: 1, replicates },
            numbers: 0..POINTS,
            accuracy: settings.accuracy.unwrap_or_default().0,
            map: MapSettings {
                error: largest_error(problem),
                most_orbits: settings.samples,
                smallest_share: SMALLEST_SHARE,
                least_mapped: LEAST_MAPPED,
                reach: REACH,
            },
            passages: false,
        };
        let form = Form::whole(Samples { replicates: REPLICATES as u32 }, POINTS);
        Ok((Self(MappedSamples::new(mapping, assignment)?), form))
    }

    /// Moves the points to a snapshot and returns how many there are.
    ///
    /// # Errors
    /// The point that cannot be followed.
    pub fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        self.0.advance(index)
    }

    /// Writes the variables of all points.
    pub fn write(&self, columns: &mut [f64]) {
        self.0.write(columns);
    }

    /// Number of characteristics, with the points that are propagated directly.
    pub fn trajectories(&self) -> u64 {
        self.0.orbits() as u64
    }

    /// The estimate of the map's error.
    pub fn error(&self) -> f64 {
        self.0.error()
    }
}

/// The largest error of a coordinate of the state, small beside every deviation that the cloud has.
fn largest_error(problem: &SpaceProblem) -> f64 {
    let [_, e, inclination, _] = problem.initial.mean;
    let [phi, sigma_e, sigma_inclination, node] = problem.initial.sigma;
    let widths = [phi * e.max(sigma_e), sigma_e, sigma_inclination, node * inclination.max(sigma_inclination).sin()];
    let smallest = widths.into_iter().filter(|width| *width > 0.0).fold(1.0, f64::min);
    (SHARE * smallest).clamp(ERRORS.0, ERRORS.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use density::in_space::example;

    #[test]
    fn a_setting_for_the_plane_is_refused_by_name() {
        for (text, key) in [
            ("mode = \"as-printed\"", "mode = \"as-printed\""),
            ("placement = \"random\"", "placement"),
            ("mesh = \"hull\"", "mesh"),
        ] {
            let settings: Settings = toml::from_str(text).unwrap();
            let why = settings.check_in_space(Shard::WHOLE).unwrap_err().to_string();
            assert!(why.contains(&format!("{key}: in space")), "{why}");
        }
        toml::from_str::<Settings>("samples = 300_000").unwrap().check_in_space(Shard::WHOLE).unwrap();
    }

    #[test]
    fn the_map_is_finer_for_a_narrower_cloud_and_knows_no_certain_variable() {
        let mut problem = example::problem();
        assert!((largest_error(&problem) - 7.25e-6).abs() < 1e-12, "the width in phi: {}", largest_error(&problem));
        problem.initial.sigma = [1e-3, 1e-3, 0.0, 0.0];
        assert!((largest_error(&problem) - 7.25e-8).abs() < 1e-12, "{}", largest_error(&problem));
    }
}

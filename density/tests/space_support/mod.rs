//! Four clouds on inclined orbits over ten years, and their moments by randomised quasi-Monte Carlo, with which methods
//! in space are compared.

use std::f64::consts::TAU;
use std::num::NonZeroUsize;

use density::angle::nearest;
use density::flow::{Accuracy, Passages};
use density::in_space::sampled::Sampled;
use density::in_space::{InitialInSpace, REENTRY, SpaceProblem};
use density::model::planar::SrpJ2;
use density::model::space_registry::SpaceModel;
use density::model::sun_moon::SunMoon;
use density::model::vectorial::Vectorial;
use density::projected::{Cloud, Errors, Question, of_samples};
use density::sampling::{Draws, SamplingPlan};
use density::uncertain::{Distribution, Spread};

/// Snapshot times \[yr\].
pub const TIMES: [f64; 5] = [0.0, 1.0, 3.0, 6.0, 10.0];
pub const NAMES: [&str; 4] = ["medium", "navigation", "sun-synchronous", "uncertain"];

/// The forces on an orbit of a semi-major axis \[Earth radii\], from those at 2.5: oblateness goes with `n/a²`, the
/// tides with `1/n`.
fn forces(axis: f64, radiation: f64) -> SunMoon {
    let ratio: f64 = axis / 2.5;
    let force = SrpJ2 { radiation, oblateness: 0.409_204 * ratio.powf(-3.5) };
    SunMoon { force, sun: 4.7622e-4 * ratio.powf(1.5), moon: 1.037e-3 * ratio.powf(1.5) }
}

fn problem(axis: f64, radiation: f64, initial: InitialInSpace, spread: Option<Spread>) -> SpaceProblem {
    let model = Vectorial { forces: forces(axis, radiation), obliquity: 0.409, sun_longitude: 1.0 };
    let model = SpaceModel::Vectorial { model, axis: Some(axis) };
    let critical_e = 1.0 - 1.0188 / axis;
    let times = TIMES.into();
    SpaceProblem { model, initial, spread, times, critical_e, shadow: false, reentry_altitude: None }.checked().unwrap()
}

/// One of [`NAMES`].
pub fn scenario(name: &str) -> SpaceProblem {
    let degrees = |angle: f64| angle * TAU / 360.0;
    let none = [0.0; 6];
    match name {
        "medium" => problem(
            2.5,
            0.03,
            InitialInSpace {
                mean: [2.2, 0.145, degrees(30.0), 1.0],
                sigma: [0.1, 0.0125, degrees(0.5), degrees(3.0)],
                correlation: [0.3, 0.0, 0.0, -0.3, 0.0, 0.0],
            },
            None,
        ),
        "navigation" => problem(
            4.16,
            0.02,
            InitialInSpace {
                mean: [4.0, 0.3, degrees(55.0), 2.0],
                sigma: [0.08, 0.01, degrees(0.5), degrees(2.0)],
                correlation: none,
            },
            None,
        ),
        "sun-synchronous" => problem(
            1.15,
            0.01,
            InitialInSpace {
                mean: [0.5, 0.05, degrees(98.0), 4.0],
                sigma: [0.1, 0.005, degrees(0.3), degrees(1.0)],
                correlation: [0.0, 0.0, 0.5, 0.0, 0.0, 0.0],
            },
            None,
        ),
        _ => problem(
            3.0,
            0.05,
            InitialInSpace {
                mean: [1.0, 0.2, degrees(20.0), 5.0],
                sigma: [0.05, 0.01, degrees(0.5), degrees(2.0)],
                correlation: none,
            },
            Some(Spread { relative: 0.02, distribution: Distribution::Gaussian }),
        ),
    }
}

/// What is asked of a cloud.
pub fn asked<T>(problem: &SpaceProblem, answer: impl FnOnce(&Question<'_>) -> T) -> T {
    let circles: Vec<bool> = problem.variables().iter().map(|variable| variable.is_circle()).collect();
    answer(&Question { circles: &circles, projections: &[], critical: (REENTRY, problem.critical_e) })
}

/// Independent replicates of all samples here.
pub const REPLICATES: usize = 16;

/// Scrambled Sobol points with a seed.
pub fn plan(seed: u64) -> SamplingPlan {
    SamplingPlan { draws: Draws::Sobol, seed, replicates: NonZeroUsize::new(REPLICATES).unwrap() }
}

/// The clouds at the snapshots by so many orbits.
pub fn by_qmc(problem: &SpaceProblem, orbits: usize) -> Vec<Cloud> {
    let sampled = Sampled { problem, simplification: None, plan: plan(11), accuracy: Accuracy::Medium };
    let mut cloud = sampled.cloud(0..orbits).unwrap();
    let mut passed = vec![0; orbits];
    let at = |&time: &f64| {
        let passages = Passages { passages: &mut passed, pending: 0, note: &|_| 1 };
        cloud.advance_watching(time, problem.critical_e, passages).unwrap();
        let mut columns = vec![0.0; problem.variables().len() * orbits];
        cloud.read_out(&mut columns);
        let columns: Vec<&[f64]> = columns.chunks_exact(orbits).collect();
        asked(problem, |question| of_samples(&columns, question, Some(REPLICATES)))
    };
    problem.times.iter().map(at).collect()
}

/// How far the moments of one cloud are from those of another, for each variable: the mean in deviations, the deviation
/// relative to itself; each less twice the standard error of the difference.
pub fn apart(found: &Cloud, right: &Cloud) -> Vec<[f64; 2]> {
    let error = |of: fn(&Errors) -> &Vec<f64>, k: usize| {
        let errors = [found, right].map(|cloud| cloud.errors.as_ref().map_or(0.0, |errors| of(errors)[k]));
        errors[0].hypot(errors[1])
    };
    let one = |k: usize| {
        let deviation = right.covariance[k][k].sqrt();
        let mean = found.mean[k] - right.mean[k];
        let mean = if right.circular[k].is_some() { nearest(mean, 0.0) } else { mean };
        let wide = found.covariance[k][k].sqrt() - deviation;
        let beyond = |off: f64, error: f64| (off.abs() - 2.0 * error).max(0.0) / deviation.max(1e-9);
        [beyond(mean, error(|errors| &errors.mean, k)), beyond(wide, error(|errors| &errors.deviation, k))]
    };
    (0..found.mean.len()).map(one).collect()
}

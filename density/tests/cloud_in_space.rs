//! Clouds of the same orbits in three models.
#![allow(missing_docs)]

use std::num::NonZeroUsize;

use density::flow::{Accuracy, Passages};
use density::in_space::sampled::Sampled;
use density::in_space::{SpaceProblem, example};
use density::model::model_name::ModelName;
use density::model::osculating::Osculating;
use density::model::space_registry::SpaceModel;
use density::model::vectorial::Vectorial;
use density::sampling::{Draws, SamplingPlan};

/// The variables of all orbits at a time, one column after the other.
fn carried(problem: &SpaceProblem, simplification: Option<ModelName>, orbits: usize, time: f64) -> Vec<Vec<f64>> {
    let plan = SamplingPlan { draws: Draws::Independent, seed: 4, replicates: NonZeroUsize::MIN };
    let sampled = Sampled { problem, simplification, plan, accuracy: Accuracy::Fine };
    let mut cloud = sampled.cloud(0..orbits).unwrap();
    let mut passed = vec![0; orbits];
    let passages = Passages { passages: &mut passed, pending: 0, note: &|_| 1 };
    cloud.advance_watching(time, problem.critical_e, passages).unwrap();
    cloud.settle().unwrap();
    let mut columns = vec![0.0; problem.variables().len() * orbits];
    cloud.read_out(&mut columns);
    columns.chunks_exact(orbits).map(<[f64]>::to_vec).collect()
}

fn apart(a: f64, b: f64) -> f64 {
    density::angle::nearest(a - b, 0.0).abs()
}

#[test]
fn in_the_equator_without_obliquity_every_orbit_is_the_planar_models() {
    let mut flat = example::problem();
    let Vectorial { forces, sun_longitude, .. } = flat.model.averaged();
    flat.model = SpaceModel::Vectorial { model: Vectorial { forces, sun_longitude, obliquity: 0.0 }, axis: None };
    (flat.initial.mean[2], flat.initial.sigma[2]) = (0.0, 0.0);
    flat.initial.correlation = [0.3, 0.0, 0.0, 0.0, 0.0, 0.0];
    let (in_space, planar) = (carried(&flat, None, 200, 2.0), carried(&flat, Some(ModelName::Planar), 200, 2.0));
    for i in 0..200 {
        let e = in_space[1][i];
        assert!((e - planar[1][i]).abs() < 1e-10 && e * apart(in_space[0][i], planar[0][i]) < 1e-10, "orbit {i}");
        assert_eq!(in_space[4][i], planar[4][i], "the radiation parameter");
        assert!(in_space[2][i] < 1e-10 && planar[2][i].is_nan() && planar[3][i].is_nan());
    }
}

/// The example, unaveraged.
fn unaveraged() -> SpaceProblem {
    let mut problem = example::problem();
    let Vectorial { forces, obliquity, sun_longitude } = problem.model.averaged();
    let model = Osculating { semi_major_axis: 2.5, forces, obliquity, sun_longitude, moon_longitude: 0.7 };
    problem.model = SpaceModel::Osculating { model, mean_anomaly: None };
    problem
}

#[test]
fn averages_of_unaveraged_orbits_stay_near_the_averaged_ones() {
    let (full, averaged) =
        (carried(&unaveraged(), None, 48, 0.3), carried(&unaveraged(), Some(ModelName::Vectorial), 48, 0.3));
    for i in 0..48 {
        assert!((full[1][i] - averaged[1][i]).abs() < 4e-3, "e of orbit {i}: {} {}", full[1][i], averaged[1][i]);
        assert!(apart(full[0][i], averaged[0][i]) < 2e-2, "phi of orbit {i}: {} {}", full[0][i], averaged[0][i]);
        assert!((full[2][i] - averaged[2][i]).abs() < 2e-3 && full[4][i] == averaged[4][i], "orbit {i}");
    }
}

#[test]
fn the_averages_at_the_start_are_the_osculating_elements_but_for_what_oscillates() {
    let (full, start) =
        (carried(&unaveraged(), None, 64, 0.0), carried(&unaveraged(), Some(ModelName::Vectorial), 64, 0.0));
    let mean = |k: usize, f: fn(f64) -> f64| (0..64).map(|i| f(full[k][i] - start[k][i])).sum::<f64>() / 64.0;
    let (bias, size) = (mean(1, |x| x), mean(1, |x| x * x).sqrt());
    assert!((1e-5..2e-3).contains(&size), "{size}");
    assert!(
        bias.abs() < 0.5 * size,
        "spread evenly over the revolution, what oscillates is nearly zero on average: {bias} {size}"
    );
}

#[test]
fn a_model_that_needs_more_than_the_scenario_says_is_refused() {
    let problem = example::problem();
    let plan = SamplingPlan { draws: Draws::Independent, seed: 4, replicates: NonZeroUsize::MIN };
    let simplification = Some(ModelName::Osculating);
    let sampled = Sampled { problem: &problem, simplification, plan, accuracy: Accuracy::Fine };
    let why = sampled.cloud(0..1).unwrap_err().to_string();
    assert!(why.contains("does not say where the Moon is"), "{why}");
}

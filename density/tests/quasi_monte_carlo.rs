//! Intervals of randomised quasi-Monte Carlo hold the truth as often as they say, and its errors are far below those of
//! Monte Carlo.
#![allow(missing_docs)]

use std::num::NonZeroUsize;

use density::first_passage::empirical::{EmpiricalCurve, curve_of_groups, point};
use density::flow::{Accuracy, Passages};
use density::in_space::sampled::Sampled;
use density::in_space::{SpaceProblem, example};
use density::model::model_name::ModelName;
use density::projected::{Cloud, Question, of_samples};
use density::sampling::{Draws, SamplingPlan};

const TIMES: [f64; 3] = [0.0, 0.35, 0.5];
const GROUPS: usize = 16;
const VARIABLES: usize = 5;
/// 97.5 % quantile of Student's distribution with 15 degrees of freedom (Abramowitz & Stegun, Table 26.10).
const STUDENT: f64 = 2.131;
/// About half of the example's cloud has reached it by the last time.
const CRITICAL: f64 = 0.53;

/// The cloud at the last time, and its first passages.
fn run(draws: Draws, seed: u64, samples: usize, simplification: Option<ModelName>) -> (Cloud, EmpiricalCurve) {
    let problem = SpaceProblem { critical_e: CRITICAL, ..example::problem() };
    let groups = if draws == Draws::Sobol { GROUPS } else { 1 };
    let plan = SamplingPlan { draws, seed, replicates: NonZeroUsize::new(groups).unwrap() };
    let sampled = Sampled { problem: &problem, simplification, plan, accuracy: Accuracy::Medium };
    let mut cloud = sampled.cloud(0..samples).unwrap();
    let mut points = vec![u8::MAX; samples];
    for time in TIMES {
        let note = |time| point(time, &TIMES) as u8;
        let passages = Passages { passages: &mut points, pending: u8::MAX, note: &note };
        cloud.advance_watching(time, CRITICAL, passages).unwrap();
    }
    let mut columns = vec![0.0; VARIABLES * samples];
    cloud.read_out(&mut columns);
    let columns: Vec<&[f64]> = columns.chunks_exact(samples).collect();
    let circles = [true, false, false, true, false];
    let question = Question { circles: &circles, projections: &[], critical: (1, CRITICAL) };
    let read = of_samples(&columns, &question, (groups > 1).then_some(groups));
    (read, curve_of_groups(points.into_iter().map(usize::from), groups, &TIMES))
}

#[test]
fn intervals_of_replicates_hold_the_truth_in_about_19_of_20_cases() {
    const SEEDS: u64 = 60;
    let (truth, passed) = run(Draws::Sobol, 1_000, GROUPS * 8192, None);
    let (mut held, mut asked) = (0, 0);
    let mut ask = |is_held: bool| {
        asked += 1;
        held += u32::from(is_held);
    };
    for seed in 0..SEEDS {
        let (cloud, curve) = run(Draws::Sobol, seed, GROUPS * 64, None);
        let errors = cloud.errors.unwrap();
        for k in 0..4 {
            ask((cloud.mean[k] - truth.mean[k]).abs() <= STUDENT * errors.mean[k]);
            let deviation = |cloud: &Vec<Vec<f64>>| cloud[k][k].sqrt();
            let off = deviation(&cloud.covariance) - deviation(&truth.covariance);
            ask(off.abs() <= STUDENT * errors.deviation[k]);
        }
        ask((cloud.above - truth.above).abs() <= STUDENT * errors.above);
        let (low, high) = curve.interval.unwrap()[2];
        ask((low..=high).contains(&passed.probability[2]));
    }
    assert!((0.3..0.7).contains(&passed.probability[2]), "{passed:?}");
    let share = f64::from(held) / f64::from(asked);
    println!("{held} of {asked} intervals hold the truth: {share:.3}");
    // Ten figures of one cloud are dependent: the standard error of the share is at most that of 60 clouds, 2.8 %.
    assert!((0.90..0.985).contains(&share), "{held} of {asked}");
}

#[test]
fn the_error_of_a_mean_is_far_below_that_of_as_many_independent_draws() {
    for simplification in [None, Some(ModelName::Planar)] {
        let error = |draws| {
            let (cloud, _) = run(draws, 3, GROUPS * 1024, simplification);
            cloud.errors.unwrap().mean
        };
        let (independent, sobol) = (error(Draws::Independent), error(Draws::Sobol));
        println!("standard errors of the means of phi and e: {independent:?} independent, {sobol:?} Sobol");
        assert!(sobol[0] < 0.02 * independent[0] && sobol[1] < 0.02 * independent[1]);
    }
}

#[test]
fn monte_carlo_and_quasi_monte_carlo_agree_within_their_errors() {
    let (mc, _) = run(Draws::Independent, 9, 20_000, None);
    let (qmc, _) = run(Draws::Sobol, 9, GROUPS * 1024, None);
    let errors = mc.errors.unwrap();
    for k in 0..VARIABLES {
        assert!((mc.mean[k] - qmc.mean[k]).abs() < 4.0 * errors.mean[k], "{k}");
        for l in 0..VARIABLES {
            assert!((mc.covariance[k][l] - qmc.covariance[k][l]).abs() < 4.5 * errors.covariance[k][l], "{k} {l}");
        }
    }
    assert!((mc.above - qmc.above).abs() < 4.0 * errors.above);
}

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use super::*;
use crate::estimate::{Estimate, Moments, weighted_moments};
use crate::flow::Flow;
use crate::grid::comparison_grids;
use crate::orbits::Orbits;
use crate::problem::paper::scenario;
use crate::sampling::draw;
use crate::standard_errors::{self, Cut};

/// Samples of a paper's scenario at its snapshots, with the grids.
fn clouds(number: u32, samples: usize) -> Vec<(Vec<f64>, Vec<f64>, Grid)> {
    let problem = scenario(number as _);
    let flow = Flow::new(problem.model);
    let grids = comparison_grids(&problem, &flow, 100, 100).unwrap();
    let (x1, x2) = draw(&problem.initial, 3, samples);
    let mut orbits = Orbits::new(flow, x1, x2);
    let at = |(&time, grid): (&f64, Grid)| {
        orbits.advance_to(time).unwrap();
        let (mut phi, mut e) = (vec![0.0; samples], vec![0.0; samples]);
        orbits.read_out(&mut phi, &mut e);
        (phi, e, grid)
    };
    problem.times.iter().zip(grids).map(at).collect()
}

/// Central moments `m_20, m_40, m_02, m_04, m_11, m_22` in two passes.
fn central(phi: &[f64], e: &[f64], moments: &Moments, centre: f64) -> [f64; 6] {
    let mut sums = [0.0; 6];
    for (&phi, &e) in phi.iter().zip(e) {
        let (a, b) = (nearest(phi, centre) - moments.mean_phi, e - moments.mean_e);
        let terms = [a * a, a.powi(4), b * b, b.powi(4), a * b, a * a * b * b];
        sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
    }
    sums.map(|sum| sum / phi.len() as f64)
}

#[test]
fn moments_and_their_errors_are_those_of_two_passes() {
    let mut beside_the_cut = 0;
    for number in 1..=3 {
        for (k, (phi, e, grid)) in clouds(number, 20_000).iter().enumerate() {
            let estimate = estimate(phi, e, *grid, 0.6);
            let (moments, circular) = weighted_moments(phi, e, None, 0.6);
            let expected_errors = standard_errors::of_independent(
                phi.len() as f64,
                central(phi, e, &moments, circular.mean),
                Cut::default(),
                moments.prob_above_critical_e,
            );
            let deviations = [moments.std_phi, moments.std_phi, moments.std_e, moments.std_e];
            let scales = deviations.into_iter().chain([moments.std_phi * moments.std_e, 1.0]);
            // Clouds with samples beside the cut of the branch are left to other tests.
            let from_cut = |&phi: &f64| PI - nearest(phi - circular.mean, 0.0).abs();
            if phi.iter().map(from_cut).fold(f64::INFINITY, f64::min) < 4.0 * TAU / SECTORS as f64 {
                beside_the_cut += 1;
                continue;
            }
            let pairs = estimate.moments.to_array().into_iter().zip(moments.to_array()).zip(scales);
            for (quantity, ((found, expected), scale)) in pairs.enumerate() {
                let error = (found - expected).abs() / scale;
                assert!(error < 1e-12, "scenario {number}, snapshot {k}, quantity {quantity}: {error:e}");
            }
            let pairs = estimate.standard_errors.to_array().into_iter().zip(expected_errors.to_array());
            for (quantity, (found, expected)) in pairs.enumerate() {
                let error = (found - expected).abs() / expected.max(1e-300);
                assert!(
                    expected == found || error < 1e-12,
                    "scenario {number}, snapshot {k}, error {quantity}: {found} {expected}"
                );
            }
            assert!((estimate.circular.mean - circular.mean).abs() < 1e-13);
            assert!((estimate.circular.resultant - circular.resultant).abs() < 1e-13);
        }
    }
    assert!(beside_the_cut < 3, "{beside_the_cut}");
}

#[test]
fn a_cloud_that_reaches_round_the_circle_is_cut_at_the_antipode_to_a_part_of_a_sector() {
    let problem = scenario(1);
    let (u, v) = draw(&problem.initial, 9, 20_000);
    // The centre of the cloud is about a standard deviation from the origin.
    let (a, b) = (u.iter().sum::<f64>() / 2e4, v.iter().sum::<f64>() / 2e4);
    let polar = |(u, v): (&f64, &f64)| {
        let (x1, x2) = (u - a + 0.01, v - b + 0.03);
        (x1.atan2(x2).rem_euclid(TAU), x1.hypot(x2))
    };
    let (phi, e): (Vec<f64>, Vec<f64>) = u.iter().zip(&v).map(polar).unzip();
    for centre in [0.0, 0.4, 1.7, 3.0, 5.0] {
        let grid = Grid {
            phi: Axis { low: centre - PI, high: centre + PI, bins: 20 },
            e: Axis { low: 0.0, high: 0.2, bins: 20 },
        };
        let found = estimate(&phi, &e, grid, 0.6).moments;
        let (moments, circular) = weighted_moments(&phi, &e, None, 0.6);
        // A turn, times the unevenness of a sector's samples: a few of some twenty.
        let beside = |phi: f64| PI - nearest(phi - circular.mean, 0.0).abs() < TAU / SECTORS as f64;
        let near = phi.iter().filter(|&&phi| beside(phi)).count() as f64;
        let tolerance = TAU * near.sqrt() / 2e4;
        assert!(near > 10.0, "{near}");
        assert!((found.mean_phi - moments.mean_phi).abs() < tolerance, "{centre}: {found:?} {moments:?}");
        assert!((found.std_phi - moments.std_phi).abs() < 2.0 * tolerance, "{centre}: {found:?} {moments:?}");
    }
}

#[test]
fn standard_errors_are_the_spread_over_seeds_also_where_the_cloud_reaches_round_the_circle() {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};
    const SEEDS: u64 = 400;
    let grid = Grid { phi: Axis { low: 0.0, high: TAU, bins: 10 }, e: Axis { low: 0.0, high: 0.6, bins: 10 } };
    for (sigma, skew, samples) in [(0.3, 0.0, 1000), (1.2, 0.2, 2000), (1.9, 0.3, 4000), (2.1, -0.2, 8000)] {
        let one = |seed: u64| {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
            let (phi, e): (Vec<f64>, Vec<f64>) = (0..samples)
                .map(|_| {
                    let z = normal();
                    let phi = 1.0 + sigma * (z + skew * z * z);
                    (phi.rem_euclid(TAU), 0.3 + 0.05 * (phi + 0.5).cos() + 0.01 * normal())
                })
                .unzip();
            let found = estimate(&phi, &e, grid, 0.32);
            (found.moments.to_array(), found.standard_errors.to_array())
        };
        let all: Vec<_> = (0..SEEDS).into_par_iter().map(one).collect();
        let centre = all[0].0[0];
        for k in 0..6 {
            let value = |moments: &[f64; 6]| if k == 0 { nearest(moments[0], centre) } else { moments[k] };
            let mean = all.iter().map(|(moments, _)| value(moments)).sum::<f64>() / SEEDS as f64;
            let spread = (all.iter().map(|(moments, _)| (value(moments) - mean).powi(2)).sum::<f64>()
                / (SEEDS - 1) as f64)
                .sqrt();
            let claimed = all.iter().map(|(_, errors)| errors[k]).sum::<f64>() / SEEDS as f64;
            assert!(
                (claimed / spread - 1.0).abs() < 0.15,
                "sigma {sigma}, quantity {k}: standard error {claimed}, spread over seeds {spread}"
            );
        }
    }
}

#[test]
fn any_parts_in_any_order_give_the_same_bytes() {
    for (phi, e, grid) in clouds(1, 5_000) {
        let whole = estimate(&phi, &e, grid, 0.6);
        for parts in [2, 3, 7] {
            let mut sum = SampleSums::empty(grid.len());
            for k in (0..parts).rev() {
                let range = 5_000 * k / parts..5_000 * (k + 1) / parts;
                sum.add(&SampleSums::reduce(&phi[range.clone()], &e[range], &grid, 0.6).unwrap());
            }
            let bits = |estimate: &Estimate| {
                let moments = estimate.moments.to_array().into_iter().chain(estimate.standard_errors.to_array());
                let circular = [estimate.circular.mean, estimate.circular.resultant];
                let numbers = moments.chain(circular).chain(estimate.joint.iter().copied());
                numbers.map(f64::to_bits).collect::<Vec<_>>()
            };
            assert_eq!(bits(&sum.finish(grid)), bits(&whole));
        }
    }
}

#[test]
fn batches_are_summed_and_counted_as_single_samples_are() {
    for (phi, e, grid) in clouds(1, 20_000) {
        let whole = SampleSums::reduce(&phi, &e, &grid, 0.6).unwrap();
        assert_eq!(whole.samples, 20_000);
        for size in [1, 100, 777, 20_000] {
            let mut reducer = Reducer::new(&grid, 0.6);
            phi.chunks(size).zip(e.chunks(size)).for_each(|(phi, e)| reducer.take(phi, e).unwrap());
            assert_eq!(reducer.finish(), whole, "{size} at a time");
        }
    }
}

#[test]
fn the_branch_is_that_of_the_circular_mean_wherever_the_grid_lies() {
    // A cloud of 2 rad; the grid's centre is up to half a turn away, so that its branch cuts the cloud.
    let phi: Vec<f64> = (0..2001).map(|i| (5.5 + 0.001 * f64::from(i)).rem_euclid(TAU)).collect();
    let e: Vec<f64> = (0..2001).map(|i| 0.2 + 1e-5 * f64::from(i)).collect();
    for low in [-3.0, -1.0, 0.0, 1.5, 3.0, 5.6] {
        let grid = Grid { phi: Axis { low, high: low + 1.0, bins: 5 }, e: Axis { low: 0.1, high: 0.3, bins: 5 } };
        let found = estimate(&phi, &e, grid, 0.6);
        let (moments, circular) = weighted_moments(&phi, &e, None, 0.6);
        for (found, expected) in found.moments.to_array().into_iter().zip(moments.to_array()) {
            assert!((found - expected).abs() < 1e-12, "{low}: {found} {expected}");
        }
        assert!((nearest(found.moments.mean_phi - circular.mean, 0.0)).abs() < 1.0);
    }
}

#[test]
fn samples_far_from_the_grid_are_named_or_summed_in_a_wider_frame() {
    let grid = Grid { phi: Axis { low: 1.0, high: 1.01, bins: 2 }, e: Axis { low: 0.1, high: 0.11, bins: 2 } };
    let (phi, e) = ([1.0, 1.005, 2.5], [0.1, 0.105, 0.9]);
    let error = SampleSums::reduce(&phi, &e, &grid, 0.6).unwrap_err();
    assert_eq!((error.phi, error.e), (2.5, 0.9));
    let (moments, _) = weighted_moments(&phi, &e, None, 0.6);
    for (found, expected) in estimate(&phi, &e, grid, 0.6).moments.to_array().into_iter().zip(moments.to_array()) {
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
    assert!(estimate(&[f64::NAN], &[0.1], grid, 0.6).moments.mean_phi.is_nan());
}

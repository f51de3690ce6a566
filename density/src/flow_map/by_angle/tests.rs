//! The map against orbits propagated directly, and its error estimate against what it is really off.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::first_passage::empirical::point;
use crate::first_passage::{curve_times, passage_times};
use crate::flow::Accuracy;
use crate::model::planar::SrpJ2;
use crate::orbits::Orbits;
use crate::problem::paper::scenario;
use crate::sampling::{Draws, SamplingPlan};

const STARTS: usize = 2000;

fn plan() -> SamplingPlan {
    SamplingPlan { draws: Draws::Independent, seed: 5, replicates: std::num::NonZeroUsize::MIN }
}

fn map_of(initial: InitialGaussian, times: &[f64], critical: Option<f64>, settings: &Settings) -> AngleMap<SrpJ2> {
    AngleMap::new(Flow::new(scenario(1).model), &initial, times, critical, settings).unwrap()
}

/// The largest error of a coordinate at all snapshots over random starts that are drawn from the cloud and over as many
/// that are spread evenly within 8.4 deviations, the largest error of the determinant beside the one in closed form,
/// `s_t/s_0`, and the share of the former on panels.
fn off(map: &AngleMap<SrpJ2>, initial: InitialGaussian) -> (f64, f64, f64) {
    let polar = plan().polar(&initial);
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut even = || loop {
        let (a, b): (f64, f64) = (random.random_range(-8.4..8.4), random.random_range(-8.4..8.4));
        let (phi, e) = initial.point(a, b);
        if a.hypot(b) < 8.4 && e > 0.0 && e < 0.9 {
            return (phi, e);
        }
    };
    let starts: Vec<(f64, f64)> = (0..STARTS).map(&polar).chain((0..STARTS).map(|_| even())).collect();
    let starts: Vec<State> = starts.into_iter().map(|(phi, e)| State::from_polar(phi, e)).collect();
    let (x1, x2) = starts.iter().map(|state| (state.x1, state.x2)).unzip();
    let flow = Flow { accuracy: Accuracy::Fine, ..Flow::new(scenario(1).model) };
    let mut orbits = Orbits::new(flow, x1, x2);
    let (mut worst, mut of_area, mut mapped) = (0.0f64, 0.0f64, 0);
    for (index, &time) in map.times().iter().enumerate() {
        orbits.advance_to(time).unwrap();
        for (i, &start) in starts.iter().enumerate() {
            let Some((state, determinant)) = map.state(start, time) else { continue };
            worst = worst.max((state.x1 - orbits.x1()[i]).abs()).max((state.x2 - orbits.x2()[i]).abs());
            of_area = of_area.max((determinant * start.s() / state.s() - 1.0).abs());
            mapped += usize::from(index == 0 && i < STARTS);
        }
    }
    (worst, of_area, mapped as f64 / STARTS as f64)
}

/// The estimate is true within a factor of ten, and the share of the cloud on panels is the one stated.
fn assert_true(name: &str, map: &AngleMap<SrpJ2>, initial: InitialGaussian) {
    let (worst, of_area, mapped) = off(map, initial);
    let summary = map.summary();
    println!("{name}: off by {worst:.2e}, areas by {of_area:.1e}, mapped {mapped:.4}, {summary:?}");
    assert!(worst <= 10.0 * summary.error, "{name}: off by {worst:e}, {:e} was expected", summary.error);
    assert!(summary.error <= 10.0 * worst, "{name}: off by {worst:e} only, {:e} was expected", summary.error);
    assert!((mapped - summary.mapped).abs() < 0.01, "{name}: {mapped} of the starts, not {}", summary.mapped);
}

#[test]
fn the_error_is_the_stated_one_in_the_papers_scenarios_after_two_and_after_a_hundred_years() {
    for number in 1..=3 {
        let initial = scenario(number).initial;
        for (times, error) in [(vec![0.0, 1.0, 2.0], 1e-9), (vec![0.0, 1.0, 2.0], 1e-6), (vec![0.0, 30.0, 100.0], 1e-9)]
        {
            let map = map_of(initial, &times, None, &Settings { error, ..Settings::default() });
            assert_true(&format!("scenario {number}, {times:?}, {error:e}"), &map, initial);
            assert!(
                map.summary().error <= 10.0 * error,
                "what orbits are off over a hundred years comes to the error of the map"
            );
        }
    }
}

/// The saddle of the paper's phase portrait lies at phi = 0, e = 0.509659.
fn at_the_saddle() -> InitialGaussian {
    InitialGaussian { mean_phi: 0.05, mean_e: 0.5, sigma_phi: 0.05, sigma_e: 0.01, correlation: 0.3 }
}

#[test]
fn the_error_is_the_stated_one_over_a_separatrix_a_centre_and_zero_eccentricity() {
    // The centre lies at phi = 0, e = 0.277260.
    let at_the_centre =
        InitialGaussian { mean_phi: 0.0, mean_e: 0.277, sigma_phi: 0.1, sigma_e: 0.02, correlation: 0.0 };
    let about_e_zero = InitialGaussian { mean_phi: 0.2, mean_e: 0.03, sigma_phi: 0.4, sigma_e: 0.02, correlation: 0.0 };
    // Next to the separatrix the period depends so strongly on the orbit that after thirty years its rounding alone is
    // above the setting: there 15 % of a cloud over the saddle are left to direct propagation.
    let clouds = [
        ("centre", at_the_centre, [0.99, 0.99]),
        ("e = 0", about_e_zero, [0.99, 0.99]),
        ("saddle", at_the_saddle(), [0.99, 0.8]),
    ];
    for (name, initial, least) in clouds {
        for (years, least) in [2.0, 30.0].into_iter().zip(least) {
            let map = map_of(initial, &[0.0, 0.5 * years, years], None, &Settings::default());
            assert_true(&format!("{name}, {years} yr"), &map, initial);
            assert!(map.summary().mapped > least);
        }
    }
}

#[test]
fn a_map_of_too_few_orbits_is_refused_with_the_place_and_the_reason() {
    let settings = Settings { most_orbits: 60, least_mapped: 0.9, ..Settings::default() };
    let flow = Flow::new(scenario(1).model);
    let refused = AngleMap::new(flow, &at_the_saddle(), &[0.0, 30.0], None, &settings).unwrap_err();
    let words = refused.to_string();
    assert!(words.contains("about phi = "), "{words}");
}

#[test]
fn a_map_does_not_cost_more_orbits_for_a_longer_horizon() {
    let orbits = |years: f64| map_of(scenario(1).initial, &[0.0, years], None, &Settings::default()).summary().orbits;
    let (short, long) = (orbits(2.0), orbits(100.0));
    assert!(long <= 4 * short, "{short} orbits for 2 yr, {long} for 100");
}

#[test]
fn orbits_are_where_direct_propagation_takes_them_and_pass_when_they_do() {
    const COUNT: usize = 4000;
    for (number, critical) in [(1, 0.6), (1, 0.8), (1, 0.15), (2, 0.3), (3, 0.4)] {
        let problem = scenario(number);
        let map = map_of(problem.initial, &problem.times, Some(critical), &Settings::default());
        let mut orbits = AngleOrbits::new(map, 0..COUNT, Box::new(plan().starts(&problem.initial)));
        let (x1, x2) = plan().draw(&problem.initial, COUNT);
        let mut direct = Orbits::new(Flow::new(problem.model), x1.clone(), x2.clone());
        let (mut phi, mut e) = (vec![0.0; COUNT], vec![0.0; COUNT]);
        let (mut right_phi, mut right_e) = (phi.clone(), e.clone());
        for (index, &time) in problem.times.iter().enumerate() {
            orbits.advance_watching(index, critical).unwrap();
            orbits.read_out_columns(&mut phi, &mut e);
            direct.advance_to(time).unwrap();
            direct.read_out(&mut right_phi, &mut right_e);
            for i in 0..COUNT {
                let off = (e[i] - right_e[i]).abs().max(right_e[i] * (phi[i] - right_phi[i]).sin().abs());
                assert!(off < 1e-8, "orbit {i} at {time} yr is off by {off:e}");
            }
        }
        let end = *problem.times.last().unwrap();
        let times = curve_times(end, 65);
        let passages = passage_times(&Flow::new(problem.model), &x1, &x2, critical, end).unwrap();
        let mut right = vec![0; times.len()];
        for &passage in &passages {
            right.get_mut(point(passage, &times)).into_iter().for_each(|count| *count += 1);
        }
        assert_eq!(orbits.passage_counts(&times), right, "scenario {number}, critical e {critical}");
        assert!(orbits.direct() < COUNT / 100, "{} directly", orbits.direct());
    }
}

#[test]
fn orbits_are_the_same_bytes_for_any_number_of_threads_and_kept_or_found_again() {
    const COUNT: usize = 20_000;
    let problem = scenario(1);
    let run = |threads: usize, keeps: bool| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let map = map_of(problem.initial, &problem.times, Some(0.6), &Settings::default());
            let mut orbits = AngleOrbits::new(map, 0..COUNT, Box::new(plan().starts(&problem.initial)));
            if !keeps {
                orbits.kept = None;
            }
            let (mut phi, mut e) = (vec![0.0; COUNT], vec![0.0; COUNT]);
            (0..3).for_each(|index| orbits.advance_watching(index, 0.6).unwrap());
            orbits.read_out_columns(&mut phi, &mut e);
            let bits: Vec<u64> = phi.iter().chain(&e).map(|value| value.to_bits()).collect();
            (bits, orbits.passage_counts(&[0.2, 0.4, 0.8]))
        })
    };
    let once = run(1, true);
    assert!(once == run(3, true) && once == run(2, false));
}

/// Over the saddle, where errors stay as large as the orbit for some halves before they fall.
#[test]
fn a_map_that_may_be_less_accurate_covers_no_less() {
    let model = SrpJ2 { radiation: 0.05, oblateness: 0.5 };
    let initial = InitialGaussian { mean_phi: 0.0, mean_e: 0.511, sigma_phi: 0.05, sigma_e: 0.01, correlation: 0.0 };
    let times = [0.0, 25.0, 50.0, 75.0, 100.0];
    for error in [1e-7, 1e-5, 1e-4, 1e-3] {
        let settings =
            Settings { error, most_orbits: 5000, smallest_share: 1e-3, least_mapped: 0.5, ..Settings::default() };
        let map = AngleMap::new(Flow::new(model), &initial, &times, None, &settings).unwrap();
        let summary = map.summary();
        println!("{error:e}: {summary:?}");
        assert!(summary.mapped > 0.9 && summary.error < 10.0 * error, "{error:e}: {summary:?}");
    }
}

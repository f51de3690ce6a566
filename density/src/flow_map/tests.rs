//! The map against orbits propagated directly, and its error estimates against what it is really off.

use std::num::NonZeroUsize;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::first_passage::empirical::point;
use crate::first_passage::{curve_times, passage_times};
use crate::flow::Accuracy;
use crate::model::planar::SrpJ2;
use crate::model::plane::State;
use crate::orbits::Orbits;
use crate::problem::InitialGaussian;
use crate::problem::paper::scenario;
use crate::sampling::{Draws, SamplingPlan};

/// Random starts for each test.
const STARTS: usize = 20_000;

fn plan() -> SamplingPlan {
    SamplingPlan { draws: Draws::Independent, seed: 5, replicates: NonZeroUsize::MIN }
}

type PlaneMap = FlowMap<SrpJ2, 2>;

fn map_of(initial: InitialGaussian, times: &[f64], critical: Option<f64>, settings: &Settings) -> PlaneMap {
    FlowMap::new(Flow::new(scenario(1).model), initial.into(), times, critical, settings).unwrap()
}

/// The largest error of a coordinate at all snapshots, over random starts that are drawn from the initial Gaussian and
/// over as many that are spread evenly over the domain, and the share of the former in cells.
fn off(map: &PlaneMap, initial: InitialGaussian) -> (f64, f64) {
    let polar = plan().polar(&initial);
    let gaussian = Gaussian::from(initial);
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut even = || gaussian.point([0, 1].map(|_| random.random_range(-REACH..REACH)));
    let starts: Vec<[f64; 2]> = (0..STARTS).map(|i| polar(i).into()).chain((0..STARTS).map(|_| even())).collect();
    let (x1, x2) = starts.iter().map(|&[phi, e]| State::from_polar(phi, e)).map(|state| (state.x1, state.x2)).unzip();
    let flow = Flow { accuracy: Accuracy::Fine, ..Flow::new(scenario(1).model) };
    let mut orbits = Orbits::new(flow, x1, x2);
    let (mut worst, mut mapped) = (0.0f64, 0);
    for (index, &time) in map.times().iter().enumerate() {
        orbits.advance_to(time).unwrap();
        for (i, start) in starts.iter().enumerate() {
            let Some(state) = map.state(start, index) else { continue };
            worst = worst.max((state.x1 - orbits.x1()[i]).abs()).max((state.x2 - orbits.x2()[i]).abs());
            mapped += usize::from(index == 0 && i < STARTS);
        }
    }
    (worst, mapped as f64 / STARTS as f64)
}

/// The estimate is true within a factor of ten, and the share of the cloud in cells is the one stated.
fn assert_true(name: &str, map: &PlaneMap, initial: InitialGaussian) {
    let (worst, mapped) = off(map, initial);
    let summary = map.summary();
    println!("{name}: off by {worst:.2e}, mapped {mapped:.4}, {summary:?}");
    assert!(worst <= 10.0 * summary.error, "{name}: off by {worst:e}, {:e} was expected", summary.error);
    assert!(summary.error <= 10.0 * worst, "{name}: off by {worst:e} only, {:e} was expected", summary.error);
    assert!(
        (mapped - summary.mapped).abs() < 0.01,
        "{name}: {mapped} of the starts are in cells, not {}",
        summary.mapped
    );
}

#[test]
fn the_error_of_a_map_is_the_stated_one_in_the_papers_scenarios() {
    for number in 1..=3 {
        let problem = scenario(number);
        for error in [1e-9, 1e-6] {
            let settings = Settings { error, ..Settings::default() };
            let map = map_of(problem.initial, &problem.times, None, &settings);
            assert_true(&format!("scenario {number} to {error:e}"), &map, problem.initial);
            assert!(map.summary().error <= error);
        }
    }
}

/// The saddle of the paper's phase portrait lies at phi = 0, e = 0.509659.
fn at_the_saddle() -> InitialGaussian {
    InitialGaussian { mean_phi: 0.05, mean_e: 0.5, sigma_phi: 0.05, sigma_e: 0.01, correlation: 0.3 }
}

/// The centre at phi = 0, e = 0.277260, in a cloud that also holds e = 0.
fn about_e_zero() -> InitialGaussian {
    InitialGaussian { mean_phi: 0.2, mean_e: 0.03, sigma_phi: 0.4, sigma_e: 0.02, correlation: 0.0 }
}

#[test]
fn the_error_of_a_map_is_the_stated_one_over_a_separatrix_and_next_to_a_singular_point() {
    for (name, initial, years) in
        [("saddle", at_the_saddle(), 2.0), ("saddle, later", at_the_saddle(), 6.0), ("e = 0", about_e_zero(), 2.0)]
    {
        let times = [0.0, 0.5 * years, years];
        let map = map_of(initial, &times, None, &Settings::default());
        assert_true(name, &map, initial);
    }
}

#[test]
fn the_error_of_a_map_is_the_stated_one_after_thirty_years() {
    for number in [2, 3] {
        let initial = scenario(number).initial;
        let map = map_of(initial, &[0.0, 10.0, 30.0], None, &Settings::default());
        assert_true(&format!("scenario {number}, 30 yr"), &map, initial);
    }
}

#[test]
fn a_map_that_would_take_too_many_orbits_is_refused_with_the_place_and_the_reason() {
    let settings = Settings { most_orbits: 3000, ..Settings::default() };
    let flow = Flow::new(scenario(1).model);
    let refused = PlaneMap::new(flow, at_the_saddle().into(), &[0.0, 30.0], None, &settings).unwrap_err();
    let words = refused.to_string();
    assert!(words.contains("about phi = ") && words.contains("at t = 30 yr, and no orbits were left"), "{words}");
}

#[test]
fn a_map_finer_than_its_orbits_is_refused() {
    let settings = Settings { error: 1e-12, ..Settings::default() };
    let refused = PlaneMap::new(Flow::new(scenario(1).model), scenario(1).initial.into(), &[0.0, 2.0], None, &settings);
    assert!(matches!(refused, Err(Refused::TooFine { .. })), "{refused:?}");
}

fn mapped(number: usize, critical: f64, count: usize) -> MappedOrbits<SrpJ2, 2> {
    let problem = scenario(number);
    let settings = Settings { smallest_share: 1e-4, ..Settings::default() };
    let map = map_of(problem.initial, &problem.times, Some(critical), &settings);
    MappedOrbits::new(map, 0..count, Box::new(plan().starts(&problem.initial)))
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn mapped_orbits_are_where_direct_propagation_takes_them_and_pass_when_they_do() {
    const COUNT: usize = 40_000;
    // The critical values cut through the clouds: some orbits pass, some never, some start above.
    for (number, critical) in [(1, 0.6), (1, 0.8), (1, 0.15), (2, 0.3), (3, 0.4)] {
        let problem = scenario(number);
        let mut orbits = mapped(number, critical, COUNT);
        let (x1, x2) = plan().draw(&problem.initial, COUNT);
        let mut direct = Orbits::new(Flow::new(problem.model), x1.clone(), x2.clone());
        let (mut phi, mut e) = (vec![0.0; COUNT], vec![0.0; COUNT]);
        let (mut right_phi, mut right_e) = (phi.clone(), e.clone());
        for (index, &time) in problem.times.iter().enumerate() {
            orbits.advance_watching(index, critical).unwrap();
            orbits.read_out_columns(&mut [&mut phi, &mut e]);
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
        let counts = orbits.passage_counts(&times);
        println!("{number} {critical}: {} directly, {:?}", orbits.direct(), orbits.map().summary());
        assert_eq!(counts, right, "scenario {number}, critical e {critical}");
        assert!(orbits.direct() < COUNT / 4, "{} directly", orbits.direct());
    }
}

#[test]
fn mapped_orbits_are_the_same_bytes_for_any_number_of_threads_and_kept_or_drawn_again() {
    const COUNT: usize = 70_000;
    let run = |threads: usize, keeps: bool| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut orbits = mapped(1, 0.6, COUNT);
            if !keeps {
                orbits.kept = None;
            }
            let (mut phi, mut e) = (vec![0.0; COUNT], vec![0.0; COUNT]);
            for index in 0..3 {
                orbits.advance_watching(index, 0.6).unwrap();
            }
            orbits.read_out_columns(&mut [&mut phi, &mut e]);
            let bits: Vec<u64> = phi.iter().chain(&e).map(|value| value.to_bits()).collect();
            (bits, orbits.passage_counts(&[0.2, 0.4, 0.8]))
        })
    };
    let once = run(1, true);
    assert!(once == run(3, true) && once == run(2, false));
}

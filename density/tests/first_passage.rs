//! Tests of first passage against rigid rotation, against sampling, and against the rules of probability.

mod common;

use common::{paper, sample};
use density::exact::{Exact, ExactSettings};
use density::first_passage::empirical::empirical_curve;
use density::first_passage::exact::exact_curve;
use density::first_passage::times::first_passage_times;
use density::first_passage::{curve_times, passage_times};
use density::flow::{Flow, Passages};
use density::model::earth::SUN_MEAN_MOTION;
use density::model::planar::SrpJ2;
use density::model::plane::State;
use density::problem::{InitialGaussian, Problem};

/// First time at which an orbit without oblateness reaches `critical_e`: `(x1, x2, s)` turns rigidly about `(0, C, 1)`,
/// so `s` is a constant plus a cosine of time.
fn rotation_first_passage(state: State, radiation: f64, critical_e: f64) -> f64 {
    let norm = 1.0 + radiation * radiation;
    let frequency = SUN_MEAN_MOTION * norm.sqrt();
    let mean = (state.s() + radiation * state.x2) / norm;
    let (cosine, sine) = (state.s() - mean, -SUN_MEAN_MOTION * radiation * state.x1 / frequency);
    let level = ((1.0 - critical_e * critical_e).sqrt() - mean) / cosine.hypot(sine);
    let phase = sine.atan2(cosine);
    match state.eccentricity() >= critical_e {
        true => 0.0,
        false if level < -1.0 => f64::INFINITY,
        // s falls through the level where the phase angle first equals +acos(level).
        false => (level.acos() + phase).rem_euclid(std::f64::consts::TAU) / frequency,
    }
}

#[test]
fn without_oblateness_orbits_pass_when_rigid_rotation_says() {
    let force = SrpJ2 { radiation: 0.2, oblateness: 0.0 };
    let initial = InitialGaussian { mean_phi: 2.0, mean_e: 0.25, sigma_phi: 1.5, sigma_e: 0.08, correlation: 0.0 };
    let problem = Problem { model: force, initial, times: vec![0.0, 1.5], critical_e: 0.45 };
    let (x1, x2) = sample(&problem, 5000, 3);
    let times = first_passage_times(&Flow::new(force), &x1, &x2, 0.45, 1.5).unwrap();
    let (mut never, mut later) = (0, 0);
    for ((&x1, &x2), time) in x1.iter().zip(&x2).zip(times) {
        let expected = rotation_first_passage(State { x1, x2 }, 0.2, 0.45);
        assert!(time == expected || (time - expected).abs() < 1e-9, "{x1} {x2} {time} {expected}");
        never += usize::from(time.is_infinite());
        later += usize::from(time > 0.0 && time.is_finite());
    }
    assert!(never > 100 && later > 100);
}

#[test]
fn a_peak_a_hair_above_the_critical_eccentricity_is_found_and_one_below_is_not() {
    let flow = Flow::new(SrpJ2 { radiation: 0.15, oblateness: 0.40921 });
    // The state at an orbit's peak, on the axis phi = 0 to the left of the saddle, or on phi = π.
    for (x2, before) in [(0.45, 0.37), (-0.75, 0.23), (-0.72, 0.4)] {
        let peak = State { x1: 0.0, x2 };
        let start = flow.advance_one(peak, -before).unwrap();
        assert!(start.eccentricity() < peak.eccentricity());
        for hair in [1e-7, 1e-10] {
            let passage =
                |critical: f64| first_passage_times(&flow, &[start.x1], &[start.x2], critical, 0.6).unwrap()[0];
            let time = passage(peak.eccentricity() - hair);
            // Near its peak e falls as a parabola, with a curvature of the order of 10 per year squared.
            assert!(time <= before && time > before - 20.0 * hair.sqrt(), "{x2} {hair} {time}");
            assert_eq!(passage(peak.eccentricity() + hair), f64::INFINITY);
        }
    }
}

#[test]
fn orbits_that_start_above_have_passed_at_once() {
    let flow = Flow::new(SrpJ2 { radiation: 0.15, oblateness: 0.40921 });
    assert_eq!(first_passage_times(&flow, &[0.0, 0.0], &[0.7, 0.6], 0.6, 1.0).unwrap(), [0.0, 0.0]);
}

#[test]
fn passages_read_off_the_integrators_series_are_those_that_are_searched_for() {
    for (number, critical_e, end) in [(1, 0.6, 2.0), (1, 0.8, 2.0), (2, 0.78, 3.0), (3, 0.4, 2.0)] {
        let problem = Problem { critical_e, ..paper(number) };
        let flow = Flow::new(problem.model);
        let (mut x1, mut x2) = sample(&problem, 5_000, 11);
        let searched = first_passage_times(&flow, &x1, &x2, critical_e, end).unwrap();
        let mut read_off = vec![f64::INFINITY; x1.len()];
        // In unequal intervals, as between snapshots.
        for (from, to) in [(0.0, 0.3 * end), (0.3 * end, 0.35 * end), (0.35 * end, end)] {
            let passages = Passages { passages: &mut read_off, pending: f64::INFINITY, note: &|time| time };
            flow.advance_watching(&mut x1, &mut x2, (from, to), critical_e, passages).unwrap();
        }
        assert_eq!(
            searched.iter().filter(|t| t.is_finite()).count(),
            read_off.iter().filter(|t| t.is_finite()).count()
        );
        for (a, b) in searched.iter().zip(&read_off).filter(|(a, _)| a.is_finite()) {
            // Near a peak the time is as uncertain as the square root of the state's error, 1e-12.
            assert!((a - b).abs() < 1e-5, "{number} {critical_e}: {a} {b}");
        }
        let mut differences: Vec<f64> =
            searched.iter().zip(&read_off).filter(|(a, _)| a.is_finite()).map(|(a, b)| (a - b).abs()).collect();
        differences.sort_by(f64::total_cmp);
        assert!(differences[differences.len() / 2] < 1e-10, "median {}", differences[differences.len() / 2]);
    }
}

#[test]
fn passages_under_strong_radiation_and_oblateness_are_those_that_are_searched_for() {
    for (radiation, oblateness, critical_e) in
        [(0.63, 0.4, 0.6), (2.605, 0.4092, 0.583), (10.0, 10.0, 0.8), (3.0, 0.5, 0.95)]
    {
        let force = SrpJ2 { radiation, oblateness };
        let initial = InitialGaussian { mean_phi: 4.1, mean_e: 0.13, sigma_phi: 0.4, sigma_e: 0.04, correlation: 0.0 };
        let problem = Problem { model: force, initial, times: vec![0.0, 0.5], critical_e };
        let (x1, x2) = sample(&problem, 500, 3);
        let flow = Flow::new(force);
        let read_off = passage_times(&flow, &x1, &x2, critical_e, 0.5).unwrap();
        let searched = first_passage_times(&flow, &x1, &x2, critical_e, 0.5).unwrap();
        for (a, b) in read_off.iter().zip(searched) {
            assert!(*a == b || (a - b).abs() < 1e-5, "C = {radiation}, W = {oblateness}: {a} {b}");
        }
    }
}

#[test]
fn exact_curve_is_within_four_standard_errors_of_a_sample() {
    const ORBITS: usize = 20_000;
    let cases = [(1, 0.6, 2.0), (1, 0.8, 2.0), (2, 0.78, 3.0), (3, 0.4, 2.0)];
    for (number, critical_e, end) in cases {
        let problem = Problem { critical_e, ..paper(number) };
        let flow = Flow::new(problem.model);
        let times = curve_times(end, 65);
        let exact = exact_curve(&problem, &flow, &times).unwrap();
        let (x1, x2) = sample(&problem, ORBITS, 11);
        let passages = first_passage_times(&flow, &x1, &x2, critical_e, end).unwrap();
        let sampled = empirical_curve(&passages, None, &times);
        for ((time, exact), sampled) in times.iter().zip(&exact).zip(sampled.probability) {
            let standard_error = (exact.value * (1.0 - exact.value)).max(0.0).sqrt() / (ORBITS as f64).sqrt();
            let tolerance = 4.0 * standard_error + 1e-6 + 1.0 / ORBITS as f64;
            assert!((exact.value - sampled).abs() < tolerance, "{number} {time} {exact:?} {sampled}");
        }
    }
}

#[test]
fn exact_curve_never_falls_and_is_never_below_the_snapshot_probability() {
    for (number, critical_e, end) in [(1, 0.6, 2.0), (1, 0.8, 2.0), (2, 0.6, 3.0), (3, 0.4, 2.0), (3, 0.6, 2.0)] {
        let problem = Problem { critical_e, ..paper(number) };
        let flow = Flow::new(problem.model);
        let times = curve_times(end, 65);
        let curve = exact_curve(&problem, &flow, &times).unwrap();
        let snapshot = Exact::new(&problem, &flow, ExactSettings::default());
        for (time, point) in times.iter().zip(&curve) {
            assert!(point.error < 1e-6 && point.value > -1e-6 && point.value < 1.0 + 1e-6, "{number} {time} {point:?}");
            let now = snapshot.probability_above(critical_e, *time).unwrap();
            assert!(point.value >= now.value - point.error - now.error - 1e-12, "{number} {time} {point:?} {now:?}");
        }
        for pair in curve.windows(2) {
            assert!(pair[1].value >= pair[0].value - pair[0].error - pair[1].error, "{number} {pair:?}");
        }
    }
}

#[test]
fn exact_curve_without_radiation_is_constant() {
    let problem = Problem { model: SrpJ2 { radiation: 0.0, oblateness: 0.4 }, critical_e: 0.16, ..paper(1) };
    let curve = exact_curve(&problem, &Flow::new(problem.model), &curve_times(1.0, 5)).unwrap();
    // P(e_0 > 0.16) = P(z > 0.6), with the cut at e = 0 below 1e-8.
    assert!(curve.iter().all(|point| (point.value - 0.274_253_117_750_074).abs() < 1e-8), "{curve:?}");
}

//! Tests of the integrator against exact solutions.
#![allow(missing_docs)]

mod common;

use std::f64::consts::{PI, TAU};

use density::flow::{Accuracy, Flow, Loss};
use density::model::PlanarHamiltonian;
use density::model::planar::SrpJ2;
use density::model::plane::State;
use density::problem::InitialGaussian;
use density::sampling::draw;

const PAPER: SrpJ2 = SrpJ2 { radiation: 0.15, oblateness: 0.40921 };

/// Table 1: means of phi and e, half of the deltas of phi and e, and the number of years.
const SCENARIOS: [(f64, f64, f64, f64, f64); 3] = [
    (2.2069, 0.145, PI / 16.0, 0.025, 2.0),
    (0.5419, 0.095, PI / 80.0, 0.005, 3.0),
    (0.3004, 0.23, PI / 64.0, 0.01, 2.0),
];

fn cloud((mean_phi, mean_e, sigma_phi, sigma_e, _): (f64, f64, f64, f64, f64), count: usize) -> (Vec<f64>, Vec<f64>) {
    draw(&InitialGaussian { mean_phi, mean_e, sigma_phi, sigma_e, correlation: 0.0 }, 5, count)
}

fn hamiltonians(x1: &[f64], x2: &[f64]) -> Vec<f64> {
    x1.iter().zip(x2).map(|(&x1, &x2)| PAPER.hamiltonian(State { x1, x2 })).collect()
}

#[test]
fn hamiltonian_is_constant_along_every_trajectory() {
    for scenario in SCENARIOS {
        let (mut x1, mut x2) = cloud(scenario, 20_000);
        let before = hamiltonians(&x1, &x2);
        Flow::new(PAPER).advance(&mut x1, &mut x2, scenario.4).unwrap();
        let drift = before.iter().zip(hamiltonians(&x1, &x2)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(drift <= 1e-12, "H drifts by {drift:e}, 1e-10 is promised");
    }
}

#[test]
fn without_oblateness_the_flow_is_a_rigid_rotation() {
    // (e cos phi, e sin phi, s) turns about the axis (1, 0, C)/sqrt(1 + C²): x2' = x1, x1' = C s - x2, s' = -C x1.
    let c: f64 = 0.15;
    let flow = Flow::new(SrpJ2 { radiation: c, oblateness: 0.0 });
    let frequency = (1.0 + c * c).sqrt();
    for (phi, e) in [(0.0, 0.0), (1.0, 0.3), (2.5, 0.7), (4.0, 0.1), (5.9, 0.55)] {
        let start = State::from_polar(phi, e);
        for years in [0.3, 1.0 / frequency, 2.0, -0.7] {
            // The component along the axis is constant; the rest is a circle through x1.
            let along = (c * start.x2 + start.s()) / (1.0 + c * c);
            let (fixed_x2, across) = (c * along, start.x2 - c * along);
            let angle = TAU * years * frequency;
            let expected = State {
                x1: start.x1 * angle.cos() - across * frequency * angle.sin(),
                x2: fixed_x2 + across * angle.cos() + start.x1 / frequency * angle.sin(),
            };
            let end = flow.advance_one(start, years).unwrap();
            let error = (end.x1 - expected.x1).hypot(end.x2 - expected.x2);
            assert!(error < 1e-12, "phi = {phi}, e = {e}, {years} yr: off by {error:e}");
        }
    }
}

#[test]
fn there_and_back_again_is_where_it_started() {
    let (x1, x2) = cloud(SCENARIOS[0], 1000);
    let (mut y1, mut y2) = (x1.clone(), x2.clone());
    let flow = Flow::new(PAPER);
    flow.advance(&mut y1, &mut y2, 2.0).unwrap();
    flow.advance(&mut y1, &mut y2, -2.0).unwrap();
    let worst = (0..1000).map(|i| (x1[i] - y1[i]).hypot(x2[i] - y2[i])).fold(0.0, f64::max);
    assert!(worst < 1e-11, "{worst:e}");
}

#[test]
fn every_accuracy_keeps_what_it_promises_to_a_cloud() {
    for scenario in SCENARIOS {
        let (x1, x2) = cloud(scenario, 20_000);
        let propagate = |accuracy, pieces: u32| {
            let (mut x1, mut x2) = (x1.clone(), x2.clone());
            for _ in 0..pieces {
                let years = 2.0 / f64::from(pieces);
                Flow { model: PAPER, accuracy }.advance(&mut x1, &mut x2, years).unwrap();
            }
            (x1, x2)
        };
        // In 64 pieces the intervals are far shorter than the steps of the finest series, which gives a reference
        // accurate to rounding.
        let reference = propagate(Accuracy::Fine, 64);
        for accuracy in Accuracy::ALL {
            let (x1, x2) = propagate(accuracy, 4);
            let error = |i: usize| (x1[i] - reference.0[i]).abs().max((x2[i] - reference.1[i]).abs());
            let worst = (0..x1.len()).map(error).fold(0.0, f64::max);
            assert!(worst <= accuracy.largest_error(), "{accuracy:?}: {worst:e}");
        }
    }
}

#[test]
fn every_accuracy_keeps_what_it_promises_against_states_computed_with_40_digits() {
    // From tests/reference/make_states.py: for each orbit phi0, e0, and then t, x1, x2 every half year.
    let rows = common::rows("states.csv");
    assert_eq!(rows.len(), 3 * 17 * 4);
    for accuracy in Accuracy::ALL {
        let flow = Flow { model: PAPER, accuracy };
        let mut worst: f64 = 0.0;
        for orbit in rows.chunks(4) {
            let mut state = State::from_polar(orbit[0].1[0], orbit[0].1[1]);
            let mut now = 0.0;
            for (_, row) in orbit {
                let [_, _, time, x1, x2] = row[..] else { panic!("{row:?}") };
                state = flow.advance_one(state, time - now).unwrap();
                now = time;
                worst = worst.max((state.x1 - x1).abs()).max((state.x2 - x2).abs());
            }
        }
        println!("{accuracy:?}: {worst:.1e}");
        assert!(worst <= accuracy.largest_error(), "{accuracy:?}: {worst:e}");
    }
}

#[test]
fn an_orbit_has_the_same_bytes_on_any_number_of_threads_and_in_any_company() {
    let (x1, x2) = cloud(SCENARIOS[0], 5000);
    let flow = Flow::new(PAPER);
    let on_threads = |threads: usize| {
        let (mut x1, mut x2) = (x1.clone(), x2.clone());
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| flow.advance(&mut x1, &mut x2, 1.3)).unwrap();
        (x1, x2)
    };
    let one = on_threads(1);
    assert!(one == on_threads(3));
    for i in [0, 17, 4999] {
        let alone = flow.advance_one(State { x1: x1[i], x2: x2[i] }, 1.3).unwrap();
        assert_eq!((alone.x1.to_bits(), alone.x2.to_bits()), (one.0[i].to_bits(), one.1[i].to_bits()));
    }
}

#[test]
fn a_thousand_years_in_one_interval_are_followed_whatever_the_accuracy() {
    for accuracy in Accuracy::ALL {
        let flow = Flow { model: PAPER, accuracy };
        let (mut x1, mut x2) = cloud(SCENARIOS[0], 16);
        let before = hamiltonians(&x1, &x2);
        flow.advance(&mut x1, &mut x2, 1000.0).unwrap();
        let drift = before.iter().zip(hamiltonians(&x1, &x2)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(drift < 1000.0 * accuracy.largest_error(), "{accuracy:?}: H drifts by {drift:e}");
    }
}

#[test]
fn an_orbit_that_turns_too_fast_is_told_from_one_that_leaves_the_domain() {
    // Next to e = 1 oblateness turns an orbit by 1e15 rad a year.
    let fast = Flow::new(SrpJ2 { radiation: 0.01, oblateness: 10.0 });
    let error = fast.advance_one(State { x1: 0.0, x2: 0.999_999_9 }, 1e-3).unwrap_err();
    assert_eq!(error.why, Loss::Stuck, "{error}");
    assert!(error.to_string().contains("turns too fast"), "{error}");
    // Without oblateness, strong radiation takes an orbit through e = 1.
    let strong = Flow::new(SrpJ2 { radiation: 3.0, oblateness: 0.0 });
    let error = strong.advance_one(State { x1: 0.0, x2: 0.6 }, 1.0).unwrap_err();
    assert_eq!(error.why, Loss::LeftTheDomain, "{error}");
    assert!(error.to_string().contains("left the domain e < 1"), "{error}");
}

//! A model that is not part of this crate goes through the methods by its trait alone.
//!
//! It is a rigid rotation in space, with three variables, no Hamiltonian and a solution in closed form.

use std::f64::consts::PI;

use density::angle::nearest;
use density::flow::{Flow, Loss, Passages};
use density::gaussian::Gaussian;
use density::mixture::any_model::{MixturePropagator, moments};
use density::mixture::library::{Library, Variance};
use density::mixture::unscented::Unscented;
use density::model::Model;
use density::orbits::Orbits;
use density::sampling::draw_variables;
use density::variable_moments::{VariableMoments, weighted_moments};

mod rotation;
use rotation::RigidRotation;

/// A rotation about the `z` axis: angles grow, and the other variables stay.
const UPRIGHT: RigidRotation = RigidRotation { axis: [0.0, 0.0, 1.0], turns: 4.0 };
/// A rotation about the `x` axis: heights go up and down.
const TILTED: RigidRotation = RigidRotation { axis: [1.0, 0.0, 0.0], turns: 4.0 };

const MEAN: [f64; 3] = [1.0, 5.0, -2.0];
const COVARIANCE: [[f64; 3]; 3] = [[0.04, 0.05, -0.02], [0.05, 0.25, 0.03], [-0.02, 0.03, 0.09]];

fn cloud() -> Gaussian<3> {
    Gaussian::new(MEAN, COVARIANCE).unwrap()
}

/// Compares with the cloud turned about the `z` axis for `years`; each moment must agree to `tolerance` in its natural
/// unit.
fn is_turned_cloud(found: &VariableMoments<3>, years: f64, tolerance: f64) {
    let angle = nearest(found.mean[0], MEAN[0] + UPRIGHT.turns * years);
    let expected = [MEAN[0] + UPRIGHT.turns * years, MEAN[1], MEAN[2]];
    for (k, mean) in [angle, found.mean[1], found.mean[2]].into_iter().enumerate() {
        assert!((mean - expected[k]).abs() < tolerance * COVARIANCE[k][k].sqrt(), "mean {k}: {mean}");
    }
    for (a, b) in (0..9).map(|k| (k / 3, k % 3)) {
        let unit = (COVARIANCE[a][a] * COVARIANCE[b][b]).sqrt();
        let apart = (found.covariance[a][b] - COVARIANCE[a][b]).abs();
        assert!(apart < tolerance * unit, "covariance {a} {b}: {}", found.covariance[a][b]);
    }
}

#[test]
fn monte_carlo_gives_the_moments_of_the_turned_cloud() {
    const SAMPLES: usize = 40_000;
    let columns = draw_variables(&cloud(), RigidRotation::VARIABLES, 1, 0..SAMPLES);
    let mut orbits = Orbits::from_variables(Flow::new(UPRIGHT), &columns.each_ref().map(Vec::as_slice));
    for years in [0.0, 0.7, 2.0] {
        orbits.advance_to(years).unwrap();
        let mut out = [(); 3].map(|()| vec![0.0; SAMPLES]);
        orbits.read_out_columns(&mut out.each_mut().map(Vec::as_mut_slice));
        let found = weighted_moments(RigidRotation::VARIABLES, out.each_ref().map(Vec::as_slice), None);
        is_turned_cloud(&found, years, 4.0 * 1.5 / (SAMPLES as f64).sqrt());
    }
}

#[test]
fn the_unscented_mixture_gives_the_moments_of_the_turned_cloud() {
    for (components, along) in [(1, 0), (5, 1), (15, 2)] {
        let library = Library::new(components, Variance::Kept).unwrap();
        let mut propagator =
            MixturePropagator::new(Flow::new(UPRIGHT), &cloud(), Unscented::THIRD_ORDER, &library, along).unwrap();
        for years in [0.7, 2.0] {
            propagator.advance_to(years).unwrap();
            let mixture = propagator.mixture();
            assert_eq!(mixture.len(), components);
            is_turned_cloud(&moments(RigidRotation::VARIABLES, &mixture), years, 1e-6);
        }
    }
}

#[test]
fn the_unscented_mixture_and_monte_carlo_agree_where_the_flow_bends_the_cloud() {
    const SAMPLES: usize = 40_000;
    let years = 0.3;
    let library = Library::new(15, Variance::Kept).unwrap();
    let mut propagator =
        MixturePropagator::new(Flow::new(TILTED), &cloud(), Unscented::THIRD_ORDER, &library, 0).unwrap();
    propagator.advance_to(years).unwrap();
    let mixture = moments(RigidRotation::VARIABLES, &propagator.mixture());
    let columns = draw_variables(&cloud(), RigidRotation::VARIABLES, 2, 0..SAMPLES);
    let mut orbits = Orbits::from_variables(Flow::new(TILTED), &columns.each_ref().map(Vec::as_slice));
    orbits.advance_to(years).unwrap();
    let mut out = [(); 3].map(|()| vec![0.0; SAMPLES]);
    orbits.read_out_columns(&mut out.each_mut().map(Vec::as_mut_slice));
    let sampled = weighted_moments(RigidRotation::VARIABLES, out.each_ref().map(Vec::as_slice), None);
    for (k, deviation) in sampled.deviations().into_iter().enumerate() {
        assert!((nearest_or(k, mixture.mean[k], sampled.mean[k])).abs() < 0.03 * deviation, "mean {k}");
        assert!((mixture.deviations()[k] / deviation - 1.0).abs() < 0.03, "deviation {k}");
    }
}

/// The difference of two values of a variable, on the circle for the angle.
fn nearest_or(k: usize, a: f64, b: f64) -> f64 {
    if k == 0 { nearest(a, b) - b } else { a - b }
}

#[test]
fn the_first_passage_of_a_height_is_where_the_circle_reaches_it() {
    // From y = 3, z = 0 about the x axis: z = 3 sin(4 t), first at 1.5 when 4 t = π/6.
    let (mut x, mut y, mut z) = (vec![1.0; 3], vec![3.0, 1.0, 3.0], vec![0.0, 0.0, 2.0]);
    let mut times = [f64::INFINITY; 3];
    let passages = Passages { passages: &mut times, pending: f64::INFINITY, note: &|time| time };
    Flow::new(TILTED).carry_watching(&mut [&mut x, &mut y, &mut z], (0.0, 2.0), 1.5, passages).unwrap();
    assert!((times[0] - PI / 24.0).abs() < 1e-12, "{times:?}");
    assert_eq!(times[1..], [f64::INFINITY, 0.0]);
}

#[test]
fn the_flow_runs_backwards_without_a_mirror_image() {
    let flow = Flow::new(TILTED);
    let start = [1.0, -2.0, 0.5];
    let end = flow.carry_one(start, 0.3, 2.3).unwrap();
    let back = flow.carry_one(end, 2.3, 0.3).unwrap();
    assert!(start.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-12), "{back:?}");
    assert_eq!(TILTED.reversed(start), None);
}

#[test]
fn a_rotation_has_no_divergence_and_keeps_volume() {
    let start = [3.0, -4.0, 0.5];
    assert_eq!(TILTED.divergence(0.0, start), 0.0);
    assert_eq!(UPRIGHT.density_growth(start, UPRIGHT.state(0.0, [2.0, 10.0, 0.0])), Some(2.0));
}

#[test]
fn an_orbit_that_leaves_the_domain_is_named_in_the_models_own_words() {
    let mut orbits = Orbits::from_variables(Flow::new(TILTED), &[&[1.5, PI / 2.0], &[5.0, 99.0], &[0.0, 99.0]]);
    let lost = (1..100).find_map(|k| orbits.advance_to(0.01 * f64::from(k)).err()).unwrap();
    assert_eq!((lost.index, lost.why), (1, Loss::LeftTheDomain));
    let told = lost.to_string();
    assert!(told.contains("psi = ") && told.contains(" rad, r = ") && told.contains(" m, z = "), "{told}");
}

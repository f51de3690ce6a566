//! Functions that several tests use.
#![allow(dead_code)]

use std::f64::consts::PI;

use density::model::planar::SrpJ2;
use density::model::plane::State;
use density::problem::{InitialGaussian, Problem};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

/// The three scenarios of the paper's Table 1.
pub fn paper(number: usize) -> Problem {
    let (mean_phi, mean_e, delta_phi, delta_e, snapshots) = match number {
        1 => (2.2069, 0.145, PI / 8.0, 0.05, 5),
        2 => (0.5419, 0.095, PI / 40.0, 0.01, 7),
        _ => (0.3004, 0.23, PI / 32.0, 0.02, 5),
    };
    Problem {
        model: SrpJ2 { radiation: 0.15, oblateness: 0.40921 },
        initial: InitialGaussian {
            mean_phi,
            mean_e,
            sigma_phi: delta_phi / 2.0,
            sigma_e: delta_e / 2.0,
            correlation: 0.0,
        },
        times: (0..snapshots).map(|k| 0.5 * f64::from(k)).collect(),
        critical_e: 0.6,
    }
}

/// The first field, and the numbers after it, of every row of a file in `tests/reference`.
pub fn rows(file: &str) -> Vec<(String, Vec<f64>)> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference").join(file);
    let text = std::fs::read_to_string(path).unwrap();
    text.lines()
        .skip(1)
        .map(|line| {
            let mut fields = line.split(',');
            (fields.next().unwrap().to_string(), fields.map(|field| field.parse().unwrap()).collect())
        })
        .collect()
}

/// Random orbits of the initial cloud: `x1` and `x2`.
pub fn sample(problem: &Problem, count: usize, seed: u64) -> (Vec<f64>, Vec<f64>) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let initial = problem.initial;
    let phi = Normal::new(initial.mean_phi, initial.sigma_phi).unwrap();
    let e = Normal::new(initial.mean_e, initial.sigma_e).unwrap();
    let draws = std::iter::repeat_with(|| (phi.sample(&mut random), e.sample(&mut random)));
    let inside = draws.filter(|&(_, e)| e > 0.0 && e < 1.0).take(count);
    inside.map(|(phi, e)| State::from_polar(phi, e)).map(|state| (state.x1, state.x2)).unzip()
}

//! Tests of Monte Carlo against the exact moments.
#![allow(missing_docs)]

mod common;

use std::f64::consts::{PI, TAU};

use density::binning;
use density::flow::Flow;
use density::grid::comparison_grids;
use density::orbits::Orbits;
use density::sampling::draw;

/// Exact moments by quadrature (`exact-moments.csv`): scenario, time, then mean and standard deviation of phi and of e.
const EXACT: &str = include_str!("reference/exact-moments.csv");

const SAMPLES: usize = 40_000;

/// Standard error of the standard deviation `sigma` of `values` about `mean`, from their fourth moment.
fn error_of_deviation(values: &[f64], mean: f64, sigma: f64) -> f64 {
    let n = values.len() as f64;
    let kurtosis = values.iter().map(|x| ((x - mean) / sigma).powi(4)).sum::<f64>() / n;
    sigma * ((kurtosis - 1.0) / (4.0 * n)).sqrt()
}

#[test]
fn moments_are_exact_within_four_standard_errors_in_all_three_scenarios() {
    let rows: Vec<Vec<&str>> =
        EXACT.lines().filter(|line| line.starts_with("scenario-")).map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 17);
    for number in 1..=3 {
        let (name, problem) = (format!("scenario-{number}"), common::paper(number));
        let flow = Flow::new(problem.model);
        let grids = comparison_grids(&problem, &flow, 100, 100).unwrap();
        let (x1, x2) = draw(&problem.initial, 42, SAMPLES);
        let mut orbits = Orbits::new(flow, x1, x2);
        for (row, (&time, grid)) in rows.iter().filter(|row| row[0] == name).zip(problem.times.iter().zip(grids)) {
            let exact: Vec<f64> = row[1..6].iter().map(|field| field.parse().unwrap()).collect();
            assert_eq!(exact[0], time);
            orbits.advance_to(time).unwrap();
            let (mut phi, mut e) = (vec![0.0; SAMPLES], vec![0.0; SAMPLES]);
            orbits.read_out(&mut phi, &mut e);
            let found = binning::estimate(&phi, &e, grid, problem.critical_e).moments;
            phi.iter_mut().for_each(|phi| *phi = exact[1] + (*phi - exact[1] + PI).rem_euclid(TAU) - PI);
            let root_n = (SAMPLES as f64).sqrt();
            let checks = [
                (found.mean_phi, exact[1], exact[2] / root_n),
                (found.std_phi, exact[2], error_of_deviation(&phi, exact[1], exact[2])),
                (found.mean_e, exact[3], exact[4] / root_n),
                (found.std_e, exact[4], error_of_deviation(&e, exact[3], exact[4])),
            ];
            for (quantity, (found, exact, error)) in checks.into_iter().enumerate() {
                assert!((found - exact).abs() < 4.0 * error, "{name}, {time} yr, quantity {quantity}: {found} {exact}");
            }
        }
    }
}

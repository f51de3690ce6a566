//! Reference values for the tests of the mesh methods: the paper's scenarios, exact moments, and the exact density.
#![allow(dead_code)] // each test file uses only a part

#[path = "../common/mod.rs"]
mod common;

pub use common::paper as scenario;

use density::estimate::{Estimate, Moments};
use density::flow::Flow;
use density::grid::{Grid, comparison_grids};
use density::mesh::{Placement, Points, initial_points};
use density::model::plane::{State, density_growth};
use density::problem::Problem;

/// One snapshot of propagated points.
pub struct Snapshot {
    pub time: f64,
    pub grid: Grid,
    pub x1: Vec<f64>,
    pub x2: Vec<f64>,
    pub phi: Vec<f64>,
    pub e: Vec<f64>,
}

/// The initial points and their snapshots on 100 x 100 comparison grids.
pub fn propagate(problem: &Problem, count: usize, placement: Placement, seed: u64) -> (Points, Vec<Snapshot>) {
    let flow = Flow::new(problem.model);
    let grids = comparison_grids(problem, &flow, 100, 100).unwrap();
    let points = initial_points(problem, count, placement, seed).unwrap();
    let states: Vec<State> = points.phi.iter().zip(&points.e).map(|(&phi, &e)| State::from_polar(phi, e)).collect();
    let mut x1: Vec<f64> = states.iter().map(|state| state.x1).collect();
    let mut x2: Vec<f64> = states.iter().map(|state| state.x2).collect();
    let mut now = 0.0;
    let snapshots = problem.times.iter().zip(grids).map(|(&time, grid)| {
        flow.advance(&mut x1, &mut x2, time - now).unwrap();
        now = time;
        let states: Vec<State> = x1.iter().zip(&x2).map(|(&x1, &x2)| State { x1, x2 }).collect();
        Snapshot {
            time,
            grid,
            x1: x1.clone(),
            x2: x2.clone(),
            phi: states.iter().map(|state| state.solar_angle()).collect(),
            e: states.iter().map(|state| state.eccentricity()).collect(),
        }
    });
    let snapshots = snapshots.collect();
    (points, snapshots)
}

fn rows(csv: &'static str) -> impl Iterator<Item = (Vec<&'static str>, Vec<f64>)> {
    csv.lines().skip(1).map(|line| {
        let fields: Vec<&str> = line.split(',').collect();
        let numbers = fields[1..].iter().map(|field| field.parse().unwrap()).collect();
        (fields, numbers)
    })
}

/// Moments of a scenario by quadrature over the initial Gaussian, accurate to 1e-6.
pub fn exact_moments(scenario: usize, time: f64) -> Moments {
    let name = format!("scenario-{scenario}");
    rows(include_str!("../reference/exact-moments.csv"))
        .find(|(fields, numbers)| fields[0] == name && numbers[0] == time)
        .map(|(_, numbers)| Moments::from_array(std::array::from_fn(|k| numbers[k + 1])))
        .unwrap()
}

/// Table 3 of the paper: mean and standard deviation of the solar angle, then of the eccentricity.
pub fn paper_table_3(method: &str, time: f64) -> [f64; 4] {
    rows(include_str!("../reference/paper-table-3.csv"))
        .find(|(fields, numbers)| fields[0] == method && numbers[0] == time)
        .map(|(_, numbers)| std::array::from_fn(|k| numbers[k + 1]))
        .unwrap()
}

/// Errors relative to the exact moments: mean and standard deviation of the solar angle, then of the eccentricity.
pub fn relative_errors(found: &Moments, exact: &Moments) -> [f64; 4] {
    let (found, exact) = (found.to_array(), exact.to_array());
    std::array::from_fn(|k| (found[k] / exact[k] - 1.0).abs())
}

/// Exact mean density of each bin: `fineness` midpoints along `phi` and `e` in every bin are followed back to the
/// initial Gaussian. The total mass shows whether they were enough, because filaments can be as thin as a twentieth of
/// a bin in `e`.
pub fn exact_joint(problem: &Problem, time: f64, grid: &Grid, fineness: [usize; 2]) -> Vec<f64> {
    let flow = Flow::new(problem.model);
    let in_cloud = bins_of_cloud(problem, time, grid);
    let mut joint = vec![0.0; grid.len()];
    for i in 0..grid.phi.bins {
        let fine = |low: f64, width: f64, k: usize, of: usize| low + width * (k as f64 + 0.5) / of as f64;
        let per_bin = fineness[0] * fineness[1];
        let row = &in_cloud[i * grid.e.bins..(i + 1) * grid.e.bins];
        let bins: Vec<usize> = (0..grid.e.bins).filter(|&j| row[j]).collect();
        let points: Vec<State> = bins
            .iter()
            .flat_map(|&j| (0..per_bin).map(move |k| (j, k)))
            .map(|(j, k)| {
                let phi = fine(grid.phi.edge(i), grid.phi.width(), k / fineness[1], fineness[0]);
                State::from_polar(phi, fine(grid.e.edge(j), grid.e.width(), k % fineness[1], fineness[1]))
            })
            .collect();
        let mut x1: Vec<f64> = points.iter().map(|state| state.x1).collect();
        let mut x2: Vec<f64> = points.iter().map(|state| state.x2).collect();
        flow.advance(&mut x1, &mut x2, -time).unwrap();
        let densities: Vec<f64> = points
            .iter()
            .zip(x1.iter().zip(&x2))
            .map(|(&end, (&x1, &x2))| {
                let start = State { x1, x2 };
                let phi = density::angle::nearest(start.solar_angle(), problem.initial.mean_phi);
                let n0 = problem.initial.density(phi, start.eccentricity());
                if n0 > 0.0 { n0 * density_growth(start, end) } else { 0.0 }
            })
            .collect();
        for (j, bin) in bins.iter().zip(densities.chunks(per_bin)) {
            joint[i * grid.e.bins + j] = bin.iter().sum::<f64>() / per_bin as f64;
        }
    }
    joint
}

/// The bins that 300 x 300 orbits from within 5 standard deviations reach, and the neighbours of these bins.
fn bins_of_cloud(problem: &Problem, time: f64, grid: &Grid) -> Vec<bool> {
    const SIDE: usize = 300;
    let sigmas = |k: usize| 10.0 * k as f64 / (SIDE - 1) as f64 - 5.0;
    let start = (0..SIDE * SIDE).map(|k| problem.initial.point(sigmas(k / SIDE), sigmas(k % SIDE)));
    let states = start.map(|(phi, e)| State::from_polar(phi, e.max(1e-9)));
    let (mut x1, mut x2): (Vec<f64>, Vec<f64>) = states.map(|state| (state.x1, state.x2)).unzip();
    Flow::new(problem.model).advance(&mut x1, &mut x2, time).unwrap();
    let mut found = vec![false; grid.len()];
    for (&x1, &x2) in x1.iter().zip(&x2) {
        let state = State { x1, x2 };
        let Some(bin) = grid.bin(state.solar_angle(), state.eccentricity()) else { continue };
        let (i, j) = (bin / grid.e.bins, bin % grid.e.bins);
        for i in i.saturating_sub(1)..=(i + 1).min(grid.phi.bins - 1) {
            for j in j.saturating_sub(1)..=(j + 1).min(grid.e.bins - 1) {
                found[i * grid.e.bins + j] = true;
            }
        }
    }
    found
}

/// L1 distance of two densities on the grid: `∫ |f - g|`, between 0 and 2.
pub fn l1(estimate: &Estimate, exact: &[f64]) -> f64 {
    estimate.joint.iter().zip(exact).map(|(f, g)| (f - g).abs()).sum::<f64>() * estimate.grid.bin_area()
}

//! The exact joint density for the tests, as bin averages: the initial probability carried forward.
//!
//! A lattice of orbits over `±6 sigma` is propagated through all snapshots; between its nodes the flow map is
//! interpolated by Lagrange polynomials of third order along both directions. Each cell's probability is spread over
//! 100 points of a Kronecker sequence and dropped into the bins. The error of the sum of absolute differences is about
//! 2e-3 on 100 x 100 bins.

use rayon::prelude::*;

use crate::flow::Flow;
use crate::grid::Grid;
use crate::model::plane::State;
use crate::problem::Problem;

const CELLS: usize = 320;
const EDGE: f64 = 6.0;
const POINTS: usize = 100;
const SPACING: f64 = 2.0 * EDGE / CELLS as f64;

/// Nodes along an axis: the interpolation needs one more on either side than the cells have.
const NODES: usize = CELLS + 3;

/// Probability in each bin of each grid.
pub(super) fn exact_masses(problem: &Problem, grids: &[Grid]) -> Vec<Vec<f64>> {
    let flow = Flow::new(problem.model);
    let coordinate = |i: usize| (i as f64 - 1.0) * SPACING - EDGE;
    let start = |k: usize| {
        let (phi, e) = problem.initial.point(coordinate(k / NODES), coordinate(k % NODES));
        State::from_polar(phi, e)
    };
    let (mut x1, mut x2): (Vec<f64>, Vec<f64>) = (0..NODES * NODES).map(|k| (start(k).x1, start(k).x2)).unzip();
    let mut now = 0.0;
    let mut snapshots = Vec::new();
    for (&time, grid) in problem.times.iter().zip(grids) {
        flow.advance(&mut x1, &mut x2, time - now).unwrap();
        now = time;
        let rows: Vec<Vec<f64>> =
            (0..16).into_par_iter().map(|part| row_masses(problem, grid, &x1, &x2, part)).collect();
        snapshots.push((0..grid.len()).map(|bin| rows.iter().map(|row| row[bin]).sum()).collect());
    }
    snapshots
}

/// The probability that a sixteenth of the cells puts into the bins.
fn row_masses(problem: &Problem, grid: &Grid, x1: &[f64], x2: &[f64], part: usize) -> Vec<f64> {
    let mut masses = vec![0.0; grid.len()];
    let share = SPACING * SPACING / (POINTS as f64 * std::f64::consts::TAU);
    for cell in (part * CELLS * CELLS / 16)..((part + 1) * CELLS * CELLS / 16) {
        let (i, j) = (cell / CELLS, cell % CELLS);
        for k in 0..POINTS {
            // The two-dimensional golden ratio (Roberts 2018); the sequence continues from cell to cell.
            let step = (cell * POINTS + k) as f64;
            let (s, t) = ((step * 0.754_877_666_246_692_8).fract(), (step * 0.569_840_290_998_053_3).fract());
            let (u, v) = ((i as f64 + s) * SPACING - EDGE, (j as f64 + t) * SPACING - EDGE);
            let (_, e) = problem.initial.point(u, v);
            if e <= 0.0 {
                continue;
            }
            let (across, along) = (lagrange(s), lagrange(t));
            let mut state = State { x1: 0.0, x2: 0.0 };
            for (a, across) in across.iter().enumerate() {
                for (b, along) in along.iter().enumerate() {
                    let node = (i + a) * NODES + j + b;
                    state.x1 += across * along * x1[node];
                    state.x2 += across * along * x2[node];
                }
            }
            if let Some(bin) = grid.bin(state.solar_angle(), state.eccentricity()) {
                masses[bin] += share * (-0.5 * (u * u + v * v)).exp();
            }
        }
    }
    masses
}

/// Weights of the nodes -1, 0, 1, 2 at `t` in `[0, 1]`.
fn lagrange(t: f64) -> [f64; 4] {
    [
        -t * (t - 1.0) * (t - 2.0) / 6.0,
        (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
        -(t + 1.0) * t * (t - 2.0) / 2.0,
        (t + 1.0) * t * (t - 1.0) / 6.0,
    ]
}

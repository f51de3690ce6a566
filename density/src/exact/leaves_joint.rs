//! The joint density where the radiation parameter is uncertain, from its values at points.
//!
//! At a point the density is `∫ n_z(phi, e) w(z) dz`, and each leaf's density `n_z` follows from the orbit that ends there, carried back to
//! the start. As a function of `z` it is a bump as the leaf's cloud passes over the point, so the trapezoidal rule converges
//! faster than any power of its step (Trefethen & Weideman, SIAM Review 56, 2014); the step is halved until the sum stands.
//! The average over a bin is that of Simpson's rule. An uncertain parameter widens the cloud, so that a few points in a bin
//! resolve it; where they do not, more are taken.

use rayon::prelude::*;

use crate::flow::{Accuracy, Flow};
use crate::grid::{Axis, Grid};
use crate::model::PlanarHamiltonian;
use crate::model::plane::State;
use crate::uncertain::UncertainProblem;

use super::hamiltonian_range::cloud_range;
use super::joint::Joint;
use super::measure::{Measure, normal_density};

/// Standard deviations of `z` beyond which the Gaussian counts as zero.
const REACH: f64 = 6.5;
/// Steps of `z` at first, and at most.
const FIRST_STEPS: u32 = 26;
const MOST_STEPS: u32 = 26 << 5;
/// Intervals for Simpson's rule in a bin at first, and at most.
const MOST_PARTS: usize = 8;
/// Largest number of orbits for one choice of points.
const MOST_ORBITS: usize = 60_000_000;

/// The joint density after `years` on `grid`, to an L1 error of about `tolerance` if the permitted number of orbits is enough for that.
pub(super) fn joint(problem: &UncertainProblem, grid: &Grid, years: f64, tolerance: f64) -> Joint {
    let mut parts = 2;
    loop {
        let points = Points::new(grid, parts);
        let density = points.density(problem, years, 0.3 * tolerance);
        let found = points.averages(&density);
        let joint = found.joint(grid);
        let dearer = 4 * density.orbits;
        if joint.error <= tolerance || 2 * parts > MOST_PARTS || dearer > MOST_ORBITS {
            return joint;
        }
        parts *= 2;
    }
}

/// A lattice of points: a number of intervals to every bin and both ends of each.
struct Points<'a> {
    grid: &'a Grid,
    parts: usize,
    rows: usize,
    columns: usize,
}

/// The density at all points.
struct Values {
    density: Vec<f64>,
    /// Sum over the points of the difference that the last halving of the step of `z` made.
    difference: f64,
    orbits: usize,
}

/// Averages over the bins.
struct Averages {
    density: Vec<f64>,
    /// L1 difference from the averages by Simpson's rule with the double step.
    difference: f64,
    /// What the sum over `z` is good to, in L1.
    by_sum: f64,
}

impl<'a> Points<'a> {
    fn new(grid: &'a Grid, parts: usize) -> Self {
        Self { grid, parts, rows: parts * grid.phi.bins + 1, columns: parts * grid.e.bins + 1 }
    }

    fn at(&self, index: usize) -> (f64, f64) {
        let on = |axis: Axis, k: usize| axis.low + axis.width() * (k as f64 / self.parts as f64);
        (on(self.grid.phi, index / self.columns), on(self.grid.e, index % self.columns))
    }

    /// The density at the points, summed over `z` until a halving of the step changes it by less than `tolerance` in L1.
    fn density(&self, problem: &UncertainProblem, years: f64, tolerance: f64) -> Values {
        let lowest = problem.lowest().max(-REACH);
        let (mut steps, mut orbits) = (FIRST_STEPS, 0);
        let step = |steps: u32| (REACH - lowest) / f64::from(steps);
        let z = |k: u32, steps: u32| lowest + step(steps) * f64::from(k);
        let count = self.rows * self.columns;
        let mut sum = vec![0.0; count];
        let mut add = |sum: &mut Vec<f64>, k: u32, steps: u32, weight: f64| {
            orbits += self.add_leaf(problem, z(k, steps), years, weight, sum);
            orbits
        };
        (0..=steps).for_each(|k| {
            add(&mut sum, k, steps, if k == 0 || k == steps { 0.5 } else { 1.0 });
        });
        loop {
            let before: Vec<f64> = sum.iter().map(|value| value * step(steps)).collect();
            steps *= 2;
            let mut taken = 0;
            (0..steps).filter(|k| k % 2 == 1).for_each(|k| taken = add(&mut sum, k, steps, 1.0));
            let density: Vec<f64> = sum.iter().map(|value| value * step(steps)).collect();
            // A point stands for a share of a bin.
            let apart: f64 = density.iter().zip(&before).map(|(a, b)| (a - b).abs()).sum();
            let difference = apart * self.grid.bin_area() / (self.parts * self.parts) as f64;
            if difference <= tolerance || steps >= MOST_STEPS || taken > MOST_ORBITS {
                return Values { density, difference, orbits: taken };
            }
        }
    }

    /// Adds the density of the leaf at `z`, times the density of `z` and a weight; says how many orbits that took.
    fn add_leaf(&self, problem: &UncertainProblem, z: f64, years: f64, weight: f64, sum: &mut [f64]) -> usize {
        const MARGIN: f64 = 1e-9;
        let Some(leaf) = problem.leaf(z) else { return 0 };
        let measure = Measure::new(leaf.initial);
        let flow = Flow { model: leaf.model, accuracy: Accuracy::Medium };
        let range = cloud_range(&leaf.model, &measure);
        let may_hold = |&index: &usize| {
            let (phi, e) = self.at(index);
            let inside = e > 0.0 && e < 1.0;
            let hamiltonian = if inside { leaf.model.hamiltonian(State::from_polar(phi, e)) } else { f64::NAN };
            hamiltonian >= range.low - MARGIN && hamiltonian <= range.high + MARGIN
        };
        let reached: Vec<usize> = (0..sum.len()).into_par_iter().filter(may_hold).collect();
        let end = |&index: &usize| {
            let (phi, e) = self.at(index);
            State::from_polar(phi, e)
        };
        let ends: Vec<State> = reached.iter().map(end).collect();
        let (mut x1, mut x2): (Vec<f64>, Vec<f64>) = ends.iter().map(|state| (state.x1, state.x2)).unzip();
        flow.advance_where_possible(&mut x1, &mut x2, -years);
        let scale = weight * normal_density(z) / problem.mass_inside();
        for ((&index, end), (&x1, &x2)) in reached.iter().zip(ends).zip(x1.iter().zip(&x2)) {
            sum[index] += scale * measure.density_after(State { x1, x2 }, end);
        }
        reached.len()
    }

    fn averages(&self, values: &Values) -> Averages {
        let (parts, bins) = (self.parts, self.grid.e.bins);
        let value = |row: usize, column: usize| values.density[row * self.columns + column];
        // Simpson's rule on a square of `count` times `count` intervals of `stride` points each.
        let simpson = |(row, column): (usize, usize), count: usize, stride: usize| -> f64 {
            let weight = |k: usize| match k {
                0 => 1.0,
                k if k == count => 1.0,
                k if k % 2 == 1 => 4.0,
                _ => 2.0,
            };
            let each = (0..=count).flat_map(|i| (0..=count).map(move |j| (i, j)));
            let sum: f64 =
                each.map(|(i, j)| weight(i) * weight(j) * value(row + i * stride, column + j * stride)).sum();
            sum / (9 * count * count) as f64
        };
        let density: Vec<f64> =
            (0..self.grid.len()).map(|bin| simpson((bin / bins * parts, bin % bins * parts), parts, 1)).collect();
        // Four bins together, once with half as many intervals.
        let pairs = |count: usize| (0..count / 2).map(|k| 2 * k);
        let blocks = pairs(self.grid.phi.bins).flat_map(|i| pairs(bins).map(move |j| (i, j)));
        let apart = |(i, j): (usize, usize)| {
            let four = [(i, j), (i, j + 1), (i + 1, j), (i + 1, j + 1)];
            let fine: f64 = four.iter().map(|(i, j)| density[i * bins + j]).sum::<f64>() / 4.0;
            4.0 * (fine - simpson((i * parts, j * parts), parts, 2)).abs()
        };
        let (sum, count) = blocks.fold((0.0, 0), |(sum, count), block| (sum + apart(block), count + 4));
        // A last odd row or column is as good as the others.
        let all = self.grid.len() as f64 / f64::from(count.max(1));
        Averages { difference: all * sum * self.grid.bin_area(), by_sum: values.difference, density }
    }
}

impl Averages {
    fn joint(self, grid: &Grid) -> Joint {
        let mass: f64 = self.density.iter().sum::<f64>() * grid.bin_area();
        let error = self.difference + self.by_sum;
        Joint { density: self.density, error, mass_outside: (1.0 - mass).max(0.0), orbits: 0 }
    }
}

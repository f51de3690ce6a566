//! Moments from the orbits of a lattice, with `phi` on the branch of the circular mean.
//!
//! Where the branch's cut runs between two neighbouring nodes of a line, both nodes stand for cells that end half-way;
//! the strip between that end and the cut is moved to the other branch. Two errors are left. If the line bends, the cut
//! is not quite where a straight line between the nodes has it; and if the cut runs along the lines, these are few to
//! sum over. The probability of both is the uncertainty of the branch.

use std::f64::consts::{PI, TAU};

use density::angle::nearest;
use rayon::prelude::*;

use super::lattice::Lattice;
use super::paths::Paths;

/// Mean and standard deviation of `phi`, mean and standard deviation of `e`, covariance; and the mean vector of `phi`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cloud {
    /// `mean_phi, std_phi, mean_e, std_e, cov_phi_e`.
    pub moments: [f64; 5],
    /// Mean of `sin(phi)` and `cos(phi)`.
    pub vector: [f64; 2],
    /// Probability of orbits that could not be followed.
    pub lost: f64,
    /// Probability of orbits next to the cut that may be on the wrong branch.
    pub at_cut: f64,
}

impl Cloud {
    /// From raw moments `[(phi-c), (phi-c)², (e-r), (e-r)², (phi-c)(e-r)]` about a circular mean `c` and an
    /// eccentricity `r`.
    pub fn from_raw([a, aa, b, bb, ab]: [f64; 5], c: f64, r: f64, vector: [f64; 2], lost: f64) -> Self {
        let deviation = |square: f64, mean: f64| (square - mean * mean).max(0.0).sqrt();
        Self { moments: [c + a, deviation(aa, a), r + b, deviation(bb, b), ab - a * b], vector, lost, at_cut: 0.0 }
    }

    /// The circular mean \[rad\].
    pub fn circular_mean(&self) -> f64 {
        self.vector[0].atan2(self.vector[1])
    }

    /// The unit for the error of each moment: standard deviations, or their product.
    pub fn scales(&self) -> [f64; 5] {
        let [_, p, _, q, _] = self.moments;
        [p, p, q, q, p * q]
    }
}

/// The moments at time `k`.
pub fn cloud(lattice: &Lattice, paths: &Paths, k: usize) -> Cloud {
    let nodes = lattice.e.len();
    let state = |line: usize, j: usize| (paths.x1[k][line * nodes + j], paths.x2[k][line * nodes + j]);
    let [sin, cos, e, lost] = over_lines(lattice, |line| {
        let mut sums = [0.0; 4];
        for j in 0..nodes {
            let (x1, x2) = state(line, j);
            let (w, e) = (lattice.node_weight[j], x1.hypot(x2));
            let terms = if e.is_nan() { [0.0, 0.0, 0.0, w] } else { [w * x1 / e, w * x2 / e, w * e, 0.0] };
            (0..4).for_each(|i| sums[i] += terms[i]);
        }
        sums
    });
    let kept = 1.0 - lost;
    let vector = [sin / kept, cos / kept];
    let (c, r) = (sin.atan2(cos), e / kept);
    let sums = over_lines(lattice, |line| {
        let mut sums = [0.0; 6];
        let mut before: Option<(f64, f64)> = None;
        for j in 0..nodes {
            let (x1, x2) = state(line, j);
            let point = (nearest(x1.atan2(x2), c) - c, x1.hypot(x2) - r);
            if point.0.is_nan() || point.1.is_nan() {
                before = None;
                continue;
            }
            add(&mut sums, terms(point), lattice.node_weight[j]);
            if let Some(before) = before.filter(|before| (before.0 - point.0).abs() > PI) {
                move_strip(&mut sums, lattice, j, before, point);
                let further = |j: usize| (j < nodes).then(|| state(line, j)).map(|(x1, x2)| x1.atan2(x2) - c);
                let neighbours = [j.checked_sub(2).and_then(further), further(j + 1)];
                sums[5] += lattice.node_weight[j] * bend(before.0, point.0, neighbours);
            }
            before = Some(point);
        }
        sums
    });
    let [raw @ .., at_cut] = sums.map(|sum| sum / kept);
    let at_cut = at_cut + lattice.doubt_of_steps(&turns(lattice, &state, c));
    Cloud { at_cut, ..Cloud::from_raw(raw, c, r, vector, lost) }
}

/// Number of turns by which the branch of each line is ahead of the first line's, averaged over its nodes. On a lattice
/// round the whole circle the first line comes once more at the end: the cut may run between it and the last.
fn turns(lattice: &Lattice, state: &(impl Fn(usize, usize) -> (f64, f64) + Sync), c: f64) -> Vec<f64> {
    let phi = |line: usize, j: usize| {
        let (x1, x2) = state(line, j);
        nearest(x1.atan2(x2), c)
    };
    let lines = lattice.phi.len();
    let step = |line: usize| -> f64 {
        let turn = |j: usize| ((phi(line % lines, j) - phi(line - 1, j)) / TAU).round();
        (0..lattice.e.len())
            .map(|j| (lattice.node_weight[j], turn(j)))
            .filter(|(_, t)| !t.is_nan())
            .map(|(w, t)| w * t)
            .sum()
    };
    let seam = usize::from(lattice.periodic);
    let steps = (0..lines + seam).map(|line| if line == 0 { 0.0 } else { step(line) });
    steps
        .scan(0.0, |sum, step| {
            *sum += step;
            Some(*sum)
        })
        .collect()
}

/// The part of the distance between two nodes by which the cut between them may be off, at most half: an eighth of the
/// second difference of `phi` over the first, the error of linear interpolation.
fn bend(before: f64, after: f64, neighbours: [Option<f64>; 2]) -> f64 {
    let step = nearest(after - before, 0.0);
    let seconds = [neighbours[0].map(|phi| step - (before - phi)), neighbours[1].map(|phi| phi - after - step)];
    let second = seconds.into_iter().flatten().map(|second| nearest(second, 0.0).abs()).fold(0.0, f64::max);
    (second / (8.0 * step.abs())).min(0.5)
}

fn terms((a, b): (f64, f64)) -> [f64; 5] {
    [a, a * a, b, b * b, a * b]
}

fn add(sums: &mut [f64; 6], terms: [f64; 5], weight: f64) {
    (0..5).for_each(|i| sums[i] += weight * terms[i]);
}

/// Moves the strip between the border below node `j` and the cut; the cut lies between the nodes `j - 1` and `j`.
fn move_strip(sums: &mut [f64; 6], lattice: &Lattice, j: usize, before: (f64, f64), after: (f64, f64)) {
    let turn = if before.0 > 0.0 { TAU } else { -TAU };
    let lifted = after.0 + turn;
    let cut = (0.5 * turn - before.0) / (lifted - before.0);
    let middle = 0.5 * (cut + 0.5);
    let a = before.0 + middle * (lifted - before.0);
    let b = before.1 + middle * (after.1 - before.1);
    let h = 1.0 / lattice.e.len() as f64;
    let weight = lattice.density_in_x((j as f64 - 0.5 + middle) * h) * h * (0.5 - cut);
    // Before the border, everything is on the branch of the first node; from the cut on it should be on the branch of
    // the second.
    let (first, second) = (terms((a, b)), terms((a - turn, b)));
    (0..5).for_each(|i| sums[i] += weight * (second[i] - first[i]));
}

/// The sum over all lines, in their order.
fn over_lines<const N: usize>(lattice: &Lattice, line: impl Fn(usize) -> [f64; N] + Sync + Send) -> [f64; N] {
    let lines: Vec<[f64; N]> = (0..lattice.phi.len()).into_par_iter().map(line).collect();
    let mut sums = [0.0; N];
    for (values, weight) in lines.iter().zip(&lattice.line_weight) {
        (0..N).for_each(|i| sums[i] += weight * values[i]);
    }
    sums
}

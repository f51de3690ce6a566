//! The joint density on a grid, from lines of orbits.
//!
//! Lines are interpolated between those of the lattice and cut into short pieces; each piece leaves its probability in
//! the bins that it crosses.

use density::angle::nearest;
use density::grid::Grid;
use rayon::prelude::*;

use super::lattice::Lattice;
use super::paths::Paths;

/// Number of points of an interpolation.
const STENCIL: usize = 6;
/// Largest number of pieces between two nodes.
const MOST_PIECES: usize = 64;
/// Number of lines that a thread takes at a time.
const CHUNK: usize = 64;

/// Mean density in each bin at time `k` \[1/rad\], from at least `least_lines` lines; and half of the L1 distance
/// between the densities of the even and of the odd lines, which shows whether the lines are too few for the bins.
pub fn joint(lattice: &Lattice, paths: &Paths, k: usize, grid: &Grid, least_lines: usize) -> (Vec<f64>, f64) {
    let (lines, nodes) = (lattice.phi.len(), lattice.e.len());
    let parts = least_lines.div_ceil(lines);
    let along = Pieces::new(lattice);
    let intervals = if lattice.periodic { lines } else { lines - 1 };
    let count = intervals * parts;
    let position = |n: usize| (n / parts, ((n % parts) as f64 + 0.5) / parts as f64);
    let phi = |n: usize| lattice.phi[position(n).0] + position(n).1 * lattice.spacing();
    let total: f64 = (0..count).map(|n| lattice.line_density(phi(n))).sum();
    let chunks: Vec<[Vec<f64>; 2]> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut halves = [vec![0.0; grid.len()], vec![0.0; grid.len()]];
            for n in chunk * CHUNK..count.min((chunk + 1) * CHUNK) {
                let weight = lattice.line_density(phi(n)) / total;
                if weight * count as f64 > 1e-13 {
                    let (line, fraction) = position(n);
                    let across = Across::new(lattice, line, fraction);
                    let x1: Vec<f64> = (0..nodes).map(|j| across.at(&paths.x1[k], nodes, j)).collect();
                    let x2: Vec<f64> = (0..nodes).map(|j| across.at(&paths.x2[k], nodes, j)).collect();
                    along.deposit(&x1, &x2, weight / grid.bin_area(), grid, &mut halves[n % 2]);
                }
            }
            halves
        })
        .collect();
    let mut halves = [vec![0.0; grid.len()], vec![0.0; grid.len()]];
    for chunk in chunks {
        for (half, part) in halves.iter_mut().zip(chunk) {
            half.iter_mut().zip(part).for_each(|(sum, value)| *sum += value);
        }
    }
    let [even, odd] = halves;
    let coarseness = even.iter().zip(&odd).map(|(a, b)| (a - b).abs()).sum::<f64>() * grid.bin_area();
    (even.into_iter().zip(odd).map(|(a, b)| a + b).collect(), coarseness)
}

/// Weights of the points `0..STENCIL` in the value at `x` of the polynomial through them.
fn lagrange(x: f64) -> [f64; STENCIL] {
    std::array::from_fn(|i| {
        let others = (0..STENCIL).filter(|&j| j != i);
        others.map(|j| (x - j as f64) / (i as f64 - j as f64)).product()
    })
}

/// Interpolation between lines.
struct Across {
    lines: [usize; STENCIL],
    weights: [f64; STENCIL],
}

impl Across {
    /// Interpolation between `line` and the next line.
    fn new(lattice: &Lattice, line: usize, fraction: f64) -> Self {
        let (count, before) = (lattice.phi.len(), STENCIL / 2 - 1);
        if lattice.periodic {
            let lines = std::array::from_fn(|i| (line + count + i - before) % count);
            return Self { lines, weights: lagrange(before as f64 + fraction) };
        }
        let first = line.saturating_sub(before).min(count - STENCIL);
        Self { lines: std::array::from_fn(|i| first + i), weights: lagrange((line - first) as f64 + fraction) }
    }

    fn at(&self, values: &[f64], nodes: usize, j: usize) -> f64 {
        (0..STENCIL).map(|i| self.weights[i] * values[self.lines[i] * nodes + j]).sum()
    }
}

/// Interpolation and probabilities along a line.
struct Pieces {
    /// First point of the stencil of each interval between nodes, and its weights at each of the finest fractions.
    stencils: Vec<(usize, usize)>,
    weights: Vec<Vec<[f64; STENCIL]>>,
    /// Probability below each of the finest fractions, in each interval.
    below: Vec<Vec<f64>>,
}

impl Pieces {
    fn new(lattice: &Lattice) -> Self {
        let nodes = lattice.e.len();
        let first = |j: usize| j.saturating_sub(STENCIL / 2 - 1).min(nodes - STENCIL);
        let fraction = |r: usize| r as f64 / MOST_PIECES as f64;
        let weights =
            |shift: usize| (0..=MOST_PIECES).map(|r| lagrange(shift as f64 + fraction(r))).collect::<Vec<_>>();
        let start = lattice.border(0);
        let e = |j: usize, r: usize| lattice.e_at((j as f64 + 0.5 + fraction(r)) / nodes as f64);
        let below = |j: usize| (0..=MOST_PIECES).map(|r| lattice.probability(start, e(j, r))).collect();
        Self {
            stencils: (0..nodes - 1).map(|j| (first(j), j - first(j))).collect(),
            weights: (0..STENCIL).map(weights).collect(),
            below: (0..nodes - 1).map(below).collect(),
        }
    }

    fn deposit(&self, x1: &[f64], x2: &[f64], scale: f64, grid: &Grid, joint: &mut [f64]) {
        let point = |x1: f64, x2: f64| (x1.atan2(x2), x1.hypot(x2));
        let ends: Vec<(f64, f64)> = x1.iter().zip(x2).map(|(&x1, &x2)| point(x1, x2)).collect();
        for (j, &(first, shift)) in self.stencils.iter().enumerate() {
            let (from, to) = (ends[j], ends[j + 1]);
            let length = nearest(to.0 - from.0, 0.0).abs() / grid.phi.width() + (to.1 - from.1).abs() / grid.e.width();
            if length.is_nan() {
                continue;
            }
            let pieces = ((2.0 * length).ceil() as usize).next_power_of_two().clamp(1, MOST_PIECES);
            let stride = MOST_PIECES / pieces;
            let mut before = from;
            for piece in 1..=pieces {
                let r = piece * stride;
                let value = |x: &[f64]| (0..STENCIL).map(|i| self.weights[shift][r][i] * x[first + i]).sum::<f64>();
                let after = if piece == pieces { to } else { point(value(x1), value(x2)) };
                let mass = self.below[j][r] - self.below[j][r - stride];
                if mass > 0.0 {
                    deposit_piece(before, after, scale * mass, grid, joint);
                }
                before = after;
            }
        }
    }
}

/// Divides the mass of a straight piece, which crosses at most one border of bins along each axis, among its bins.
fn deposit_piece(from: (f64, f64), to: (f64, f64), mass: f64, grid: &Grid, joint: &mut [f64]) {
    let turn = nearest(to.0 - from.0, 0.0);
    let start = grid.fold(from.0);
    let phi = [start, start + turn].map(|phi| (phi - grid.phi.low) / grid.phi.width());
    let e = [from.1, to.1].map(|e| (e - grid.e.low) / grid.e.width());
    let crossing = |[a, b]: [f64; 2]| {
        let border = a.max(b).floor();
        if border > a.min(b) { (border - a) / (b - a) } else { 1.0 }
    };
    let (one, other) = (crossing(phi), crossing(e));
    let cuts = [0.0, one.min(other), one.max(other), 1.0];
    for part in cuts.windows(2) {
        let share = part[1] - part[0];
        if share <= 0.0 {
            continue;
        }
        let middle = 0.5 * (part[0] + part[1]);
        if let Some(bin) = grid.bin(start + middle * turn, from.1 + middle * (to.1 - from.1)) {
            joint[bin] += mass * share;
        }
    }
}

//! Probabilities of an eccentricity above the critical one.
//!
//! On each line, the places where an orbit just reaches the critical eccentricity are found by following further
//! orbits. The Gaussian's distribution function gives the probability between these places.

use rayon::prelude::*;

use super::lattice::Lattice;
use super::paths::{Motion, Paths, follow};

/// Number of further orbits that are followed to narrow down a place.
const REFINEMENTS: usize = 3;

/// Which eccentricity of an orbit is compared with the critical one, as a square.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reading {
    /// The one at the given time.
    Now,
    /// The largest one until the given time.
    Ever,
}

impl Reading {
    fn of(self, paths: &Paths, k: usize, orbit: usize) -> f64 {
        match self {
            Self::Now => paths.x1[k][orbit].powi(2) + paths.x2[k][orbit].powi(2),
            Self::Ever => paths.peak[k][orbit],
        }
    }
}

/// A pair of neighbouring nodes between which a line crosses the critical eccentricity.
struct Bracket {
    line: usize,
    node: usize,
    /// For each end: eccentricity at the start, and excess of the square over the critical square.
    ends: [(f64, f64); 2],
    side: u8,
}

/// Probability that the eccentricity, read at time `k`, is above `critical_e`, and the error if the lines are too few.
pub fn probability(
    motion: Motion,
    lattice: &Lattice,
    paths: &Paths,
    (times, k): (&[f64], usize),
    critical_e: f64,
    reading: Reading,
) -> (f64, f64) {
    let nodes = lattice.e.len();
    let excess = |line: usize, node: usize| reading.of(paths, k, line * nodes + node) - critical_e * critical_e;
    let cells: Vec<f64> = (0..nodes).map(|j| lattice.probability(lattice.border(j), lattice.border(j + 1))).collect();
    let by_nodes = |line: usize| (0..nodes).filter(|&j| excess(line, j) > 0.0).map(|j| cells[j]).sum::<f64>();
    let shares: Vec<f64> = (0..lattice.phi.len()).map(by_nodes).collect();
    let mut sum: f64 = shares.iter().zip(&lattice.line_weight).map(|(share, weight)| weight * share).sum();
    let changes = |line: usize, j: usize| {
        let (a, b) = (excess(line, j), excess(line, j + 1));
        !a.is_nan() && !b.is_nan() && (a > 0.0) != (b > 0.0)
    };
    let bracket = |line: usize, j: usize| Bracket {
        line,
        node: j,
        ends: [(lattice.e[j], excess(line, j)), (lattice.e[j + 1], excess(line, j + 1))],
        side: 0,
    };
    let places = (0..lattice.phi.len()).flat_map(|line| (0..nodes - 1).map(move |j| (line, j)));
    let mut brackets: Vec<Bracket> =
        places.filter(|&(line, j)| changes(line, j)).map(|(line, j)| bracket(line, j)).collect();
    let refinements = if times[k] > 0.0 { REFINEMENTS } else { 12 };
    for _ in 0..refinements {
        let starts: Vec<[f64; 2]> = brackets.iter().map(|b| [lattice.phi[b.line], b.guess()]).collect();
        let refined = follow(motion, &starts, &times[..=k]);
        brackets.par_iter_mut().enumerate().for_each(|(i, bracket)| {
            bracket.narrow(starts[i][1], reading.of(&refined, k, i) - critical_e * critical_e);
        });
    }
    for bracket in &brackets {
        // The nodes stand for their cells, so the part between the border and the place is on the wrong side.
        let (border, place) = (lattice.border(bracket.node + 1), bracket.guess());
        let rises = bracket.ends[1].1 > 0.0;
        let from_place_to_border = lattice.probability(place.min(border), place.max(border));
        let above = if (place < border) == rises { from_place_to_border } else { -from_place_to_border };
        sum += lattice.line_weight[bracket.line] * above;
    }
    (sum, lattice.doubt_of_steps(&shares))
}

impl Bracket {
    /// The place where a straight line through both ends crosses zero.
    fn guess(&self) -> f64 {
        let [(a, fa), (b, fb)] = self.ends;
        if fa == fb { 0.5 * (a + b) } else { ((a * fb - b * fa) / (fb - fa)).clamp(a.min(b), a.max(b)) }
    }

    /// False position with the Illinois correction.
    fn narrow(&mut self, e: f64, excess: f64) {
        if excess.is_nan() {
            return;
        }
        let [a, b] = &mut self.ends;
        if (excess > 0.0) == (a.1 > 0.0) {
            *a = (e, excess);
            if self.side == 1 {
                b.1 *= 0.5;
            }
            self.side = 1;
        } else {
            *b = (e, excess);
            if self.side == 2 {
                a.1 *= 0.5;
            }
            self.side = 2;
        }
    }
}

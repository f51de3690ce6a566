//! The joint density by blocks of bins: cheap where the cloud is not yet wound up.
//!
//! The grid is cut into blocks of bins; on each block the backward flow becomes a polynomial ([`super::block`]). Blocks
//! whose last coefficients are not yet small against the cloud are halved, down to parts of a bin. A bin's probability
//! is a circulation along its edges ([`super::measure`]), so a cloud thinner than a bin is no harder than a broad one.
//! The probabilities of the bins add up to the probability of the grid by construction, except for the difference
//! between neighbouring polynomials.
//!
//! The polynomial of a block that is not resolved means nothing, so there is no answer at all if such a block is left
//! when the permitted number of orbits is used up.

use rayon::prelude::*;

use crate::flow::Flow;
use crate::grid::Grid;
use crate::model::plane::{PlanarHamiltonian, State};

use super::block::{BackwardMap, BinMass, Block, N, Range};
use super::chebyshev_curve::chebyshev_transform;
use super::hamiltonian_range::{HamiltonianRange, cloud_range, distance_from_cloud, hamiltonian_range};
use super::joint::Joint;
use super::measure::Measure;

/// Share of the tolerated L1 error that the polynomials may cause, as a shift of the cloud in units of its smallest
/// scale.
const SHARE: f64 = 0.01;
/// Number of bins in each direction of a block at the start.
const FIRST: usize = 25;

/// The joint density after `years` on `grid`, to an L1 error of about `tolerance`; `None` if that takes more than
/// `most_orbits`.
pub(super) fn joint<M: PlanarHamiltonian>(
    flow: &Flow<M>,
    measure: &Measure,
    grid: &Grid,
    years: f64,
    tolerance: f64,
    most_orbits: usize,
) -> Option<Joint> {
    let small = SHARE * tolerance * measure.scale();
    let cloud = cloud_range(&flow.model, measure);
    let transform = chebyshev_transform::<N>();
    let (mut mass, mut error, mut orbits) = (vec![0.0; grid.len()], 0.0, 0);
    let mut pending = first_blocks(grid);
    while !pending.is_empty() {
        pending.retain(|block| may_hold(block, flow, cloud));
        orbits += pending.len() * N * N;
        if orbits > most_orbits {
            return None;
        }
        let (x1, x2) = backward(flow, &pending, years);
        let outcomes: Vec<Outcome> = (pending.par_iter().zip(x1.par_chunks(N * N)).zip(x2.par_chunks(N * N)))
            .map(|((block, x1), x2)| {
                let map = BackwardMap::new(x1, x2, &transform);
                let tails = map.tails();
                if tails.iter().all(|&tail| tail <= small) {
                    let displaced = tails[0].max(tails[1]) / measure.scale();
                    Outcome::Masses(block.masses(&map, measure, (&grid.phi, &grid.e)), displaced)
                } else if is_far(measure, x1, x2) {
                    Outcome::Empty
                } else {
                    Outcome::Split(parts(block, grid, tails))
                }
            })
            .collect();
        pending.clear();
        for outcome in outcomes {
            match outcome {
                Outcome::Empty => {}
                Outcome::Split(parts) => pending.extend(parts),
                Outcome::Masses(masses, displaced) => {
                    for BinMass { bin: (i, j), mass: share, difference } in masses {
                        mass[i * grid.e.bins + j] += share;
                        error += difference + displaced * share.abs();
                    }
                }
            }
        }
    }
    let negative: f64 = mass.iter().map(|mass| (-mass).max(0.0)).sum();
    let density = mass.iter().map(|mass| mass.max(0.0) / grid.bin_area()).collect();
    let mass_outside = 1.0 - mass.iter().sum::<f64>();
    Some(Joint { density, error: error + 2.0 * negative, mass_outside, orbits })
}

enum Outcome {
    Empty,
    Split(Vec<Block>),
    Masses(Vec<BinMass>, f64),
}

fn first_blocks(grid: &Grid) -> Vec<Block> {
    let ranges = |axis: &crate::grid::Axis| -> Vec<Range> {
        let firsts = (0..axis.bins).step_by(FIRST);
        firsts.map(|first| Range::of_bins(axis, first, FIRST.min(axis.bins - first))).collect()
    };
    let (phi, e) = (ranges(&grid.phi), ranges(&grid.e));
    phi.iter().flat_map(|&phi| e.iter().map(move |&e| Block { phi, e })).collect()
}

fn may_hold(block: &Block, flow: &Flow<impl PlanarHamiltonian>, cloud: HamiltonianRange) -> bool {
    hamiltonian_range(&flow.model, (block.phi.low, block.phi.high), (block.e.low, block.e.high)).meets(cloud)
}

fn backward(flow: &Flow<impl PlanarHamiltonian>, blocks: &[Block], years: f64) -> (Vec<f64>, Vec<f64>) {
    let nodes = blocks.iter().flat_map(|block| {
        let es = block.e.nodes();
        block.phi.nodes().into_iter().flat_map(move |phi| es.map(|e| State::from_polar(phi, e)))
    });
    let (mut x1, mut x2): (Vec<f64>, Vec<f64>) = nodes.map(|state| (state.x1, state.x2)).unzip();
    flow.advance_where_possible(&mut x1, &mut x2, -years);
    (x1, x2)
}

/// Whether a block's image is farther from the cloud than its nodes are from each other.
fn is_far(measure: &Measure, x1: &[f64], x2: &[f64]) -> bool {
    let gap = |a: usize, b: usize| (x1[a] - x1[b]).hypot(x2[a] - x2[b]);
    let beside = (0..N * N).filter(|k| k % N > 0).map(|k| gap(k, k - 1));
    let widest = beside.chain((N..N * N).map(|k| gap(k, k - N))).fold(0.0, f64::max);
    let nearest = x1.iter().zip(x2).map(|(&x1, &x2)| distance_from_cloud(measure, State { x1, x2 }));
    nearest.fold(f64::INFINITY, f64::min) > 2.0 * widest
}

fn parts(block: &Block, grid: &Grid, [phi_tail, e_tail]: [f64; 2]) -> Vec<Block> {
    let (phi, e) = (block.phi.halves(&grid.phi), block.e.halves(&grid.e));
    if phi_tail > 100.0 * e_tail {
        phi.map(|phi| Block { phi, e: block.e }).to_vec()
    } else if e_tail > 100.0 * phi_tail {
        e.map(|e| Block { phi: block.phi, e }).to_vec()
    } else {
        phi.iter().flat_map(|&phi| e.map(|e| Block { phi, e })).collect()
    }
}

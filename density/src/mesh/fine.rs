//! A refined lattice: the polynomials of a lattice as straight triangles, fine enough for the bins.

use rayon::prelude::*;

use super::MeshError;
use super::gaussian::{probability, standard_density};
use super::lattice::{Refinement, graded_triangles};
use super::readout::Node;
use crate::angle::nearest;
use crate::estimate::ordered_sum;
use crate::grid::Grid;
use crate::model::plane::State;
use crate::problem::InitialGaussian;

/// Triangles that keep their probability.
#[derive(Debug, Clone)]
pub(super) struct Elements {
    pub(super) triangles: Vec<[u32; 3]>,
    /// Probability of each triangle.
    pub(super) mass: Vec<f64>,
    /// Sum of the probabilities.
    pub(super) total: f64,
    /// `n0 s0/e0` at each node.
    pub(super) invariant_density: Vec<f64>,
}

impl Elements {
    /// Triangles between `nodes`, which are in standard deviations, with the probabilities of the triangles.
    pub(super) fn new(initial: &InitialGaussian, nodes: &[[f64; 2]], triangles: Vec<[u32; 3]>, mass: Vec<f64>) -> Self {
        let invariant_density = |&[u, v]: &[f64; 2]| {
            let (phi, e) = initial.point(u, v);
            let density = initial.density(phi, e) * State::from_polar(phi, e).s() / e;
            if density.is_finite() { density } else { 0.0 }
        };
        let invariant_density = nodes.par_iter().map(invariant_density).collect();
        let total = mass.iter().sum();
        Self { triangles, mass, total, invariant_density }
    }

    pub(super) fn nodes(&self, x1: &[f64], x2: &[f64]) -> Vec<Node> {
        let densities = &self.invariant_density;
        x1.par_iter().zip(x2).zip(densities).map(|((&x1, &x2), &density)| Node::new(x1, x2, density)).collect()
    }

    pub(super) fn corners(&self, nodes: &[Node], triangle: usize) -> [Node; 3] {
        self.triangles[triangle].map(|node| nodes[node as usize])
    }
}

/// A lattice refined to a given number of cells per side.
#[derive(Debug, Clone)]
pub(super) struct FineLattice {
    pub(super) refinement: Refinement,
    /// The refinement by polynomials two degrees lower; `None` if there are none.
    rougher: Option<Refinement>,
    /// Those points of the refined lattice that are nodes of triangles.
    used: Vec<u32>,
    pub(super) elements: Elements,
}

impl FineLattice {
    /// The lattice with these lines in standard deviations; its gaps are divided so that it has about `cells` cells per
    /// side.
    pub(super) fn new(
        initial: &InitialGaussian,
        lines: &[Vec<f64>; 2],
        degree: usize,
        cells: usize,
    ) -> Result<Self, MeshError> {
        let factor = cells.div_ceil(lines[0].len() - 1);
        let refined = |degree| Refinement::new(&lines[0], &lines[1], degree, factor);
        let refinement = refined(degree)?;
        let rougher = if degree > 2 { Some(refined(degree - 2)?) } else { None };
        let mut triangles = graded_triangles(&refinement.outer, &refinement.inner);
        let used = number_nodes(triangles.iter_mut().collect());
        let width = refinement.inner.len() as u32;
        let point = |&k: &u32| [refinement.outer[(k / width) as usize], refinement.inner[(k % width) as usize]];
        let nodes: Vec<[f64; 2]> = used.iter().map(point).collect();
        let mass = triangles.par_iter().map(|t| probability(&t.map(|node| nodes[node as usize]))).collect();
        let elements = Elements::new(initial, &nodes, triangles, mass);
        Ok(Self { refinement, rougher, used, elements })
    }

    /// All states of the refined lattice, from the states of the lattice.
    pub(super) fn refine(&self, x1: &[f64], x2: &[f64]) -> [Vec<f64>; 2] {
        [x1, x2].map(|values| self.refinement.apply(values))
    }

    /// The nodes of the triangles, from the states of the refined lattice.
    pub(super) fn nodes(&self, [x1, x2]: &[Vec<f64>; 2]) -> Vec<Node> {
        let used = |values: &[f64]| -> Vec<f64> { self.used.iter().map(|&node| values[node as usize]).collect() };
        self.elements.nodes(&used(x1), &used(x2))
    }

    /// Estimated total variation by which the interpolation misplaces the joint density in the bins of `grid`: the mean
    /// distance, in bins and at most one, by which polynomials two degrees lower move the points of the refined
    /// lattice. `lattice` holds the states of the lattice, `states` those of the refined lattice.
    pub(super) fn misplaced_by_interpolation(&self, lattice: [&[f64]; 2], states: &[Vec<f64>; 2], grid: &Grid) -> f64 {
        let Some(rougher) = &self.rougher else { return 0.0 };
        let rough = lattice.map(|values| rougher.apply(values));
        let width = self.refinement.inner.len();
        let moved = |k: usize| {
            let at = [self.refinement.outer[k / width], self.refinement.inner[k % width]];
            let polar = |x1: f64, x2: f64| (x1.atan2(x2), State { x1, x2 }.eccentricity());
            let ((phi, e), (rough_phi, rough_e)) = (polar(states[0][k], states[1][k]), polar(rough[0][k], rough[1][k]));
            let bins = nearest(phi - rough_phi, 0.0).abs() / grid.phi.width() + (e - rough_e).abs() / grid.e.width();
            let density = standard_density(at);
            [density * bins.min(1.0), density]
        };
        let [moved, total] = ordered_sum(states[0].len(), moved);
        moved / total
    }

    /// Estimated total variation by which straight triangles misplace the joint density in the bins of `grid`: the mean
    /// distance, in bins and at most one, of a polynomial from the chord over two gaps of the refined lattice.
    pub(super) fn misplaced_by_chords(&self, [x1, x2]: &[Vec<f64>; 2], grid: &Grid) -> f64 {
        let (outer, inner) = (&self.refinement.outer, &self.refinement.inner);
        let width = inner.len();
        let state = |i: usize, j: usize| State { x1: x1[i * width + j], x2: x2[i * width + j] };
        let polar = |state: State| (state.x1.atan2(state.x2), state.eccentricity());
        let bend = |before: State, here: (f64, f64), after: State| {
            let ((a, e_a), (b, e_b)) = (polar(before), polar(after));
            let bend = nearest(a, here.0) + nearest(b, here.0) - 2.0 * here.0;
            bend.abs() / grid.phi.width() + (e_a + e_b - 2.0 * here.1).abs() / grid.e.width()
        };
        let sums: Vec<[f64; 2]> = (1..outer.len() - 1)
            .into_par_iter()
            .map(|i| {
                (1..width - 1).fold([0.0; 2], |[sum, weight], j| {
                    let density = standard_density([outer[i], inner[j]]);
                    if density < 1e-7 {
                        return [sum, weight];
                    }
                    let here = polar(state(i, j));
                    let bends =
                        bend(state(i - 1, j), here, state(i + 1, j)) + bend(state(i, j - 1), here, state(i, j + 1));
                    [sum + density * (MISPLACED * bends).min(1.0), weight + density]
                })
            })
            .collect();
        let [sum, weight] = sums.into_iter().fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
        if weight > 0.0 { sum / weight } else { 1.0 }
    }
}

/// Share of its probability that a triangle puts into a wrong bin, per bin by which the states on both sides of a node
/// miss the line through it. The distance of a parabola from its chord is an eighth of that miss, and two thirds of the
/// eighth on average.
const MISPLACED: f64 = 1.0 / 12.0;

/// Renumbers the points that triangles use from zero on, and returns the old number of each.
pub(super) fn number_nodes(triangles: Vec<&mut [u32; 3]>) -> Vec<u32> {
    let mut used: Vec<u32> = triangles.iter().flat_map(|triangle| **triangle).collect();
    used.sort_unstable();
    used.dedup();
    let mut number = vec![0; used.last().map_or(0, |&last| last as usize + 1)];
    used.iter().zip(0..).for_each(|(&point, node)| number[point as usize] = node);
    triangles.into_iter().flatten().for_each(|point| *point = number[*point as usize]);
    used
}

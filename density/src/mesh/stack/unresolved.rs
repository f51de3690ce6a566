//! The cells of a stack that its polynomials do not resolve, and the orbits that take their place.
//!
//! Where orbits come near `e = 1`, or part at a saddle, neighbours of the lattice end so far apart that no polynomial
//! between them is right. A cell, between two layers, counts as not resolved where polynomials two degrees lower, in
//! the layers or between them, differ in its middle by more than [`APART`]. In such a cell, and in those next to it,
//! the points of the quadrature are where orbits of the problem's model take them from their starts. The cells that
//! hold least, [`LIGHT`] of the cloud together, stay as they are. Where the orbits would take too many years,
//! [`MOST_YEARS`], every second, fourth ... point stands for the others.
//!
//! This is right only if that model has carried the stack. Some orbits of the lattice show whether it has; where it has
//! not, all cells stay as they are.

use rayon::prelude::*;

use super::lattice::Carried;
use super::layer::Middles;
use crate::flow::{Accuracy, Flow};
use crate::mesh::gaussian::Standard;
use crate::mesh::quadrature::Sparse;
use crate::model::plane::State;
use crate::uncertain::UncertainProblem;

/// A cell counts as not resolved if the polynomials of two degrees differ by more than this in a coordinate of the
/// state.
const APART: f64 = 5e-4;
/// The lightest cells are left as they are, up to this probability together.
const LIGHT: f64 = 1e-5;
/// The most years that orbits are propagated for the layers of the lattice, all orbits together. Layers between them
/// may take as many each time that their number doubles.
const MOST_YEARS: f64 = 400_000.0;
/// If an orbit of the model ends farther than this from the lattice's point, the points were carried by another model.
const OTHER: f64 = 1e-3;

/// Cells whose points are propagated.
#[derive(Debug, Clone)]
pub(super) struct Unresolved {
    /// For each gap between two layers, which of its cells are propagated; empty if none is.
    gaps: Vec<Vec<bool>>,
    /// One point in so many is propagated, along each direction.
    stride: usize,
    /// The time of the snapshot \[yr\].
    time: f64,
}

impl Unresolved {
    /// Those of a stack at `time` \[yr\].
    pub(super) fn find(carried: &Carried<'_>, time: f64) -> Self {
        let stack = carried.stack;
        let (gaps, cells) = (stack.levels.len() - 1, stack.side - 1);
        let bad: Vec<Vec<bool>> = (0..gaps).into_par_iter().map(|gap| apart(&carried.middles(gap))).collect();
        let mut found = Self { gaps: vec![Vec::new(); gaps], stride: 1, time };
        if bad.iter().flatten().any(|&bad| bad) && is_by_the_model(carried, time) {
            let wide: Vec<Vec<bool>> = (0..gaps).map(|gap| widened(&bad, gap, cells)).collect();
            let count = found.take_heavy(carried, wide);
            let years = (count * stack.layer.quadrature().points_in_cell()) as f64 * time;
            while years > MOST_YEARS * found.stride as f64 {
                found.stride *= 2;
            }
        }
        found
    }

    /// Takes these cells, save the lightest, and returns how many there are.
    fn take_heavy(&mut self, carried: &Carried<'_>, wide: Vec<Vec<bool>>) -> usize {
        let stack = carried.stack;
        let masses = |(gap, cells): (usize, &Vec<bool>)| -> Vec<(f64, usize, usize)> {
            let of_gap = stack.density(stack.z_at(gap as f64 + 0.5)) * (stack.levels[1] - stack.levels[0]);
            let held = (0..cells.len()).filter(|&cell| cells[cell]);
            held.map(|cell| (of_gap * stack.layer.cell_mass(cell), gap, cell)).collect()
        };
        let mut all: Vec<(f64, usize, usize)> = wide.iter().enumerate().flat_map(masses).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut sum = 0.0;
        let light = all.iter().take_while(|(mass, ..)| {
            sum += mass;
            sum < LIGHT
        });
        let heavy = &all[light.count()..];
        for &(_, gap, cell) in heavy {
            let cells = &mut self.gaps[gap];
            cells.resize(wide[gap].len(), false);
            cells[cell] = true;
        }
        heavy.len()
    }

    /// Those of the gap after layer `gap`.
    pub(super) fn of_gap(&self, gap: usize) -> &[bool] {
        &self.gaps[gap]
    }

    /// Those of the layer at a position: of the gap in which it lies, or of both gaps beside it.
    pub(super) fn at(&self, position: f64) -> Vec<bool> {
        let gap = position as usize;
        let none = Vec::new();
        let after = self.gaps.get(gap).unwrap_or(&none);
        if position.fract() > 0.0 || gap == 0 {
            return after.clone();
        }
        let before = &self.gaps[gap - 1];
        let is = |cells: &[bool], cell: usize| cells.get(cell).copied().unwrap_or(false);
        (0..before.len().max(after.len())).map(|cell| is(before, cell) || is(after, cell)).collect()
    }

    /// Which points are propagated in a layer that counts its points from the `share` of them.
    pub(super) fn sparse(&self, share: f64) -> Sparse {
        Sparse { stride: self.stride, first: (share * self.stride as f64) as usize }
    }

    /// Where the orbits are that start at these points of the layer at `z`; `None` for those that cannot be followed.
    pub(super) fn carry(&self, problem: &UncertainProblem, z: f64, starts: &[Standard]) -> Vec<Option<State>> {
        let Some(leaf) = problem.leaf(z) else { return vec![None; starts.len()] };
        let start = |&[u, v]: &Standard| {
            let (phi, e) = problem.plane.initial.point(u, v);
            State::from_polar(phi, e)
        };
        let (mut x1, mut x2): (Vec<f64>, Vec<f64>) = starts.iter().map(start).map(|state| (state.x1, state.x2)).unzip();
        let flow = Flow { model: leaf.model, accuracy: Accuracy::Coarse };
        flow.carry_where_possible(&mut [&mut x1, &mut x2], 0.0, self.time);
        let end = |(x1, x2): (f64, f64)| (x1.is_finite() && x2.is_finite()).then_some(State { x1, x2 });
        x1.into_iter().zip(x2).map(end).collect()
    }
}

/// Whether the polynomials of two degrees are apart in each cell.
fn apart(middles: &Middles) -> Vec<bool> {
    let Middles { states, others } = middles;
    let is_apart = |cell: usize| {
        let off = |other: &[Vec<f64>; 2]| {
            (states[0][cell] - other[0][cell]).abs().max((states[1][cell] - other[1][cell]).abs())
        };
        others.iter().any(|other| off(other) > APART)
    };
    (0..states[0].len()).map(is_apart).collect()
}

/// The cells of a gap that are bad or next to a bad one, in any direction.
fn widened(bad: &[Vec<bool>], gap: usize, cells: usize) -> Vec<bool> {
    let around = |k: usize, count: usize| k.saturating_sub(1)..count.min(k + 2);
    let is_near = |cell: usize| {
        around(gap, bad.len())
            .any(|g| around(cell / cells, cells).any(|i| around(cell % cells, cells).any(|j| bad[g][i * cells + j])))
    };
    (0..cells * cells).map(is_near).collect()
}

/// Whether orbits of the problem's model take a few points of the lattice to where they are.
fn is_by_the_model(carried: &Carried<'_>, time: f64) -> bool {
    let stack = carried.stack;
    let quarters = |count: usize| [1, 2, 3].map(|k| k * (count - 1) / 4);
    quarters(stack.levels.len()).into_iter().all(|level| {
        let nodes: Vec<usize> =
            quarters(stack.side).iter().flat_map(|i| quarters(stack.side).map(|j| i * stack.side + j)).collect();
        let starts: Vec<Standard> = nodes.iter().map(|&node| stack.layer.node(node)).collect();
        let alone = Unresolved { gaps: Vec::new(), stride: 1, time };
        let ends = alone.carry(&stack.problem, stack.levels[level], &starts);
        let is_there = |(&node, end): (&usize, Option<State>)| {
            let row = level * stack.side * stack.side + node;
            end.is_none_or(|end| (end.x1 - carried.x1[row]).hypot(end.x2 - carried.x2[row]) < OTHER)
        };
        nodes.iter().zip(ends).all(is_there)
    })
}

//! Cells whose images reach `e = 0` or the cut of the branch: they are divided until their parts do not reach it or no
//! longer matter.

use rayon::prelude::*;

use super::disc::Disc;
use super::samples::Samples;
use super::{Divided, GAUSS_4, Point, Quadrature, Whole, gauss};
use crate::mesh::gaussian::standard_density;
use crate::mesh::lattice::{Stencil, stencil};
use crate::model::plane::State;

/// Number of parts treated at a time; if more are irregular, the flow is not resolved and dividing does not help.
const MOST_PARTS: usize = 30_000;

/// A cell or a part of one.
#[derive(Debug, Clone, Copy)]
struct CellPart {
    cell: [usize; 2],
    low: [f64; 2],
    high: [f64; 2],
}

impl Quadrature {
    /// The points of all cells. In a cell where `phi` or `e` is not smooth they are those of its parts, unless orbits
    /// have given its points.
    pub(super) fn cut_open(&self, whole: Whole, [x1, x2]: [&[f64]; 2], cut: f64) -> Samples {
        let is_irregular = |&cell: &usize| !whole.is_direct(cell) && !whole.discs[cell].is_regular(cut);
        let irregular = (0..whole.discs.len()).filter(is_irregular).collect::<Vec<_>>();
        let mut samples = whole.samples;
        let points = self.points_a_cell * self.points_a_cell;
        irregular.iter().for_each(|cell| samples.weights[cell * points..(cell + 1) * points].fill(0.0));
        let cells = self.lines[0].len() - 1;
        let parts = irregular.iter().map(|cell| self.whole([cell / cells, cell % cells])).collect();
        samples.append(self.divided(parts, x1, x2, cut));
        samples
    }

    /// The points of parts of cells; irregular parts are divided.
    fn divided(&self, mut parts: Vec<CellPart>, x1: &[f64], x2: &[f64], cut: f64) -> Samples {
        let mut samples = Samples::default();
        while !parts.is_empty() {
            let last = parts.len() > MOST_PARTS;
            let done: Vec<(Samples, Option<[CellPart; 4]>)> = parts
                .par_iter()
                .map(|part| match last || self.is_small(part) || self.disc(part, x1, x2).is_regular(cut) {
                    true => (self.part_samples(part, x1, x2), None),
                    false => (Samples::default(), Some(part.quarters())),
                })
                .collect();
            parts.clear();
            for (some, quarters) in done {
                samples.append(some);
                parts.extend(quarters.into_iter().flatten());
            }
        }
        samples
    }

    /// Points of a part of a cell.
    fn part_samples(&self, part: &CellPart, x1: &[f64], x2: &[f64]) -> Samples {
        let points = |axis: usize| -> Vec<Point> {
            let lines = &self.lines[axis];
            gauss(&GAUSS_4, part.low[axis], part.high[axis])
                .map(|(at, width)| Point { at, width, stencil: stencil(lines, part.cell[axis], self.degree, at) })
                .collect()
        };
        let (outer, inner) = (points(0), points(1));
        let mut samples = Samples::default();
        for a in &outer {
            for b in &inner {
                let state = self.state(&a.stencil, &b.stencil, x1, x2);
                samples.push(state, standard_density([a.at, b.at]) * a.width * b.width);
            }
        }
        samples
    }

    fn state(&self, outer: &Stencil, inner: &Stencil, x1: &[f64], x2: &[f64]) -> State {
        let side = self.lines[0].len();
        let [x1, x2] =
            [x1, x2].map(|values| outer.sum(self.degree, |line| inner.sum(self.degree, |k| values[line * side + k])));
        State { x1, x2 }
    }

    fn whole(&self, cell: [usize; 2]) -> CellPart {
        let edge = |k: usize| [0, 1].map(|axis| self.lines[axis][cell[axis] + k]);
        CellPart { cell, low: edge(0), high: edge(1) }
    }

    fn is_small(&self, part: &CellPart) -> bool {
        let width = [0, 1].map(|axis| part.high[axis] - part.low[axis]);
        let nearest = [0, 1].map(|axis| 0f64.clamp(part.low[axis], part.high[axis]));
        let Divided { narrow, light } = self.divided;
        width[0].max(width[1]) < narrow || width[0] * width[1] * standard_density(nearest) < light
    }

    fn disc(&self, part: &CellPart, x1: &[f64], x2: &[f64]) -> Disc {
        let thirds = [0, 1].map(|axis| {
            let (low, high) = (part.low[axis], part.high[axis]);
            [low, low.midpoint(high), high].map(|at| stencil(&self.lines[axis], part.cell[axis], self.degree, at))
        });
        let states: [State; 9] = std::array::from_fn(|k| self.state(&thirds[0][k / 3], &thirds[1][k % 3], x1, x2));
        Disc::around(states.into_iter(), 1.0)
    }
}

impl CellPart {
    fn quarters(&self) -> [Self; 4] {
        let middle = [0, 1].map(|axis| self.low[axis].midpoint(self.high[axis]));
        [0, 1, 2, 3].map(|k| {
            let upper = [k & 1 == 1, k & 2 == 2];
            let low = [0, 1].map(|axis| if upper[axis] { middle[axis] } else { self.low[axis] });
            let high = [0, 1].map(|axis| if upper[axis] { self.high[axis] } else { middle[axis] });
            Self { cell: self.cell, low, high }
        })
    }
}

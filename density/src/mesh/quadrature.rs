//! Moments of the flow that a lattice interpolates, by quadrature of the polynomials themselves.
//!
//! The interpolated states `(x1, x2)` are smooth functions of the initial point everywhere. `phi` and `e` are not: they
//! have a singularity where a state passes `e = 0`, and `phi` jumps by a turn where the state passes the cut of its
//! branch. So means are sums over Gauss-Legendre points in every lattice cell, with the initial Gaussian in the
//! weights. A cell whose image reaches `e = 0` or the cut is divided until its parts do not reach it or no longer
//! matter. All weights are positive.

mod direct;
mod samples;
mod spread;

use std::f64::consts::PI;

use rayon::prelude::*;

use super::gaussian::standard_density;
use super::lattice::{Stencil, stencil};
use crate::angle::{Circular, nearest};
use crate::estimate::{Moments, ordered_sum};
use crate::model::plane::State;

pub(super) use direct::Sparse;
use samples::Samples;
pub(super) use samples::Whole;

/// Gauss-Legendre points and weights on `(-1, 1)` (Abramowitz & Stegun, Table 25.4), the positive half.
const GAUSS_2: [(f64, f64); 1] = [(0.577_350_269_189_625_8, 1.0)];
const GAUSS_4: [(f64, f64); 2] =
    [(0.339_981_043_584_856_26, 0.652_145_154_862_546_1), (0.861_136_311_594_052_6, 0.347_854_845_137_453_85)];
const GAUSS_8: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_27),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];
/// How far an irregular cell is divided.
#[derive(Debug, Clone, Copy)]
struct Divided {
    /// Width of a part \[standard deviations\] below which it is not divided.
    narrow: f64,
    /// Probability of a part below which it is not divided.
    light: f64,
}

/// Of a single lattice.
const FULLY: Divided = Divided { narrow: 0.006, light: 1e-9 };
/// Of one of many lattices of which a mean is taken, in which the cut passes elsewhere each time.
const COARSELY: Divided = Divided { narrow: 0.04, light: 1e-6 };
/// Number of parts treated at a time; if more are irregular, the flow is not resolved and dividing does not help.
const MOST_PARTS: usize = 30_000;
/// Distance of a part's middle from the origin, in half widths of the part, beyond which `phi` and `e` are smooth in it.
const FAR: f64 = 3.0;
/// Movement of the branch cut that calls for another division \[rad\].
const SAME_CUT: f64 = 1e-4;

/// The points of a lattice and the polynomials between them.
#[derive(Debug, Clone)]
pub(super) struct Quadrature {
    lines: [Vec<f64>; 2],
    degree: usize,
    /// Points in every cell, along the outer and the inner direction.
    axes: [Vec<Point>; 2],
    points_a_cell: usize,
    divided: Divided,
    /// Ratio of the half width of a cell to the distance from its middle to its outermost point.
    corner: f64,
}

/// A quadrature point along one direction.
#[derive(Debug, Clone, Copy)]
struct Point {
    at: f64,
    /// The width that the point stands for.
    width: f64,
    stencil: Stencil,
}

/// A cell or a part of one.
#[derive(Debug, Clone, Copy)]
struct Part {
    cell: [usize; 2],
    low: [f64; 2],
    high: [f64; 2],
}

/// A circle in `(x1, x2)` within which the image of a cell lies.
#[derive(Debug, Clone, Copy)]
struct Disc {
    middle: State,
    radius: f64,
}

/// Factor by which an image may extend beyond the points examined.
const BULGE: f64 = 1.25;

impl Disc {
    /// Around points; the distance to the corners is `reach` times that to the farthest of the points.
    fn around(points: impl Iterator<Item = State> + Clone, reach: f64) -> Self {
        let sum = points.clone().fold([0.0; 3], |[x1, x2, n], state| [x1 + state.x1, x2 + state.x2, n + 1.0]);
        let middle = State { x1: sum[0] / sum[2], x2: sum[1] / sum[2] };
        let distance = |state: State| (state.x1 - middle.x1).hypot(state.x2 - middle.x2);
        Self { middle, radius: BULGE * reach * points.map(distance).fold(0.0, f64::max) }
    }

    /// Whether `phi` and `e` are smooth in the disc: it is far from the origin compared with its size, and off the cut.
    fn is_regular(&self, cut: f64) -> bool {
        let e = self.middle.eccentricity();
        e > FAR * self.radius && {
            let off_cut = nearest(self.middle.x1.atan2(self.middle.x2) - cut, 0.0).abs();
            off_cut > (self.radius / e).asin()
        }
    }
}

/// Quadrature points of `rule` between `low` and `high`: position and width.
fn gauss(rule: &[(f64, f64)], low: f64, high: f64) -> impl Iterator<Item = (f64, f64)> {
    let (middle, half) = (low.midpoint(high), 0.5 * (high - low));
    let both = rule.iter().flat_map(|&(x, weight)| [(-x, weight), (x, weight)]);
    both.map(move |(x, weight)| (middle + half * x, half * weight))
}

impl Quadrature {
    /// A quadrature over the lattice with these lines in standard deviations, interpolated to `degree`.
    pub(super) fn new(lines: [Vec<f64>; 2], degree: usize) -> Self {
        let rule: &[(f64, f64)] = match lines[0].len() {
            ..=61 => &GAUSS_8,
            62..=161 => &GAUSS_4,
            _ => &GAUSS_2,
        };
        Self::by_rule(lines, degree, rule, FULLY)
    }

    /// The same with fewer points, for one of many lattices of which a mean is taken.
    pub(super) fn of_many(lines: [Vec<f64>; 2], degree: usize) -> Self {
        let rule: &[(f64, f64)] = if lines[0].len() <= 61 { &GAUSS_4 } else { &GAUSS_2 };
        Self::by_rule(lines, degree, rule, COARSELY)
    }

    fn by_rule(lines: [Vec<f64>; 2], degree: usize, rule: &[(f64, f64)], divided: Divided) -> Self {
        let axes = lines.each_ref().map(|lines| {
            let cells = 0..lines.len() - 1;
            let points = |cell: usize| {
                gauss(rule, lines[cell], lines[cell + 1]).map(move |(at, width)| Point {
                    at,
                    width,
                    stencil: stencil(lines, cell, degree, at),
                })
            };
            cells.flat_map(points).collect()
        });
        let corner = 1.0 / rule.iter().map(|&(x, _)| x).fold(0.0, f64::max);
        Self { lines, degree, axes, points_a_cell: 2 * rule.len(), divided, corner }
    }

    /// Moments of the cloud whose lattice points are at these states.
    pub(super) fn moments(&self, x1: &[f64], x2: &[f64], critical_e: f64) -> (Moments, Circular) {
        let whole = self.whole_cells(x1, x2);
        let (mut moments, mut circular) = whole.samples.moments(critical_e);
        for _ in 0..2 {
            let cut = circular.mean + PI;
            (moments, circular) = self.cut_open(whole.clone(), [x1, x2], cut).moments(critical_e);
            if nearest(circular.mean + PI - cut, 0.0).abs() < SAME_CUT {
                break;
            }
        }
        (moments, circular)
    }

    /// The probability inside the lattice, and the sums of sine and cosine of the solar angle and of the eccentricity.
    pub(super) fn mean_vector(whole: &Whole) -> [f64; 4] {
        let Samples { phi, e, weights } = &whole.samples;
        ordered_sum(phi.len(), |i| [1.0, phi[i].sin(), phi[i].cos(), e[i]].map(|term| weights[i] * term))
    }

    /// The sums of the powers 1, phi, e, phi², phi e and e² of the distances from `centre`, with the solar angles on the branch around
    /// that of the centre; and the sums of sine and cosine of the solar angle.
    pub(super) fn power_sums(&self, [x1, x2]: [&[f64]; 2], centre: [f64; 2], whole: Whole) -> ([f64; 6], [f64; 2]) {
        let Samples { phi, e, weights } = self.cut_open(whole, [x1, x2], centre[0] + PI);
        let (mut powers, mut vector) = ([0.0; 6], [0.0; 2]);
        for ((&phi, &e), &weight) in phi.iter().zip(&e).zip(&weights) {
            let (dphi, de) = (nearest(phi, centre[0]) - centre[0], e - centre[1]);
            let terms = [1.0, dphi, de, dphi * dphi, dphi * de, de * de];
            powers.iter_mut().zip(terms).for_each(|(sum, term)| *sum += weight * term);
            let (sin, cos) = phi.sin_cos();
            vector[0] += weight * sin;
            vector[1] += weight * cos;
        }
        (powers, vector)
    }

    /// The points of all cells, where those of polynomials in which `phi` and `e` are not smooth are replaced by the points of the cells' parts.
    fn cut_open(&self, whole: Whole, [x1, x2]: [&[f64]; 2], cut: f64) -> Samples {
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

    /// The points of all cells, one cell after the other, and the disc of each cell.
    pub(super) fn whole_cells(&self, x1: &[f64], x2: &[f64]) -> Whole {
        let along = [x1, x2].map(|values| self.along_inner(values));
        let cells = self.lines[0].len() - 1;
        let rows: Vec<(Samples, Vec<Disc>)> =
            (0..cells).into_par_iter().map(|row| self.of_row(row, [&along[0], &along[1]])).collect();
        let (mut samples, mut discs) = (Samples::default(), Vec::with_capacity(cells * cells));
        for (row, mut of_row) in rows {
            samples.append(row);
            discs.append(&mut of_row);
        }
        Whole { samples, discs, direct: Vec::new() }
    }

    /// The points of parts of cells; irregular parts are divided.
    fn divided(&self, mut parts: Vec<Part>, x1: &[f64], x2: &[f64], cut: f64) -> Samples {
        let mut samples = Samples::default();
        while !parts.is_empty() {
            let last = parts.len() > MOST_PARTS;
            let done: Vec<(Samples, Option<[Part; 4]>)> = parts
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

    /// Values at the quadrature points along the inner direction, on every line of the outer direction.
    fn along_inner(&self, values: &[f64]) -> Vec<f64> {
        let side = self.lines[0].len();
        let row = |row: &[f64]| -> Vec<f64> {
            self.axes[1].iter().map(|point| point.stencil.sum(self.degree, |k| row[k])).collect()
        };
        values.par_chunks(side).flat_map_iter(row).collect()
    }

    /// The points of a row of cells, and the discs of its cells.
    fn of_row(&self, row: usize, along: [&[f64]; 2]) -> (Samples, Vec<Disc>) {
        let (width, n) = (self.axes[1].len(), self.points_a_cell);
        let (mut samples, mut discs) = (Samples::default(), Vec::new());
        let mut states = Vec::with_capacity(n * n);
        for column in 0..width / n {
            states.clear();
            for outer in &self.axes[0][row * n..(row + 1) * n] {
                for (k, inner) in self.axes[1].iter().enumerate().skip(column * n).take(n) {
                    let [x1, x2] = along.map(|values| outer.stencil.sum(self.degree, |line| values[line * width + k]));
                    let weight = standard_density([outer.at, inner.at]) * outer.width * inner.width;
                    states.push(State { x1, x2 });
                    samples.push(State { x1, x2 }, weight);
                }
            }
            discs.push(Disc::around(states.iter().copied(), self.corner));
        }
        (samples, discs)
    }

    /// Points of a part of a cell.
    fn part_samples(&self, part: &Part, x1: &[f64], x2: &[f64]) -> Samples {
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

    fn whole(&self, cell: [usize; 2]) -> Part {
        let edge = |k: usize| [0, 1].map(|axis| self.lines[axis][cell[axis] + k]);
        Part { cell, low: edge(0), high: edge(1) }
    }

    fn is_small(&self, part: &Part) -> bool {
        let width = [0, 1].map(|axis| part.high[axis] - part.low[axis]);
        let nearest = [0, 1].map(|axis| 0f64.clamp(part.low[axis], part.high[axis]));
        let Divided { narrow, light } = self.divided;
        width[0].max(width[1]) < narrow || width[0] * width[1] * standard_density(nearest) < light
    }

    fn disc(&self, part: &Part, x1: &[f64], x2: &[f64]) -> Disc {
        let thirds = [0, 1].map(|axis| {
            let (low, high) = (part.low[axis], part.high[axis]);
            [low, low.midpoint(high), high].map(|at| stencil(&self.lines[axis], part.cell[axis], self.degree, at))
        });
        let states: [State; 9] = std::array::from_fn(|k| self.state(&thirds[0][k / 3], &thirds[1][k % 3], x1, x2));
        Disc::around(states.into_iter(), 1.0)
    }
}

impl Part {
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

#[cfg(test)]
mod tests;

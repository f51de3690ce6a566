//! Moments of the flow that a lattice interpolates, by quadrature of the polynomials themselves.
//!
//! The interpolated states `(x1, x2)` are smooth functions of the initial point everywhere. `phi` and `e` are not: they
//! have a singularity where a state passes `e = 0`, and `phi` jumps by a turn where the state passes the cut of its
//! branch. So means are sums over Gauss-Legendre points in every lattice cell, with the initial Gaussian in the
//! weights. Cells whose images reach `e = 0` or the cut are divided ([`divided`]). All weights are positive.
//!
//! | file | idea |
//! |---|---|
//! | `samples` | weighted points of a cloud, and their moments |
//! | `disc` | a disc within which the image of a cell lies |
//! | `divided` | cells whose images reach `e = 0` or the cut |
//! | `spread` | the points as places that fill the plane, from which a density can be counted |
//! | `direct` | points that orbits reach instead of polynomials |

mod direct;
mod disc;
mod divided;
mod samples;
mod spread;

use std::f64::consts::PI;

use rayon::prelude::*;

use self::disc::Disc;
use self::samples::Samples;
use super::gaussian::standard_density;
use super::lattice::{Stencil, stencil};
use crate::angle::{Circular, nearest};
use crate::estimate::{Moments, ordered_sum};
use crate::model::plane::State;

pub(super) use direct::Sparse;
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
/// Movement of the branch cut that calls for another division \[rad\].
const SAME_CUT: f64 = 1e-4;

/// How far an irregular cell is divided.
#[derive(Debug, Clone, Copy)]
struct Divided {
    /// Width of a part \[standard deviations\] below which it is not divided.
    narrow: f64,
    /// Probability of a part below which it is not divided.
    light: f64,
}

/// How far they are divided in a single lattice.
const FULLY: Divided = Divided { narrow: 0.006, light: 1e-9 };
/// The same in one of many lattices of which a mean is taken: the cut passes elsewhere in each.
const COARSELY: Divided = Divided { narrow: 0.04, light: 1e-6 };

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

    /// The probability inside the lattice, and the sums of sine and cosine of the solar angle, and the sum of the
    /// eccentricity.
    pub(super) fn mean_vector(whole: &Whole) -> [f64; 4] {
        let Samples { phi, e, weights } = &whole.samples;
        ordered_sum(phi.len(), |i| [1.0, phi[i].sin(), phi[i].cos(), e[i]].map(|term| weights[i] * term))
    }

    /// The sums of the powers 1, phi, e, phi², phi e and e² of the distances from `centre`, with the solar angles on
    /// the branch around that of the centre; and the sums of sine and cosine of the solar angle.
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
}

#[cfg(test)]
mod tests;

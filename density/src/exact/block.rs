//! A block: a rectangle of the `(phi, e)` plane at time `t` on which the backward flow is one polynomial.
//!
//! The backward map to `t = 0` is a product of Chebyshev polynomials through `N x N` backward orbits. On every grid
//! line inside the block it reduces to a [`ChebyshevCurve`]; circulation along the four edges of a bin is the bin's
//! probability.

use crate::grid::Axis;

use super::chebyshev_curve::{ChebyshevCurve, Resolution, chebyshev_nodes};
use super::measure::Measure;

/// Number of Chebyshev nodes in each direction.
pub(super) const N: usize = 12;

/// A range of one axis: several whole bins, or one bin or part of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Range {
    pub low: f64,
    pub high: f64,
    /// The first bin.
    pub first: usize,
    /// The number of bins.
    pub bins: usize,
}

impl Range {
    pub(super) fn of_bins(axis: &Axis, first: usize, bins: usize) -> Self {
        Self { low: axis.edge(first), high: axis.edge(first + bins), first, bins }
    }

    pub(super) fn halves(self, axis: &Axis) -> [Self; 2] {
        let middle = self.bins / 2;
        if middle > 0 {
            [Self::of_bins(axis, self.first, middle), Self::of_bins(axis, self.first + middle, self.bins - middle)]
        } else {
            let middle = self.low.midpoint(self.high);
            [Self { high: middle, ..self }, Self { low: middle, ..self }]
        }
    }

    pub(super) fn nodes(self) -> [f64; N] {
        chebyshev_nodes::<N>().map(|x| self.low.midpoint(self.high) + 0.5 * (self.high - self.low) * x)
    }

    /// The edges of the range's bins as parameters in `[-1, 1]`.
    fn edges(self, axis: &Axis) -> Vec<f64> {
        let parameter = |x: f64| (2.0 * x - self.low - self.high) / (self.high - self.low);
        let inner = (1..self.bins).map(|i| parameter(axis.edge(self.first + i)));
        std::iter::once(-1.0).chain(inner).chain(std::iter::once(1.0)).collect()
    }
}

/// A rectangle of the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Block {
    pub phi: Range,
    pub e: Range,
}

/// Chebyshev coefficients of the backward map on a block; the index of `phi` is outermost.
pub(super) struct BackwardMap {
    x1: [[f64; N]; N],
    x2: [[f64; N]; N],
}

impl BackwardMap {
    /// From the states at the start of the backward orbits of the nodes; the index of `phi` is outermost.
    pub(super) fn new(x1: &[f64], x2: &[f64], transform: &[[f64; N]; N]) -> Self {
        let coefficients = |values: &[f64]| {
            let mut rows = [[0.0; N]; N];
            for (row, values) in rows.iter_mut().zip(values.chunks_exact(N)) {
                *row = transform.map(|t| t.iter().zip(values).map(|(t, x)| t * x).sum());
            }
            transform.map(|t| {
                let mut sum = [0.0; N];
                for (t, row) in t.iter().zip(&rows) {
                    sum.iter_mut().zip(row).for_each(|(sum, x)| *sum += t * x);
                }
                sum
            })
        };
        Self { x1: coefficients(x1), x2: coefficients(x2) }
    }

    /// Size of the last two coefficients in `phi` and in `e`; NaN if a node has no backward orbit to `t = 0`.
    pub(super) fn tails(&self) -> [f64; 2] {
        let size = |c: &f64| c.abs();
        let most = |most: f64, c: f64| if most.is_nan() || c.is_nan() { f64::NAN } else { most.max(c) };
        let both = [&self.x1, &self.x2];
        let phi = both.iter().flat_map(|c| c[N - 2..].as_flattened()).map(size).fold(0.0, most);
        let e = both.iter().flat_map(|c| c.iter().flat_map(|row| &row[N - 2..])).map(size).fold(0.0, most);
        [phi, e]
    }

    /// The image of the line `phi` = constant; the parameter runs along `e`.
    fn at_phi(&self, xi: f64) -> ChebyshevCurve<N> {
        let t = chebyshev_values(xi);
        let contract = |c: &[[f64; N]; N]| {
            let mut sum = [0.0; N];
            for (t, row) in t.iter().zip(c) {
                sum.iter_mut().zip(row).for_each(|(sum, c)| *sum += t * c);
            }
            sum
        };
        ChebyshevCurve { x1: contract(&self.x1), x2: contract(&self.x2) }
    }

    /// The image of the line `e` = constant; the parameter runs along `phi`.
    fn at_e(&self, xi: f64) -> ChebyshevCurve<N> {
        let t = chebyshev_values(xi);
        let contract = |c: &[[f64; N]; N]| c.map(|row| row.iter().zip(&t).map(|(c, t)| c * t).sum());
        ChebyshevCurve { x1: contract(&self.x1), x2: contract(&self.x2) }
    }
}

fn chebyshev_values(xi: f64) -> [f64; N] {
    let (mut t, mut next) = (1.0, xi);
    std::array::from_fn(|_| {
        let now = t;
        (t, next) = (next, 2.0 * xi * next - t);
        now
    })
}

/// Probability of a bin (or of the block's part of it), and its difference from the value of a coarser rule.
#[derive(Debug, Clone, Copy)]
pub(super) struct BinMass {
    pub bin: (usize, usize),
    pub mass: f64,
    pub difference: f64,
}

impl Block {
    /// The probabilities of the block's bins.
    pub(super) fn masses(&self, map: &BackwardMap, measure: &Measure, axes: (&Axis, &Axis)) -> Vec<BinMass> {
        let (phi, e) = (self.phi.edges(axes.0), self.e.edges(axes.1));
        let along = |curve: ChebyshevCurve<N>, edges: &[f64]| -> Vec<[f64; 2]> {
            let form = |resolution, w: &[f64]| curve.circulation(measure, resolution, (w[0], w[1]));
            edges.windows(2).map(|w| [Resolution::FINE, Resolution::COARSE].map(|r| form(r, w))).collect()
        };
        let upright: Vec<Vec<[f64; 2]>> = phi.iter().map(|&x| along(map.at_phi(x), &e)).collect();
        let level: Vec<Vec<[f64; 2]>> = e.iter().map(|&x| along(map.at_e(x), &phi)).collect();
        let mut masses = Vec::with_capacity(self.phi.bins * self.e.bins);
        for i in 0..self.phi.bins {
            for j in 0..self.e.bins {
                let around = |r: usize| level[j + 1][i][r] - level[j][i][r] + upright[i][j][r] - upright[i + 1][j][r];
                let (fine, coarse) = (around(0), around(1));
                let bin = (self.phi.first + i, self.e.first + j);
                masses.push(BinMass { bin, mass: fine, difference: (fine - coarse).abs() });
            }
        }
        masses
    }
}

//! Interpolation by products of Chebyshev polynomials on `[-1, 1]^N`.
//!
//! With the values `f_j` at the nodes `x_j = cos(π (j + 1/2)/m)` the interpolating polynomial is
//!
//! ```text
//! p(x) = Σ_k c_k T_k(x),     c_k = (2 - δ_k0)/m Σ_j f_j cos(k π (j + 1/2)/m),     T_k(cos θ) = cos(k θ)
//! ```
//!
//! (Trefethen, *Approximation Theory and Approximation Practice*, 2013, Chapters 3 and 4), axis by axis in `N`
//! dimensions. For a function that is analytic near the box the `c_k` fall geometrically, so the last ones show how far
//! the polynomial is off; coefficients far below that error are left out.

use std::f64::consts::PI;

use multiversion::multiversion;

use crate::model::{LANES, Lanes};

/// Largest number of nodes along an axis.
pub(super) const MOST_NODES: usize = 16;

/// The nodes along one axis and the transform from values to coefficients.
#[derive(Debug, Clone)]
pub(super) struct Basis {
    /// Number of nodes along an axis: even, so that a polynomial is furthest off in the middle and in the corners.
    pub count: usize,
    matrix: Vec<f64>,
}

/// How many nodes there are along an axis for functions of so many variables.
pub(super) const fn nodes_along_an_axis(dimensions: usize) -> usize {
    match dimensions {
        1 | 2 => MOST_NODES,
        3 => 10,
        4 => 8,
        _ => 6,
    }
}

impl Basis {
    /// A basis for functions of so many variables.
    pub fn of(dimensions: usize) -> Self {
        let count = nodes_along_an_axis(dimensions);
        let angle = |j: usize| PI * (j as f64 + 0.5) / count as f64;
        let entry = |k: usize, j: usize| if k == 0 { 1.0 } else { 2.0 * (k as f64 * angle(j)).cos() } / count as f64;
        Self { count, matrix: (0..count * count).map(|i| entry(i / count, i % count)).collect() }
    }

    /// Number of nodes in `N` dimensions.
    pub fn len<const N: usize>(&self) -> usize {
        self.count.pow(N as u32)
    }

    /// Node number `index`; the last axis runs fastest.
    pub fn node<const N: usize>(&self, index: usize) -> [f64; N] {
        std::array::from_fn(|k| {
            let j = index / self.count.pow((N - 1 - k) as u32) % self.count;
            (PI * (j as f64 + 0.5) / self.count as f64).cos()
        })
    }

    /// Turns the values at the nodes into coefficients, in the same order.
    pub fn transform<const N: usize>(&self, values: &mut [f64]) {
        let count = self.count;
        let mut line = [0.0; MOST_NODES];
        for axis in 0..N {
            let stride = count.pow((N - 1 - axis) as u32);
            for first in (0..values.len()).filter(|first| (first / stride).is_multiple_of(count)) {
                (0..count).for_each(|j| line[j] = values[first + j * stride]);
                for (k, row) in self.matrix.chunks_exact(count).enumerate() {
                    values[first + k * stride] = row.iter().zip(&line).map(|(a, b)| a * b).sum();
                }
            }
        }
    }

    /// How slowly the coefficients fall along each axis.
    pub fn tails<const N: usize>(&self, coefficients: &[f64]) -> [Tail; N] {
        std::array::from_fn(|axis| {
            let stride = self.count.pow((N - 1 - axis) as u32);
            let mut largest = [0.0f64; MOST_NODES];
            for (i, c) in coefficients.iter().enumerate() {
                let size = &mut largest[i / stride % self.count];
                *size = if c.is_nan() { f64::INFINITY } else { size.max(c.abs()) };
            }
            // Pairs, since an even or odd function has every second coefficient only.
            let pair = |from_end: usize| largest[self.count - from_end].max(largest[self.count - from_end - 1]);
            let (last, before) = (pair(1), pair(3));
            let rate = if before > 0.0 { (last / before).min(1.0) } else { 0.0 };
            Tail { last, next: if last.is_finite() { last * rate } else { f64::INFINITY } }
        })
    }
}

/// The end of a series along an axis.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Tail {
    /// Size of the last two coefficients.
    pub last: f64,
    /// Size of the two that would follow, if the coefficients go on to fall as before.
    pub next: f64,
}

/// A polynomial without the coefficients that do not matter.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Polynomial<const N: usize> {
    /// Rows of coefficients along the last axis: the degrees along the other axes, and in the last place the number of
    /// pairs in the row.
    rows: Vec<[u8; N]>,
    /// The coefficients of all rows; a row of odd length ends with 0.
    pairs: Vec<[f64; 2]>,
    /// Number of coefficients that were not left out.
    count: usize,
}

impl<const N: usize> Polynomial<N> {
    /// From all coefficients; those at the end of a row that are smaller than `negligible` are left out.
    pub fn new(basis: &Basis, all: &[f64], negligible: f64) -> Self {
        let (mut rows, mut pairs, mut count) = (Vec::new(), Vec::new(), 0);
        for (index, row) in all.chunks_exact(basis.count).enumerate() {
            let length = row.iter().rposition(|c| c.abs() >= negligible).map_or(0, |last| last + 1);
            if length > 0 {
                let row = &row[..length];
                let degree = |k: usize| index / basis.count.pow((N - 2 - k) as u32) % basis.count;
                rows.push(std::array::from_fn(|k| if k + 1 < N { degree(k) } else { length.div_ceil(2) } as u8));
                pairs.extend(row.chunks(2).map(|pair| [pair[0], pair.get(1).copied().unwrap_or(0.0)]));
                count += length;
            }
        }
        Self { rows, pairs, count }
    }

    /// Number of coefficients.
    pub fn len(&self) -> usize {
        self.count
    }

    /// The value at one point.
    pub fn at(&self, local: &[f64; N]) -> f64 {
        let mut value = [[0.0; LANES]];
        evaluate(std::slice::from_ref(self), &std::array::from_fn(|k| [local[k]; LANES]), &mut value);
        value[0][0]
    }

    /// The derivatives at one point, from `T_k' = 2 T_(k-1) + 2 x T_(k-1)' - T_(k-2)'`.
    pub fn slopes(&self, local: &[f64; N]) -> [f64; N] {
        let (mut tables, mut slope_tables) = ([[1.0; MOST_NODES]; N], [[0.0; MOST_NODES]; N]);
        for axis in 0..N {
            let (x, table, slopes) = (local[axis], &mut tables[axis], &mut slope_tables[axis]);
            (table[1], slopes[1]) = (x, 1.0);
            for k in 2..MOST_NODES {
                table[k] = 2.0 * x * table[k - 1] - table[k - 2];
                slopes[k] = 2.0 * table[k - 1] + 2.0 * x * slopes[k - 1] - slopes[k - 2];
            }
        }
        std::array::from_fn(|by| {
            let of = |axis: usize| if axis == by { &slope_tables[axis] } else { &tables[axis] };
            let mut pairs = self.pairs.as_slice();
            let row = |row: &[u8; N]| {
                let (these, others) = pairs.split_at(usize::from(row[N - 1]));
                pairs = others;
                let inner: f64 = these.as_flattened().iter().zip(of(N - 1)).map(|(c, t)| c * t).sum();
                (0..N - 1).fold(inner, |product, axis| product * of(axis)[usize::from(row[axis]) % MOST_NODES])
            };
            self.rows.iter().map(row).sum()
        })
    }
}

/// Values of several polynomials at [`LANES`] points. A lane never looks at its neighbours.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
pub(super) fn evaluate<const N: usize>(polynomials: &[Polynomial<N>], point: &[Lanes; N], values: &mut [Lanes]) {
    let mut tables = [[[1.0; LANES]; MOST_NODES]; N];
    for (table, x) in tables.iter_mut().zip(point) {
        table[1] = *x;
        for k in 2..MOST_NODES {
            for l in 0..LANES {
                table[k][l] = (2.0 * x[l]).mul_add(table[k - 1][l], -table[k - 2][l]);
            }
        }
    }
    let (last_table, _) = tables[N - 1].as_chunks::<2>();
    for (polynomial, value) in polynomials.iter().zip(values) {
        let mut pairs = polynomial.pairs.as_slice();
        let mut sum = [0.0; LANES];
        for row in &polynomial.rows {
            let (these, others) = pairs.split_at(usize::from(row[N - 1]));
            pairs = others;
            // Two sums at a time, since one would wait for itself at every step.
            let (mut inner, mut odd) = ([0.0; LANES], [0.0; LANES]);
            for (c, t) in these.iter().zip(last_table) {
                for l in 0..LANES {
                    inner[l] = c[0].mul_add(t[0][l], inner[l]);
                    odd[l] = c[1].mul_add(t[1][l], odd[l]);
                }
            }
            for l in 0..LANES {
                inner[l] += odd[l];
            }
            for axis in 0..N - 1 {
                let t = &tables[axis][usize::from(row[axis]) % MOST_NODES];
                for l in 0..LANES {
                    inner[l] *= t[l];
                }
            }
            for l in 0..LANES {
                sum[l] += inner[l];
            }
        }
        *value = sum;
    }
}

/// A series of Chebyshev polynomials (Clenshaw's rule).
pub(super) fn series(coefficients: &[f64; MOST_NODES], x: f64) -> f64 {
    let (mut b1, mut b2) = (0.0, 0.0);
    for c in coefficients.iter().skip(1).rev() {
        (b1, b2) = (c + 2.0 * x * b1 - b2, b1);
    }
    coefficients[0] + x * b1 - b2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_of_the_basis_is_reproduced_with_no_more_terms_than_it_has() {
        let basis = Basis::of(3);
        let f = |[x, y, z]: [f64; 3]| 1.0 + x * x * y - 0.5 * z.powi(5) * x;
        let mut values: Vec<f64> = (0..basis.len::<3>()).map(|i| f(basis.node(i))).collect();
        basis.transform::<3>(&mut values);
        let polynomial = Polynomial::<3>::new(&basis, &values, 1e-14);
        for point in [[0.3, -0.7, 0.9], [-1.0, 1.0, 1.0], [0.0, 0.1, -0.2]] {
            assert!((polynomial.at(&point) - f(point)).abs() < 1e-14);
        }
        assert!(polynomial.len() <= 10, "{}", polynomial.len());
        assert!(basis.tails::<3>(&values).iter().all(|tail| tail.next < 1e-14));
    }

    #[test]
    fn the_tail_of_an_analytic_function_says_how_far_its_polynomial_is_off() {
        let basis = Basis::of(2);
        for pole in [1.3, 1.6, 2.0] {
            let f = |[x, y]: [f64; 2]| 1.0 / (pole - x) + y.sin();
            let mut values: Vec<f64> = (0..basis.len::<2>()).map(|i| f(basis.node(i))).collect();
            basis.transform::<2>(&mut values);
            let polynomial = Polynomial::<2>::new(&basis, &values, 0.0);
            let off = (0..=2000)
                .map(|i| [f64::from(i) / 1000.0 - 1.0, 0.3])
                .map(|at| (polynomial.at(&at) - f(at)).abs())
                .fold(0.0, f64::max);
            let [Tail { next, .. }, _] = basis.tails::<2>(&values);
            assert!(off < 10.0 * next && next < 10.0 * off, "{off:e} where {next:e} was expected");
        }
    }
}

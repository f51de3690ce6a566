//! A piece of the family of orbits: states as polynomials of two coordinates that run from -1 to 1.

use multiversion::multiversion;

use crate::flow_map::chebyshev::{Basis, MOST_NODES};

/// The coefficients of `x1` and `x2` for one degree along the second coordinate, at every degree along the first.
type Row = [f64; 2 * MOST_NODES];

/// States `(x1, x2)` as a function of `a` and `b`.
#[derive(Debug, Clone)]
pub(super) struct Patch {
    /// The degree along `b` is the position of the row.
    rows: Vec<Row>,
}

/// A state with its slopes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slopes {
    pub value: [f64; 2],
    /// The derivative by `a`.
    pub by_a: [f64; 2],
    /// The derivative by `b`.
    pub by_b: [f64; 2],
}

impl Slopes {
    /// The determinant of the derivatives.
    pub fn determinant(&self) -> f64 {
        self.by_a[0] * self.by_b[1] - self.by_a[1] * self.by_b[0]
    }
}

impl Patch {
    /// From the coefficients of both coordinates of the state, with `b` fastest; coefficients below `negligible` at the
    /// end of the series along `b` are left out.
    pub fn new(basis: &Basis, coefficients: [&[f64]; 2], negligible: f64) -> Self {
        let row = |k: usize| {
            let mut row = [0.0; 2 * MOST_NODES];
            for a in 0..basis.count {
                for (coordinate, values) in coefficients.iter().enumerate() {
                    row[2 * a + coordinate] = values[a * basis.count + k];
                }
            }
            row
        };
        let mut rows: Vec<Row> = (0..basis.count).map(row).collect();
        let matters = |row: &Row| row.iter().any(|c| c.abs() >= negligible);
        rows.truncate(rows.iter().rposition(matters).map_or(1, |last| last + 1));
        Self { rows }
    }

    /// Number of coefficients.
    pub fn len(&self) -> usize {
        self.rows.len() * 2 * MOST_NODES
    }

    /// The state at a point.
    pub fn at(&self, a: f64, b: f64) -> [f64; 2] {
        value(&self.rows, a, b)
    }

    /// The state at a point with its slopes.
    pub fn slopes(&self, a: f64, b: f64) -> Slopes {
        slopes(&self.rows, a, b)
    }
}

/// The Chebyshev polynomials at `x`.
#[inline(always)]
fn table(x: f64) -> [f64; MOST_NODES] {
    let mut table = [1.0; MOST_NODES];
    table[1] = x;
    for k in 2..MOST_NODES {
        table[k] = 2.0 * x * table[k - 1] - table[k - 2];
    }
    table
}

/// The derivatives of the Chebyshev polynomials at `x`, from `T_k' = 2 T_(k-1) + 2 x T_(k-1)' - T_(k-2)'`.
#[inline(always)]
fn slope_table(x: f64, table: &[f64; MOST_NODES]) -> [f64; MOST_NODES] {
    let mut slopes = [0.0; MOST_NODES];
    slopes[1] = 1.0;
    for k in 2..MOST_NODES {
        slopes[k] = 2.0 * table[k - 1] + 2.0 * x * slopes[k - 1] - slopes[k - 2];
    }
    slopes
}

/// Adds up the rows with these weights.
#[inline(always)]
fn weighted(rows: &[Row], weights: &[f64; MOST_NODES]) -> Row {
    let mut sum = [0.0; 2 * MOST_NODES];
    for (row, weight) in rows.iter().zip(weights) {
        for k in 0..2 * MOST_NODES {
            sum[k] += weight * row[k];
        }
    }
    sum
}

/// The two coordinates at `a` from the sum of rows.
#[inline(always)]
fn along_a(sum: &Row, table: &[f64; MOST_NODES]) -> [f64; 2] {
    let mut value = [0.0; 2];
    for (pair, t) in sum.as_chunks::<2>().0.iter().zip(table) {
        value[0] += t * pair[0];
        value[1] += t * pair[1];
    }
    value
}

// Products and sums are not fused, so that all kinds of processors have the same bytes.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
fn value(rows: &[Row], a: f64, b: f64) -> [f64; 2] {
    along_a(&weighted(rows, &table(b)), &table(a))
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
fn slopes(rows: &[Row], a: f64, b: f64) -> Slopes {
    let (at_a, at_b) = (table(a), table(b));
    let (sum, slope) = (weighted(rows, &at_b), weighted(rows, &slope_table(b, &at_b)));
    Slopes { value: along_a(&sum, &at_a), by_a: along_a(&sum, &slope_table(a, &at_a)), by_b: along_a(&slope, &at_a) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_patch_reproduces_polynomials_and_their_slopes() {
        let basis = Basis::of(2);
        let f = |a: f64, b: f64| [1.0 + a * a * b - 0.5 * b.powi(5), a * b + 0.3 * a.powi(3)];
        let coefficients = [0, 1].map(|k| {
            let mut values: Vec<f64> =
                (0..basis.len::<2>()).map(|i| basis.node::<2>(i)).map(|[a, b]| f(a, b)[k]).collect();
            basis.transform::<2>(&mut values);
            values
        });
        let patch = Patch::new(&basis, coefficients.each_ref().map(Vec::as_slice), 1e-13);
        assert!(patch.len() <= 6 * 2 * MOST_NODES);
        for (a, b) in [(0.3, -0.7), (-1.0, 1.0), (0.0, 0.2)] {
            let Slopes { value, by_a, by_b } = patch.slopes(a, b);
            let right = [(value, f(a, b)), (patch.at(a, b), f(a, b)), (by_a, [2.0 * a * b, b + 0.9 * a * a])];
            let right = right.into_iter().chain([(by_b, [a * a - 2.5 * b.powi(4), a])]);
            for (found, right) in right {
                // The slope of `T_15` is up to 225: so many times as large is the rounding of a slope.
                assert!((0..2).all(|k| (found[k] - right[k]).abs() < 1e-11), "{found:?} {right:?}");
            }
        }
    }
}

//! Averages over the bins of a grid of a function that is known at the points of a lattice, by polynomials.
//!
//! Each bin has a number of intervals to a side. The integral over an interval is that of the polynomial through the
//! nearest points, those outside the bin among them: where the function is smooth on the scale of a bin, a few points
//! to each bin are enough. At the ends of the lattice the nearest points lie on one side. Averages are taken over rows,
//! then over columns.

use std::ops::Range;

use super::rules::gauss;

/// Weights of the points of a line in the averages over bins.
#[derive(Debug)]
pub(super) struct Averaging {
    /// For each bin the first point that counts, and the weights from there on.
    bins: Vec<(usize, Vec<f64>)>,
    points: usize,
}

impl Averaging {
    /// For these bins of `parts` intervals each, by polynomials of this degree, or of the largest that the points
    /// allow. Bin `i` begins at point `i * parts` of a line on which the points in `points` are known.
    pub fn new(bins: Range<usize>, parts: usize, degree: usize, points: Range<usize>) -> Self {
        let degree = degree.min(points.len() - 1);
        // The first of the points nearest to an interval.
        let first =
            |interval: usize| (interval.saturating_sub((degree - 1) / 2)).clamp(points.start, points.end - 1 - degree);
        let of_bin = |bin: usize| {
            let intervals = bin * parts..(bin + 1) * parts;
            let start = first(intervals.start);
            let mut weights = vec![0.0; first(intervals.end - 1) + degree + 1 - start];
            for interval in intervals {
                let offset = first(interval);
                for (k, weight) in over_interval((interval - offset) as f64, degree).into_iter().enumerate() {
                    weights[offset - start + k] += weight / parts as f64;
                }
            }
            (start - points.start, weights)
        };
        Self { bins: bins.map(of_bin).collect(), points: points.len() }
    }

    /// The averages over the bins of the line whose value at its `k`th known point is `value(k)`.
    fn of(&self, value: impl Fn(usize) -> f64) -> impl Iterator<Item = f64> {
        let of_bin = move |start: usize, weights: &[f64]| -> f64 {
            weights.iter().enumerate().map(|(k, weight)| weight * value(start + k)).sum()
        };
        self.bins.iter().map(move |(start, weights)| of_bin(*start, weights))
    }
}

/// Integrals from `low` to `low + 1` of the polynomials of degree `degree` that are 1 at one of the points 0, 1, ...
/// and 0 at the others.
fn over_interval(low: f64, degree: usize) -> Vec<f64> {
    let basis = |k: usize, x: f64| -> f64 {
        (0..=degree).filter(|&j| j != k).map(|j| (x - j as f64) / (k as f64 - j as f64)).product()
    };
    let rule = gauss(low, low + 1.0);
    (0..=degree).map(|k| rule.iter().map(|&(x, weight)| weight * basis(k, x)).sum()).collect()
}

/// The averages over all bins of the values at the points of a lattice, rows outermost.
pub(super) fn averages(values: &[f64], rows: &Averaging, columns: &Averaging) -> Vec<f64> {
    let along: Vec<Vec<f64>> = values.chunks(columns.points).map(|row| columns.of(|k| row[k]).collect()).collect();
    let across: Vec<Vec<f64>> = (0..columns.bins.len()).map(|bin| rows.of(|row| along[row][bin]).collect()).collect();
    (0..rows.bins.len()).flat_map(|row| across.iter().map(move |column| column[row])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Averages of `cos` from its antiderivative; of a polynomial they are exact.
    #[test]
    fn averages_are_those_of_the_antiderivative() {
        for (bins, parts, degree, tolerance) in [(9, 1, 7, 2e-6), (9, 2, 7, 2e-8), (3, 4, 3, 6e-5), (2, 1, 7, 6e-2)] {
            let width = 3.0 / bins as f64;
            let edge = |k: usize| width * k as f64;
            // The first bin has no points beyond its lower edge, the last one has two beyond its upper edge.
            let line = Averaging::new(0..bins, parts, degree, 0..bins * parts + 3);
            let found: Vec<f64> = line.of(|k| (width / parts as f64 * k as f64).cos()).collect();
            for (bin, found) in found.iter().enumerate() {
                let right = (edge(bin + 1).sin() - edge(bin).sin()) / width;
                assert!((found - right).abs() < tolerance, "{bins} {parts} {degree}: {:e}", found - right);
            }
        }
        // Bins 2 and 3 of lines of which the points before 3 and 1 are unknown.
        let (rows, columns) = (Averaging::new(2..4, 2, 3, 3..10), Averaging::new(2..4, 1, 5, 1..7));
        let value = |i: usize, j: usize| (i as f64).powi(3) * (j as f64).powi(2);
        let values: Vec<f64> = (3..10).flat_map(|i| (1..7).map(move |j| value(i, j))).collect();
        for (bin, found) in averages(&values, &rows, &columns).into_iter().enumerate() {
            let (i, j) = ((2 + bin / 2) as f64, (2 + bin % 2) as f64);
            let mean_of_cubes = ((2.0 * i + 2.0).powi(4) - (2.0 * i).powi(4)) / 8.0;
            let right = mean_of_cubes * ((j + 1.0).powi(3) - j.powi(3)) / 3.0;
            assert!((found - right).abs() < 1e-11 * right, "{bin}: {found} {right}");
        }
    }
}

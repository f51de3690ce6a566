//! Directions of unit length in which a linear map, a quadratic form or a quadratic map is largest.

use nalgebra::DMatrix;

/// A direction of unit length and how large the measure is in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preferred<const N: usize> {
    /// The direction; its sign has no meaning.
    pub direction: [f64; N],
    /// The measure.
    pub measure: f64,
}

/// The eigenvectors of a symmetric matrix with their eigenvalues, the largest first. Those of a matrix that is not
/// finite are the axes, at 0.
pub(super) fn eigenvectors<const N: usize>(matrix: &[[f64; N]; N]) -> [Preferred<N>; N] {
    let axis = |k: usize| Preferred { direction: std::array::from_fn(|j| f64::from(j == k)), measure: 0.0 };
    if !matrix.as_flattened().iter().all(|entry| entry.is_finite()) {
        return std::array::from_fn(axis);
    }
    let found = DMatrix::from_fn(N, N, |i, j| 0.5 * (matrix[i][j] + matrix[j][i])).symmetric_eigen();
    let mut order: [usize; N] = std::array::from_fn(|k| k);
    order.sort_by(|&a, &b| found.eigenvalues[b].total_cmp(&found.eigenvalues[a]));
    order.map(|k| Preferred {
        direction: std::array::from_fn(|j| found.eigenvectors[(j, k)]),
        measure: found.eigenvalues[k],
    })
}

/// Where `x^T A x` is largest on the unit sphere, with its square root.
pub(super) fn largest_form<const N: usize>(matrix: &[[f64; N]; N]) -> Preferred<N> {
    let first = eigenvectors(matrix)[0];
    Preferred { measure: first.measure.max(0.0).sqrt(), ..first }
}

/// `A^T A` of a matrix that is given by its columns, which may have any number of rows.
pub(super) fn gram<'a, const N: usize>(column: impl Fn(usize) -> &'a [f64]) -> [[f64; N]; N] {
    let product = |i: usize, j: usize| column(i).iter().zip(column(j)).map(|(a, b)| a * b).sum();
    std::array::from_fn(|i| std::array::from_fn(|j| product(i, j)))
}

/// Where `|H(x, x)|` is largest on the unit sphere, by ascents from many directions.
///
/// The ascent is the shifted power method for symmetric tensors (Kolda & Mayo, SIAM J. Matrix Anal. Appl. 32(4), 2011):
/// with a shift of three times the squared Frobenius norm no step goes down.
pub(super) fn longest_bend<const N: usize>(second: &[[[f64; N]; N]; N]) -> Preferred<N> {
    let square: f64 = second.as_flattened().as_flattened().iter().map(|entry| entry * entry).sum();
    let none = Preferred { direction: std::array::from_fn(|k| f64::from(k == 0)), measure: 0.0 };
    if !(square > 0.0 && square.is_finite()) {
        return none;
    }
    let best = starts::<N>().map(|start| ascended(second, start, 3.0 * square));
    best.fold(none, |best, found| if found.measure > best.measure { found } else { best })
}

/// Directions whose components are -1, 0 or 1 before they are scaled, without those that are opposite to another.
fn starts<const N: usize>() -> impl Iterator<Item = [f64; N]> {
    let digits =
        |number: usize| -> [f64; N] { std::array::from_fn(|k| (number / 3usize.pow(k as u32) % 3) as f64 - 1.0) };
    let middle = (3usize.pow(N as u32) - 1) / 2;
    (middle + 1..3usize.pow(N as u32)).map(digits).filter_map(unit)
}

/// The vector at unit length, if it has a direction.
pub(super) fn unit<const N: usize>(vector: [f64; N]) -> Option<[f64; N]> {
    let length = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
    (length > 0.0 && length.is_finite()).then(|| vector.map(|x| x / length))
}

fn ascended<const N: usize>(second: &[[[f64; N]; N]; N], start: [f64; N], shift: f64) -> Preferred<N> {
    const ROUNDS: usize = 3_000;
    const SETTLED: f64 = 1e-14;
    let along =
        |x: &[f64; N], i: usize| -> [f64; N] { std::array::from_fn(|v| (0..N).map(|j| second[i][j][v] * x[j]).sum()) };
    let bend = |rows: &[[f64; N]; N], x: &[f64; N]| -> [f64; N] {
        std::array::from_fn(|v| (0..N).map(|i| rows[i][v] * x[i]).sum())
    };
    let mut x = start;
    for _ in 0..ROUNDS {
        let rows: [[f64; N]; N] = std::array::from_fn(|i| along(&x, i));
        let image = bend(&rows, &x);
        let slope = |i: usize| -> f64 { (0..N).map(|v| image[v] * rows[i][v]).sum() };
        let Some(next) = unit(std::array::from_fn(|i| slope(i) + shift * x[i])) else { break };
        let moved: f64 = (0..N).map(|i| (next[i] - x[i]).powi(2)).sum();
        x = next;
        if moved < SETTLED * SETTLED {
            break;
        }
    }
    let rows: [[f64; N]; N] = std::array::from_fn(|i| along(&x, i));
    Preferred { direction: x, measure: bend(&rows, &x).iter().map(|b| b * b).sum::<f64>().sqrt() }
}

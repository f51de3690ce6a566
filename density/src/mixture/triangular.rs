//! The lower triangular square root of a covariance, and its inverse applied to a vector.

/// The lower triangular square root of a covariance that has a positive diagonal.
pub(super) fn cholesky<const N: usize>(covariance: [[f64; N]; N]) -> [[f64; N]; N] {
    let mut root = [[0.0; N]; N];
    for row in 0..N {
        for column in 0..=row {
            let before: f64 = (0..column).map(|k| root[row][k] * root[column][k]).sum();
            let rest = covariance[row][column] - before;
            // What rounding has taken from the diagonal is given back.
            let least = 1e-14 * covariance[row][row];
            root[row][column] = if row == column { rest.max(least).sqrt() } else { rest / root[column][column] };
        }
    }
    root
}

/// The solution of `root x = vector`.
pub(super) fn solved<const N: usize>(root: &[[f64; N]; N], vector: [f64; N]) -> [f64; N] {
    let mut x = [0.0; N];
    for row in 0..N {
        let known: f64 = (0..row).map(|k| root[row][k] * x[k]).sum();
        x[row] = (vector[row] - known) / root[row][row];
    }
    x
}

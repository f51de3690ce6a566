//! A Gaussian over any number of variables, given by its mean and covariance.

use std::fmt;

/// A Gaussian over `N` variables. A variable on a circle is treated as an unbounded one here.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaussian<const N: usize> {
    /// Mean.
    pub mean: [f64; N],
    /// Lower triangular square root `S` of the covariance `S S^T`, row by row.
    root: [[f64; N]; N],
}

/// A matrix that is not a covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoCovariance {
    /// The first variable that has no variance of its own, given those before it.
    pub variable: usize,
}

impl std::error::Error for NoCovariance {}

impl fmt::Display for NoCovariance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { variable } = self;
        write!(
            f,
            "variable number {variable} has no variance left, given those before it: a covariance is symmetric and positive definite"
        )
    }
}

impl<const N: usize> Gaussian<N> {
    /// From the mean and the covariance, of which only the lower triangle is read.
    ///
    /// # Errors
    /// [`NoCovariance`] if the covariance is not positive definite.
    pub fn new(mean: [f64; N], covariance: [[f64; N]; N]) -> Result<Self, NoCovariance> {
        let mut root = [[0.0; N]; N];
        for row in 0..N {
            for column in 0..=row {
                let before: f64 = (0..column).map(|k| root[row][k] * root[column][k]).sum();
                let rest = covariance[row][column] - before;
                root[row][column] = if row == column { rest.sqrt() } else { rest / root[column][column] };
            }
            if !(root[row][row] > 0.0 && root[row][row].is_finite()) {
                return Err(NoCovariance { variable: row });
            }
        }
        Ok(Self { mean, root })
    }

    /// From the mean and the covariance, where a variable whose variance is 0 is certain.
    ///
    /// # Errors
    /// [`NoCovariance`] if the covariance of the others is not positive definite, or if a certain variable has a
    /// covariance.
    pub fn with_certain_variables(mean: [f64; N], covariance: [[f64; N]; N]) -> Result<Self, NoCovariance> {
        let is_certain = |k: usize| covariance[k][k] == 0.0;
        let depends = |k: usize| (0..N).any(|j| covariance[k.max(j)][k.min(j)] != 0.0);
        if let Some(variable) = (0..N).find(|&k| is_certain(k) && depends(k)) {
            return Err(NoCovariance { variable });
        }
        let filled = std::array::from_fn(|a| {
            std::array::from_fn(|b| if a == b && is_certain(a) { 1.0 } else { covariance[a][b] })
        });
        let mut gaussian = Self::new(mean, filled)?;
        (0..N).filter(|&k| is_certain(k)).for_each(|k| gaussian.root[k][k] = 0.0);
        Ok(gaussian)
    }

    /// A Gaussian of independent variables, from their standard deviations.
    pub fn independent(mean: [f64; N], sigmas: [f64; N]) -> Self {
        let mut root = [[0.0; N]; N];
        (0..N).for_each(|k| root[k][k] = sigmas[k]);
        Self { mean, root }
    }

    /// From the mean and a lower triangular square root `S` of the covariance `S S^T`, row by row.
    pub(crate) fn from_root(mean: [f64; N], root: [[f64; N]; N]) -> Self {
        Self { mean, root }
    }

    /// The point at the standardised coordinates `z`: `m + S z`.
    pub fn point(&self, standard: [f64; N]) -> [f64; N] {
        std::array::from_fn(|row| (0..=row).fold(self.mean[row], |sum, k| sum + standard[k] * self.root[row][k]))
    }

    /// The standardised coordinates of a point, the inverse of [`Gaussian::point`].
    pub fn standardise(&self, point: &[f64; N]) -> [f64; N] {
        let mut standard = [0.0; N];
        for row in 0..N {
            let before: f64 = (0..row).map(|k| standard[k] * self.root[row][k]).sum();
            standard[row] = (point[row] - self.mean[row] - before) / self.root[row][row];
        }
        standard
    }

    /// Standard deviation of variable `k`.
    pub fn deviation(&self, k: usize) -> f64 {
        self.root[k].iter().map(|s| s * s).sum::<f64>().sqrt()
    }

    /// Logarithm of the density at a point.
    pub fn log_density(&self, point: &[f64; N]) -> f64 {
        let square: f64 = self.standardise(point).iter().map(|z| z * z).sum();
        let volume: f64 = (0..N).map(|k| self.root[k][k].ln()).sum();
        -0.5 * (square + N as f64 * std::f64::consts::TAU.ln()) - volume
    }

    /// Column `k` of the square root `S`: a step of one standard deviation.
    pub fn direction(&self, k: usize) -> [f64; N] {
        std::array::from_fn(|row| self.root[row][k])
    }

    /// The same with another mean, and with the step along direction `k` made `factor` times as long.
    pub fn narrowed(&self, mean: [f64; N], k: usize, factor: f64) -> Self {
        let mut root = self.root;
        root.iter_mut().for_each(|row| row[k] *= factor);
        Self { mean, root }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_square_root_of_a_covariance_multiplies_back_to_it() {
        let covariance = [[4.0, 1.0, -0.5], [1.0, 2.0, 0.3], [-0.5, 0.3, 1.0]];
        let gaussian = Gaussian::new([0.0; 3], covariance).unwrap();
        for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
            let product: f64 = (0..3).map(|k| gaussian.direction(k)[i] * gaussian.direction(k)[j]).sum();
            assert!((product - covariance[i][j]).abs() < 1e-15);
        }
    }

    #[test]
    fn a_certain_variable_stays_where_it_is_and_the_others_keep_their_covariance() {
        let covariance = [[4.0, 0.0, 1.0], [0.0, 0.0, 0.0], [1.0, 0.0, 2.0]];
        let gaussian = Gaussian::with_certain_variables([1.0, 2.0, 3.0], covariance).unwrap();
        assert_eq!(gaussian.point([5.0, -7.0, 0.0])[1], 2.0);
        let product: f64 = (0..3).map(|k| gaussian.direction(k)[0] * gaussian.direction(k)[2]).sum();
        assert!((product - 1.0).abs() < 1e-15);
        let depends = [[1.0, 0.0], [0.5, 0.0]];
        assert_eq!(Gaussian::with_certain_variables([0.0; 2], depends), Err(NoCovariance { variable: 1 }));
    }

    #[test]
    fn standardising_undoes_the_point() {
        let covariance = [[4.0, 1.0, -0.5], [1.0, 2.0, 0.3], [-0.5, 0.3, 1.0]];
        let gaussian = Gaussian::new([0.3, -2.0, 5.0], covariance).unwrap();
        let standard = [0.5, -2.0, 3.0];
        let found = gaussian.standardise(&gaussian.point(standard));
        assert!((0..3).all(|k| (found[k] - standard[k]).abs() < 1e-14));
    }

    #[test]
    fn a_matrix_that_is_no_covariance_is_refused_with_the_variable() {
        assert_eq!(Gaussian::new([0.0; 2], [[1.0, 0.0], [2.0, 1.0]]), Err(NoCovariance { variable: 1 }));
        assert_eq!(Gaussian::new([0.0; 2], [[f64::NAN, 0.0], [0.0, 1.0]]), Err(NoCovariance { variable: 0 }));
    }
}

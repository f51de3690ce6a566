//! What the flow does near the mean of a Gaussian: all that a criterion looks at.
//!
//! With `x = m + S z`, `S S^T = P`, the flow `g` has in standardised coordinates the derivatives
//!
//! ```text
//! J = G S,   H_ij = Σ_kl G²_kl S_ki S_lj,       G, G² the first and second derivatives of g at m
//! ```
//!
//! They are taken by differences over [`STEP`] standard deviations. Sigma points further out give what criteria by
//! sigma points compare them with.

use super::super::differences::{Differences, offset, places, points};
use super::super::triangular::{cholesky, solved};
use super::super::unscented::Unscented;
use super::spectral::{Preferred, eigenvectors, gram, unit};
use crate::gaussian::Gaussian;
use crate::model::Variable;

/// Distance over which derivatives are taken, in standard deviations. With orbits good to 1e-12 second derivatives of
/// clouds 0.01 wide are then good to about 1e-6 by rounding, and to 3e-5 of the fourth derivatives.
const STEP: f64 = 0.02;

/// Where the flow is looked at.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Probe<const N: usize> {
    /// The principal axes of the covariance in standardised coordinates, the longest first, with its eigenvalues.
    principal: [Preferred<N>; N],
    /// The points in standardised coordinates.
    pub places: Vec<[f64; N]>,
}

impl<const N: usize> Probe<N> {
    pub fn new(initial: &Gaussian<N>) -> Self {
        let steps: [[f64; N]; N] = std::array::from_fn(|k| initial.direction(k));
        let principal = eigenvectors(&gram(|k| &steps[k]));
        let distance = distance(N);
        let axis = |k: usize| -> [f64; N] { std::array::from_fn(|j| f64::from(j == k)) };
        let pair = |axis: [f64; N]| [axis.map(|a| distance * a), axis.map(|a| -distance * a)];
        let far = (0..N).flat_map(|k| pair(axis(k)));
        let on_principal = (0..N).flat_map(|k| pair(principal[k].direction));
        let places = places(STEP).into_iter().chain(far).chain(on_principal).collect();
        Self { principal, places }
    }
}

/// Distance of the sigma points from the mean in standard deviations, that of the default transform.
fn distance(n: usize) -> f64 {
    Unscented::default().distance_squared_in(n).sqrt()
}

/// The flow near the mean of a Gaussian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LocalFlow<const N: usize> {
    /// The columns of `S`.
    steps: [[f64; N]; N],
    /// The columns of `J`.
    pub slopes: [[f64; N]; N],
    /// `H_ij`
    pub second: [[[f64; N]; N]; N],
    /// The columns of `J` by statistical linearisation: half the differences of opposite sigma points, per standard
    /// deviation.
    pub secants: [[f64; N]; N],
    /// The principal axes in standardised coordinates, with the eigenvalues of the covariance.
    pub principal: [Preferred<N>; N],
    /// `x_+ + x_- - 2 x_0` of the sigma points on the principal axes.
    pub principal_bends: [[f64; N]; N],
}

impl<const N: usize> LocalFlow<N> {
    /// From the variables of the probe's points, carried by the flow.
    pub fn new(initial: &Gaussian<N>, variables: &[Variable], probe: &Probe<N>, carried: &[[f64; N]]) -> Self {
        let Differences { slopes, second } = Differences::new(variables, carried, STEP);
        let far = |k: usize| [0, 1].map(|side| offset(variables, &carried[0], &carried[points(N) + 2 * k + side]));
        let secant = |k: usize| -> [f64; N] {
            let [plus, minus] = far(k);
            std::array::from_fn(|v| (plus[v] - minus[v]) / (2.0 * distance(N)))
        };
        let bend = |k: usize| -> [f64; N] {
            let [plus, minus] = far(N + k);
            std::array::from_fn(|v| plus[v] + minus[v])
        };
        Self {
            steps: std::array::from_fn(|k| initial.direction(k)),
            slopes,
            second,
            secants: std::array::from_fn(secant),
            principal: probe.principal,
            principal_bends: std::array::from_fn(bend),
        }
    }

    /// The columns of `S^{-1}`: the steps in standardised coordinates that change one variable by one.
    fn inverse(&self) -> [[f64; N]; N] {
        let rows: [[f64; N]; N] = std::array::from_fn(|v| std::array::from_fn(|k| self.steps[k][v]));
        std::array::from_fn(|v| solved(&rows, std::array::from_fn(|k| f64::from(k == v))))
    }

    /// The columns of `G`.
    pub fn plain_slopes(&self) -> [[f64; N]; N] {
        self.inverse().map(|z| std::array::from_fn(|v| (0..N).map(|i| self.slopes[i][v] * z[i]).sum()))
    }

    /// `G²_kl`
    pub fn plain_second(&self) -> [[[f64; N]; N]; N] {
        let steps = self.inverse();
        let entry = |k: usize, l: usize, v: usize| -> f64 {
            (0..N).map(|i| (0..N).map(|j| steps[k][i] * steps[l][j] * self.second[i][j][v]).sum::<f64>()).sum()
        };
        std::array::from_fn(|k| std::array::from_fn(|l| std::array::from_fn(|v| entry(k, l, v))))
    }

    /// A direction in the variables, in standardised coordinates.
    pub fn standardised(&self, Preferred { direction, measure }: Preferred<N>) -> Preferred<N> {
        let inverse = self.inverse();
        let standard = std::array::from_fn(|i| (0..N).map(|v| inverse[v][i] * direction[v]).sum());
        Preferred { direction: unit(standard).unwrap_or(direction), measure }
    }

    /// `S M S^T` of a matrix in standardised coordinates.
    pub fn in_variables(&self, matrix: &[[f64; N]; N]) -> [[f64; N]; N] {
        let entry = |a: usize, b: usize| -> f64 {
            (0..N).map(|i| (0..N).map(|j| self.steps[i][a] * matrix[i][j] * self.steps[j][b]).sum::<f64>()).sum()
        };
        std::array::from_fn(|a| std::array::from_fn(|b| entry(a, b)))
    }

    /// Turns a change of the variables after the flow into standard deviations of the linear prediction: a
    /// multiplication by `S_z^{-1}`, where `S_z S_z^T = P_z = J J^T`.
    pub fn whitening(&self) -> impl Fn([f64; N]) -> [f64; N] + use<N> {
        let mut predicted = [[0.0; N]; N];
        for slope in self.slopes {
            for (a, row) in predicted.iter_mut().enumerate() {
                row.iter_mut().enumerate().for_each(|(b, entry)| *entry += slope[a] * slope[b]);
            }
        }
        (0..N).for_each(|v| predicted[v][v] += f64::MIN_POSITIVE);
        let root = cholesky(predicted);
        move |vector| solved(&root, vector)
    }
}

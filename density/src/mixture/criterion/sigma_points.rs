//! Criteria that compare sigma points with the mean, or with the derivatives there.

use super::local_flow::LocalFlow;
use super::spectral::{Preferred, gram, largest_form};

/// The principal axis on which the sigma points are furthest from a line: `max_k |x_{+k} + x_{-k} - 2 x_0|/sqrt(2)`.
pub(super) fn alodt<const N: usize>(flow: &LocalFlow<N>) -> Preferred<N> {
    let deviation = |k: usize| (0.5 * flow.principal_bends[k].iter().map(|bend| bend * bend).sum::<f64>()).sqrt();
    let along = |k: usize| Preferred { direction: flow.principal[k].direction, measure: deviation(k) };
    (1..N).map(along).fold(along(0), |best, found| if found.measure > best.measure { found } else { best })
}

/// The columns of `(G_SL - G) S`.
fn difference<const N: usize>(flow: &LocalFlow<N>) -> [[f64; N]; N] {
    std::array::from_fn(|k| std::array::from_fn(|v| flow.secants[k][v] - flow.slopes[k][v]))
}

/// `max |(G_SL - G) x|` over `x^T P^{-1} x = 1`.
pub(super) fn sadl<const N: usize>(flow: &LocalFlow<N>) -> Preferred<N> {
    let difference = difference(flow);
    largest_form(&gram(|k| &difference[k]))
}

/// `max |(G_SL - G) x|` in the norm of `P_z^{-1}` over `x^T P^{-1} x = 1`.
pub(super) fn wussadl<const N: usize>(flow: &LocalFlow<N>) -> Preferred<N> {
    let difference = difference(flow).map(flow.whitening());
    largest_form(&gram(|k| &difference[k]))
}

//! Criteria that look at the covariance and at the first derivatives of the flow.

use super::local_flow::LocalFlow;
use super::spectral::{Preferred, gram, largest_form};

/// `max |x|` over `x^T P^{-1} x = 1`: the longest principal axis.
pub(super) fn variance<const N: usize>(flow: &LocalFlow<N>) -> Preferred<N> {
    let Preferred { direction, measure } = flow.principal[0];
    Preferred { direction, measure: measure.max(0.0).sqrt() }
}

/// `max |G x|` over `|x| = 1`.
pub(super) fn fos<const N: usize>(flow: &LocalFlow<N>) -> Preferred<N> {
    let slopes = flow.plain_slopes();
    flow.standardised(largest_form(&gram(|k| &slopes[k])))
}

/// `max |G x|` over `x^T P^{-1} x = 1`.
pub(super) fn usfos<const N: usize>(flow: &LocalFlow<N>) -> Preferred<N> {
    largest_form(&gram(|k| &flow.slopes[k]))
}

/// `max E[(u^T x)² |G u|²]` over `|x| = 1`, `u` normal with the covariance `P`; the fourth moments of a normal make of
/// it `S (tr(J^T J) + 2 J^T J) S^T`.
pub(super) fn safos<const N: usize>(flow: &LocalFlow<N>) -> Preferred<N> {
    let gram: [[f64; N]; N] = gram(|k| &flow.slopes[k]);
    let trace: f64 = (0..N).map(|k| gram[k][k]).sum();
    let moment = std::array::from_fn(|i| std::array::from_fn(|j| 2.0 * gram[i][j] + if i == j { trace } else { 0.0 }));
    flow.standardised(largest_form(&flow.in_variables(&moment)))
}

//! Criteria that look at the second derivatives of the flow.
//!
//! They differ in three choices: whether the bend along a direction counts (stretching), all of the change of the first
//! derivatives along it (linearisation change), or an average over all directions weighed towards it (spherical
//! average); whether a direction is as long as its variables say or as the initial covariance says
//! (uncertainty-scaled); and whether bends are measured in the units of the variables or in standard deviations of the
//! linear prediction (whitened).

use super::local_flow::LocalFlow;
use super::spectral::{Preferred, gram, largest_form, longest_bend};

type Tensor<const N: usize> = [[[f64; N]; N]; N];

fn mapped<const N: usize>(second: &Tensor<N>, change: impl Fn([f64; N]) -> [f64; N]) -> Tensor<N> {
    second.map(|row| row.map(&change))
}

/// `max |H(x)|` in the Frobenius norm over `|x| = 1`.
fn linearisation_change<const N: usize>(second: &Tensor<N>) -> Preferred<N> {
    largest_form(&gram(|k| second[k].as_flattened()))
}

/// `E[(z^T A z)² z z^T] = tr² A + 2 tr A² + 4 A tr A + 8 A²` of a standard normal `z` and a symmetric matrix `A`.
fn sixth_moment<const N: usize>(a: &[[f64; N]; N]) -> [[f64; N]; N] {
    let square: [[f64; N]; N] = gram(|k| &a[k]);
    let trace: f64 = (0..N).map(|k| a[k][k]).sum();
    let even = trace * trace + 2.0 * (0..N).map(|k| square[k][k]).sum::<f64>();
    let entry = |i: usize, j: usize| f64::from(i == j) * even + 4.0 * trace * a[i][j] + 8.0 * square[i][j];
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}

/// `max E[(u^T x)² |G² u²|²]` over `|x| = 1`, with `u = S z`.
fn spherical_average<const N: usize>(flow: &LocalFlow<N>, second: &Tensor<N>) -> Preferred<N> {
    let of_variable = |v: usize| sixth_moment(&second.map(|row| row.map(|vector| vector[v])));
    let moments: [[[f64; N]; N]; N] = std::array::from_fn(of_variable);
    let sum = |i: usize, j: usize| moments.iter().map(|moment| moment[i][j]).sum();
    let moment = std::array::from_fn(|i| std::array::from_fn(|j| sum(i, j)));
    flow.standardised(largest_form(&flow.in_variables(&moment)))
}

/// `max |G² x²|` over `|x| = 1`.
pub(super) fn sos<const N: usize>(flow: &LocalFlow<N>) -> Preferred<N> {
    flow.standardised(longest_bend(&flow.plain_second()))
}

/// `max |G² x²|` in the norm of `P_z^{-1}` over `x^T P^{-1} x = 1`.
pub(super) fn wussos<const N: usize>(flow: &LocalFlow<N>) -> Preferred<N> {
    longest_bend(&mapped(&flow.second, flow.whitening()))
}

/// `max |G² x|` in the Frobenius norm over `|x| = 1`.
pub(super) fn solc<const N: usize>(flow: &LocalFlow<N>) -> Preferred<N> {
    flow.standardised(linearisation_change(&flow.plain_second()))
}

/// `max |G²(x) S|` in the Frobenius norm over `x^T P^{-1} x = 1`.
pub(super) fn ussolc<const N: usize>(flow: &LocalFlow<N>) -> Preferred<N> {
    linearisation_change(&flow.second)
}

/// `max |S_z^{-1} G²(x) S|` in the Frobenius norm over `x^T P^{-1} x = 1`.
pub(super) fn wussolc<const N: usize>(flow: &LocalFlow<N>) -> Preferred<N> {
    linearisation_change(&mapped(&flow.second, flow.whitening()))
}

/// The spherical average of `|G² u²|²`.
pub(super) fn sasos<const N: usize>(flow: &LocalFlow<N>) -> Preferred<N> {
    spherical_average(flow, &flow.second)
}

/// The spherical average of `|G² u²|²` in the norm of `P_z^{-1}`.
pub(super) fn wsasos<const N: usize>(flow: &LocalFlow<N>) -> Preferred<N> {
    spherical_average(flow, &mapped(&flow.second, flow.whitening()))
}

//! First and second differences of the flow about a point of a Gaussian, in standard deviations along axes of any
//! orientation.
//!
//! Points at the distance `d` along each axis and along each diagonal of two axes give
//!
//! ```text
//! a_i = (x_{+i} - x_{-i})/(2 d),   H_ii = (x_{+i} + x_{-i} - 2 x_0)/d²,   H_ij from the diagonal of i and j
//! ```
//!
//! For a quadratic flow these are the derivatives themselves, whatever `d` is.

use crate::angle::nearest;
use crate::model::Variable;

/// Number of points: the centre, and two along each axis and each diagonal.
pub(super) const fn points(n: usize) -> usize {
    1 + n * (n + 1)
}

/// The places of these points along the axes: those on the axes first, as sigma points are placed, then those on the
/// diagonals.
pub(super) fn places<const N: usize>(distance: f64) -> Vec<[f64; N]> {
    let on = |axes: &[usize], sign: f64| -> [f64; N] {
        let step = sign * distance / (axes.len() as f64).sqrt();
        std::array::from_fn(|k| if axes.contains(&k) { step } else { 0.0 })
    };
    let axes = (0..N).flat_map(|i| [on(&[i], 1.0), on(&[i], -1.0)]);
    let diagonals = pairs::<N>().flat_map(|(i, j)| [on(&[i, j], 1.0), on(&[i, j], -1.0)]);
    [[0.0; N]].into_iter().chain(axes).chain(diagonals).collect()
}

/// All pairs of two axes.
pub(super) fn pairs<const N: usize>() -> impl Iterator<Item = (usize, usize)> {
    (0..N).flat_map(|i| (i + 1..N).map(move |j| (i, j)))
}

/// How far the variables of a point are from those of another, angles the short way round.
pub(super) fn offset<const N: usize>(variables: &[Variable], from: &[f64; N], to: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|v| match variables[v].is_circle() {
        true => nearest(to[v], from[v]) - from[v],
        false => to[v] - from[v],
    })
}

/// The differences of the flow; the last index is that of the variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Differences<const N: usize> {
    /// `a_i`
    pub slopes: [[f64; N]; N],
    /// `H_ij`
    pub second: [[[f64; N]; N]; N],
}

impl<const N: usize> Differences<N> {
    /// From the variables of the points at [`places`], carried by the flow.
    pub fn new(variables: &[Variable], carried: &[[f64; N]], distance: f64) -> Self {
        let pair = |k: usize| [1 + 2 * k, 2 + 2 * k].map(|p| offset(variables, &carried[0], &carried[p]));
        let slope = |k: usize| -> [f64; N] {
            let [plus, minus] = pair(k);
            std::array::from_fn(|v| (plus[v] - minus[v]) / (2.0 * distance))
        };
        let bend = |k: usize| -> [f64; N] {
            let [plus, minus] = pair(k);
            std::array::from_fn(|v| (plus[v] + minus[v]) / (distance * distance))
        };
        let along: [[f64; N]; N] = std::array::from_fn(bend);
        let mut second = [[[0.0; N]; N]; N];
        (0..N).for_each(|i| second[i][i] = along[i]);
        for (k, (i, j)) in pairs::<N>().enumerate() {
            let diagonal = bend(N + k);
            let twist = std::array::from_fn(|v| diagonal[v] - 0.5 * (along[i][v] + along[j][v]));
            (second[i][j], second[j][i]) = (twist, twist);
        }
        Self { slopes: std::array::from_fn(slope), second }
    }
}

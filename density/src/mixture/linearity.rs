//! How far the flow over a component is from linear, which says when to distrust a mixture's density.
//!
//! Over a component the unscented transform and the linear prediction differ by the bends `b_i` of the sigma points;
//! `b_i` is half the sum of the pair of offsets along direction `i`. The linear prediction of the covariance is
//! `P_lin = Σ a_i a_i^T/(n + zeta)`, with `a_i` half the difference of the pair. The measure is the shift of the mean
//! between the two predictions, direction by direction, in standard deviations of the linear prediction:
//!
//! ```text
//! D_c = Σ_i sqrt(b_i^T (P_lin + R)^{-1} b_i)/(n + zeta),      D = Σ_c w_c D_c
//! R = diag((rho sigma_phi)², (rho sigma_e)²)
//! ```
//!
//! with `sigma` the standard deviations of the whole mixture. `R` is what the comparison can resolve: `rho` = 0.02 is
//! about a third of a bin of a grid of 100. Without `R` the measure would condemn differences that nobody can see. An
//! example is the cloud of scenario 2 at 1.5 yr, a curved filament a small fraction of a bin thick: over 1,200
//! components `D` is 10 without `R` and 0.1 with `R`, and the `L1` error of the joint density is 0.017. The same holds
//! for the entropy difference `½ ln(det P/det P_lin)` of DeMars, Bishop & Jah (JGCD 36(4), 2013), which is 2.0 there,
//! and 0.8 in scenario 1 at one year, where `L1` is 0.068.
//!
//! # What a value means
//! Measured over the fourteen snapshots `t > 0` of the three scenarios, with lattices of spacing 0.2, 0.35 and 0.6 and
//! with 39 x 25 components of the splitting library: wherever `D < 0.3`, the `L1` error of the joint density on 100 x
//! 100 bins was below 0.06 (in most snapshots below 0.02); wherever `D > 0.3`, it was above 0.01 and up to 0.66 (at
//! `D` = 2.3). The paper's 39 components along `e` have `D` = 2.2 and 8.0 in scenario 1 at one and two years (`L1`
//! 0.56, 1.01), and 3.5 in scenario 2 at three years (`L1` 1.15).
//!
//! Sigma points on two axes do not see the twist `∂²x/∂p_1∂p_2`. It hardly matters between small components, but `D` is
//! too small for a split along one direction only: 39 components along the direction of strongest nonlinearity had
//! `D` = 0.17 at `L1` = 0.12 (scenario 1, 1.5 yr).

use super::PlanarComponent;
use super::unscented::{Offsets, Stencil, Unscented};
use crate::model::plane::State;

/// Above this `D` the density of a mixture should not be trusted, and a run should say so.
pub const DISTRUST: f64 = 0.3;
/// `rho`, the smallest difference that the comparison can resolve, in standard deviations of the mixture.
pub(super) const RESOLUTION: f64 = 0.02;

/// The linear prediction and the bends of a component.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bends {
    /// `P_lin` as `[phiphi, phie, ee]`.
    pub(super) linear: [f64; 3],
    /// `b_i/(n + zeta)`.
    pub(super) shifts: [[f64; 2]; 2],
}

impl Bends {
    pub(super) fn new(unscented: &Unscented, points: &Stencil<State>) -> Self {
        let offsets = Offsets::from_states(points);
        let share = 1.0 / unscented.distance_squared();
        let [a, b] = [offsets.slope(0), offsets.slope(1)];
        let covariance = |i: usize, j: usize| share * (a[i] * a[j] + b[i] * b[j]);
        let shifts = [0, 1].map(|i| offsets.bend(i).map(|bend| share * bend));
        Self { linear: [covariance(0, 0), covariance(0, 1), covariance(1, 1)], shifts }
    }

    /// `D_c`, with `resolution` the square roots of the diagonal of `R`.
    pub(super) fn disagreement(&self, resolution: [f64; 2]) -> f64 {
        self.length(self.shifts[0], resolution) + self.length(self.shifts[1], resolution)
    }

    /// The length of a shift in standard deviations of the linear prediction, widened by the resolution.
    pub(super) fn length(&self, [phi, e]: [f64; 2], resolution: [f64; 2]) -> f64 {
        let [phi_phi, phi_e, e_e] = self.linear;
        let (phi_phi, e_e) = (phi_phi + resolution[0] * resolution[0], e_e + resolution[1] * resolution[1]);
        let determinant = (phi_phi * e_e - phi_e * phi_e).max(f64::MIN_POSITIVE);
        let square = phi * phi * e_e - 2.0 * phi * e * phi_e + e * e * phi_phi;
        (square.max(0.0) / determinant).sqrt()
    }
}

/// `D_c` of every component: how far apart its unscented and its linear prediction are.
pub(super) fn disagreements(unscented: &Unscented, stencils: &[Stencil<State>], deviations: [f64; 2]) -> Vec<f64> {
    let resolution = deviations.map(|sigma| RESOLUTION * sigma);
    stencils.iter().map(|points| Bends::new(unscented, points).disagreement(resolution)).collect()
}

/// `D` of a mixture.
pub fn mean_disagreement(components: &[PlanarComponent], disagreements: &[f64]) -> f64 {
    let (sum, weight) = components
        .iter()
        .zip(disagreements)
        .fold((0.0, 0.0), |(sum, weight), (component, d)| (sum + component.weight * d, weight + component.weight));
    sum / weight
}

//! The unscented transform: a component's mean and covariance carried by five points.
//!
//! Symmetric extended set (Julier & Uhlmann, Proc. IEEE 92(3), 2004) with `n = 2` dimensions, `S S^T = P`:
//!
//! ```text
//! x_0 = m,   x_{±i} = m ± sqrt(n + zeta) S_i,   i = 1, 2        (Eq. 17)
//! zeta = alpha² (n + beta) - n
//! w_0^m = zeta/(n + zeta),   w_0^P = w_0^m + 1 - alpha² + eta,   w_k = 1/(2 (n + zeta))        (Eq. 19)
//! m(t) = Σ w_k^m x_k(t),     P(t) = Σ w_k^P (x_k(t) - m(t)) (x_k(t) - m(t))^T        (Eq. 18)
//! ```
//!
//! Two misprints of the paper are corrected: the minus points use the same column of `S` as the plus points (Eq. 17),
//! and the outer weights have 1, not `zeta`, in the numerator (Eq. 19; as printed, the weights do not sum to 1).
//!
//! The points are placed in standardised coordinates and moved in the plane `(e sin(phi), e cos(phi))`. A point placed
//! at `e < 0` is the point at `phi + π, |e|`, on the straight line through the origin of that plane; this continues the
//! flow map smoothly to negative `e`. At the end, each point's `phi` is taken on the branch nearest to that of the
//! component's centre. A point that lies more than 0.45 of a turn from the centre, on a line that runs across the
//! origin, counts as a point at negative `e`.

use std::f64::consts::PI;

use super::error::MixtureError;
use super::planar_component::PlanarComponent;
use crate::angle::nearest;
use crate::model::plane::State;

/// Angle \[rad\] from a component's centre beyond which a point on a line through it lies across the origin.
const ACROSS: f64 = 0.9 * PI;
/// Dimensions of the `(phi, e)` plane.
const PLANE: usize = 2;

/// The parameters of Eqs. 17 to 19.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unscented {
    /// Scales the distance of the sigma points from their centre.
    pub alpha: f64,
    /// Shifts that distance (usually called `kappa`).
    pub beta: f64,
    /// Added to the central covariance weight (usually called `beta`).
    pub eta: f64,
}

/// Sigma points of a component: the centre, then plus and minus along the first direction, then along the second.
pub type Stencil<T> = [T; 5];

impl Default for Unscented {
    fn default() -> Self {
        Self::THIRD_ORDER
    }
}

impl Unscented {
    /// The paper's choice below Eqs. 17 and 19.
    pub const PAPER: Self = Self { alpha: 0.8, beta: 0.0, eta: 2.0 };
    /// `n + zeta = 3`: the points carry the Gaussian's moments along each direction to the fifth order, so that the
    /// mean of a flow without mixed fourth derivatives is accurate to fifth order (Julier & Uhlmann 2004, Sect. III).
    pub const THIRD_ORDER: Self = Self { alpha: 1.0, beta: 1.0, eta: 0.0 };

    /// `n + zeta`, the square of the points' distance from their centre in standard deviations, in the plane.
    pub fn distance_squared(&self) -> f64 {
        self.distance_squared_in(PLANE)
    }

    /// `n + zeta` in a given number of dimensions.
    pub fn distance_squared_in(&self, dimensions: usize) -> f64 {
        self.alpha * self.alpha * (dimensions as f64 + self.beta)
    }

    /// Weight of each outer point in the plane.
    pub fn outer_weight(&self) -> f64 {
        self.outer_weight_in(PLANE)
    }

    /// Weight of each outer point in a given number of dimensions.
    pub fn outer_weight_in(&self, dimensions: usize) -> f64 {
        0.5 / self.distance_squared_in(dimensions)
    }

    /// Weight of the centre in the mean, in the plane.
    pub fn central_mean_weight(&self) -> f64 {
        self.central_mean_weight_in(PLANE)
    }

    /// Weight of the centre in the mean, in a given number of dimensions.
    pub fn central_mean_weight_in(&self, dimensions: usize) -> f64 {
        1.0 - dimensions as f64 / self.distance_squared_in(dimensions)
    }

    /// Weight of the centre in the covariance, in the plane.
    pub fn central_covariance_weight(&self) -> f64 {
        self.central_covariance_weight_in(PLANE)
    }

    /// Weight of the centre in the covariance, in a given number of dimensions.
    pub fn central_covariance_weight_in(&self, dimensions: usize) -> f64 {
        self.central_mean_weight_in(dimensions) + 1.0 - self.alpha * self.alpha + self.eta
    }

    /// Whether sigma points can be placed in the plane and variances cannot turn negative.
    ///
    /// # Errors
    /// [`MixtureError::SigmaDistance`], [`MixtureError::CovarianceWeight`].
    pub fn check(&self) -> Result<(), MixtureError> {
        self.check_in(PLANE)
    }

    /// Like [`Unscented::check`], in a given number of dimensions.
    ///
    /// # Errors
    /// As [`Unscented::check`].
    pub fn check_in(&self, dimensions: usize) -> Result<(), MixtureError> {
        let distance_squared = self.distance_squared_in(dimensions);
        if !(distance_squared > 0.0 && distance_squared.is_finite()) {
            return Err(MixtureError::SigmaDistance(distance_squared));
        }
        // At a given shift s of the mean, the variance is least if all outer points are at the same place, and is then
        // s² [(n + zeta - n)²/(n (n + zeta)) + w_0].
        let n = dimensions as f64;
        let weight = self.central_covariance_weight_in(dimensions);
        let least = -(distance_squared - n).powi(2) / (n * distance_squared);
        if weight >= least { Ok(()) } else { Err(MixtureError::CovarianceWeight { weight, least }) }
    }

    /// Eq. 18 for a component's propagated sigma points.
    pub fn transform(&self, weight: f64, points: &Stencil<State>) -> PlanarComponent {
        let centre = (points[0].solar_angle(), points[0].eccentricity());
        let offsets = Offsets::from_states(points);
        let outer = self.outer_weight();
        let shift: [f64; 2] = std::array::from_fn(|axis| outer * offsets.outer.iter().map(|d| d[axis]).sum::<f64>());
        let covariance = |a: usize, b: usize| {
            let spread: f64 = offsets.outer.iter().map(|d| (d[a] - shift[a]) * (d[b] - shift[b])).sum();
            outer * spread + self.central_covariance_weight() * shift[a] * shift[b]
        };
        PlanarComponent {
            weight,
            mean_phi: centre.0 + shift[0],
            mean_e: centre.1 + shift[1],
            var_phi: covariance(0, 0),
            cov_phi_e: covariance(0, 1),
            var_e: covariance(1, 1),
        }
    }
}

/// `(phi, e)` of the outer points relative to the centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Offsets {
    pub(super) outer: [[f64; 2]; 4],
}

/// Whether three points lie on a line rather than on an arc round the origin.
fn is_straight(centre: &State, plus: &State, minus: &State) -> bool {
    const BEND: f64 = 0.25;
    let bend = (plus.x1 + minus.x1 - 2.0 * centre.x1).hypot(plus.x2 + minus.x2 - 2.0 * centre.x2);
    bend < BEND * (plus.x1 - minus.x1).hypot(plus.x2 - minus.x2)
}

impl Offsets {
    pub(super) fn from_states(points: &Stencil<State>) -> Self {
        let (phi, e) = (points[0].solar_angle(), points[0].eccentricity());
        let straight = [0, 1].map(|i| is_straight(&points[0], &points[2 * i + 1], &points[2 * i + 2]));
        let offset = |k: usize| {
            let point = &points[k + 1];
            let (turn, height) = (nearest(point.solar_angle(), phi) - phi, point.eccentricity());
            match straight[k / 2] && turn.abs() > ACROSS {
                true => [nearest(turn + PI, 0.0), -height - e],
                false => [turn, height - e],
            }
        };
        Self { outer: std::array::from_fn(offset) }
    }

    /// Half the difference of the pair of points along direction `i`: the linear part of the flow, times the distance.
    pub(super) fn slope(&self, i: usize) -> [f64; 2] {
        std::array::from_fn(|axis| 0.5 * (self.outer[2 * i][axis] - self.outer[2 * i + 1][axis]))
    }

    /// Half the sum of the pair along direction `i`: zero where the flow is linear.
    pub(super) fn bend(&self, i: usize) -> [f64; 2] {
        std::array::from_fn(|axis| 0.5 * (self.outer[2 * i][axis] + self.outer[2 * i + 1][axis]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sigma points of mean `(phi, e)` and square-root columns `s`, moved by `map`.
    fn moved(
        unscented: Unscented,
        [phi, e]: [f64; 2],
        s: [[f64; 2]; 2],
        map: impl Fn(f64, f64) -> (f64, f64),
    ) -> Stencil<State> {
        let distance = unscented.distance_squared().sqrt();
        let signs: Stencil<[f64; 2]> = [[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]];
        signs.map(|[a, b]| {
            let at = |axis: usize| distance * (a * s[0][axis] + b * s[1][axis]);
            let (phi, e) = map(phi + at(0), e + at(1));
            State::from_polar(phi, e)
        })
    }

    #[test]
    fn weights_of_the_paper_are_those_of_the_corrected_equations() {
        let paper = Unscented::PAPER;
        assert!((paper.central_mean_weight() + 0.5625).abs() < 1e-15);
        assert!((paper.central_covariance_weight() - 1.7975).abs() < 1e-15);
        assert!((paper.outer_weight() - 0.390625).abs() < 1e-15);
        assert!((paper.central_mean_weight() + 4.0 * paper.outer_weight() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_linear_map_moves_mean_and_covariance_exactly_also_across_phi_zero() {
        let s = [[0.1, 0.02], [-0.03, 0.05]];
        let map = |phi: f64, e: f64| (6.2 + 0.7 * phi - 0.4 * e, 0.3 + 0.2 * phi + 0.9 * e);
        let jacobian = [[0.7, -0.4], [0.2, 0.9]];
        let image = s.map(|c| [0, 1].map(|axis: usize| jacobian[axis][0] * c[0] + jacobian[axis][1] * c[1]));
        let expected = |a: usize, b: usize| image[0][a] * image[0][b] + image[1][a] * image[1][b];
        for unscented in [Unscented::PAPER, Unscented::THIRD_ORDER] {
            let component = unscented.transform(0.25, &moved(unscented, [0.02, 0.1], s, map));
            let (phi, e) = map(0.02, 0.1);
            assert_eq!(component.weight, 0.25);
            assert!((component.mean_phi - phi).abs() < 1e-13 && (component.mean_e - e).abs() < 1e-14);
            assert!((component.var_phi - expected(0, 0)).abs() < 1e-14);
            assert!((component.cov_phi_e - expected(0, 1)).abs() < 1e-14);
            assert!((component.var_e - expected(1, 1)).abs() < 1e-14);
        }
    }

    #[test]
    fn third_order_points_give_the_exact_mean_of_a_quadratic_map() {
        let map = |phi: f64, e: f64| (1.0 + phi + 3.0 * (e - 0.4) * (e - 0.4), e + phi * phi);
        let component = Unscented::THIRD_ORDER
            .transform(1.0, &moved(Unscented::THIRD_ORDER, [0.0, 0.4], [[0.1, 0.0], [0.0, 0.05]], map));
        assert!((component.mean_phi - (1.0 + 3.0 * 0.0025)).abs() < 1e-14);
        assert!((component.mean_e - (0.4 + 0.01)).abs() < 1e-14);
        assert!(
            (component.var_e - (0.0025 + 2.0 * 0.01 * 0.01)).abs() < 1e-14,
            "variance of a chi-square: kurtosis is kept"
        );
    }

    #[test]
    fn parameters_that_place_no_points_are_refused() {
        let flat = Unscented { alpha: 0.0, beta: 0.0, eta: 2.0 };
        assert_eq!(flat.check(), Err(MixtureError::SigmaDistance(0.0)));
        assert!(Unscented { alpha: 0.8, beta: 0.0, eta: -9.0 }.check().is_err());
        assert!(Unscented::PAPER.check().is_ok() && Unscented::THIRD_ORDER.check().is_ok());
    }
}

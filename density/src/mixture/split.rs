//! The initial Gaussian as components along one direction or two.
//!
//! In coordinates `(u, v)` standardised by the initial Gaussian, `u` along `phi` and `v` along `e`, that Gaussian is round,
//! so it may be split along any direction `p` and the perpendicular `r`. With a univariate library of means `m_i`, weights
//! `w_i` and deviation `sigma` along each (Eq. 15 for one direction):
//!
//! ```text
//! w_ij = w_i w_j,   m_ij = m_i p + m_j r,   S_ij = [sigma_p p, sigma_r r]
//! ```
//!
//! A component counts if its mean and all its sigma points are inside `|e| < 1` and its mean has `e > 0`; the weights of those
//! that count are scaled to sum to 1, as the initial Gaussian is cut to `0 < e < 1`.

use super::MixtureError;
use super::library::Library;
use super::unscented::{Stencil, Unscented};
use crate::dynamics::State;
use crate::problem::InitialGaussian;

/// Along which line of the initial Gaussian to split.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Direction {
    /// Along `phi`, as the paper's text says.
    SolarAngle,
    /// Along `e`, as the paper's Table 3 was computed.
    Eccentricity,
    /// At this angle from the `phi` axis towards the `e` axis \[rad\], in standardised coordinates.
    Angle(f64),
    /// Where the flow bends most, see [`super::direction::strongest_nonlinearity`].
    StrongestNonlinearity,
}

/// Two perpendicular unit vectors in standardised coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axes {
    cos: f64,
    sin: f64,
}

impl Axes {
    /// The first at `angle` from `u` towards `v` \[rad\]. A quarter turn is kept free of rounding.
    pub(super) fn new(angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        let clean = |x: f64| if x.abs() < 1e-15 { 0.0 } else { x };
        Self { cos: clean(cos), sin: clean(sin) }
    }

    /// `(u, v)` of the point at `p` along the first and `r` along the second.
    pub(super) fn point(&self, [p, r]: [f64; 2]) -> [f64; 2] {
        [p * self.cos - r * self.sin, p * self.sin + r * self.cos]
    }
}

/// The sigma points of all components at `t = 0`.
#[derive(Debug, Clone, PartialEq)]
pub struct SigmaPoints {
    /// The points in the plane of the flow.
    pub states: Vec<State>,
    /// Weights of the components; they sum to 1.
    pub weights: Vec<f64>,
    /// Which points each component has. Components may share points.
    pub stencils: Vec<Stencil<u32>>,
    /// Share of the split Gaussian whose components were left out, as they reach out of `0 < e < 1`.
    pub left_out: f64,
}

impl SigmaPoints {
    /// Scales the weights to sum to 1. `total` is the weight before components were left out.
    pub(super) fn normalised(mut self, total: f64) -> Result<Self, MixtureError> {
        let kept: f64 = self.weights.iter().sum();
        if self.weights.is_empty() || kept.is_nan() || kept <= 0.0 {
            return Err(MixtureError::NothingInside);
        }
        self.weights.iter_mut().for_each(|weight| *weight /= kept);
        self.left_out = (1.0 - kept / total).max(0.0);
        Ok(self)
    }
}

/// The state at standardised `(u, v)`; `None` outside `|e| < 1`. Negative `e` is the point across the origin.
pub(super) fn state(initial: &InitialGaussian, [u, v]: [f64; 2]) -> Option<State> {
    let (phi, e) = initial.point(u, v);
    (e.abs() < 1.0).then(|| State::from_polar(phi, e))
}

/// Whether a component's mean is inside the domain to which the initial Gaussian is cut.
pub(super) fn is_inside(initial: &InitialGaussian, [u, v]: [f64; 2]) -> bool {
    let (_, e) = initial.point(u, v);
    e > 0.0 && e < 1.0
}

/// Splits along the direction at `angle` by the library `along` and perpendicular to it by `across`.
///
/// # Errors
/// [`MixtureError::NothingInside`].
pub fn split(
    initial: &InitialGaussian,
    unscented: &Unscented,
    angle: f64,
    along: &Library,
    across: &Library,
) -> Result<SigmaPoints, MixtureError> {
    let axes = Axes::new(angle);
    let distance = unscented.distance_squared().sqrt();
    let (step_p, step_r) = (distance * along.sigma, distance * across.sigma);
    let mut points = SigmaPoints { states: vec![], weights: vec![], stencils: vec![], left_out: 0.0 };
    for (&p, &weight_p) in along.means.iter().zip(&along.weights) {
        for (&r, &weight_r) in across.means.iter().zip(&across.weights) {
            let stencil = [[p, r], [p + step_p, r], [p - step_p, r], [p, r + step_r], [p, r - step_r]];
            let placed: Option<Vec<State>> = stencil.iter().map(|&at| state(initial, axes.point(at))).collect();
            if let Some(states) = placed.filter(|_| is_inside(initial, axes.point([p, r]))) {
                let first = points.states.len() as u32;
                points.states.extend(states);
                points.stencils.push(std::array::from_fn(|k| first + k as u32));
                points.weights.push(weight_p * weight_r);
            }
        }
    }
    points.normalised(1.0)
}

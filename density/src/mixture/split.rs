//! Splits the initial Gaussian into components along one direction or two.
//!
//! In coordinates `(u, v)` standardised by the initial Gaussian, `u` along `phi` and `v` along `e`, that Gaussian is
//! round, so it may be split along any direction `p` and the perpendicular `r`. With a univariate library of means
//! `m_i`, weights `w_i` and standard deviation `sigma` along each (Eq. 15 for one direction), the components are:
//!
//! ```text
//! w_ij = w_i w_j,   m_ij = m_i p + m_j r,   S_ij = [sigma_p p, sigma_r r]
//! ```
//!
//! The initial Gaussian is cut to `0 < e < 1`. A component that reaches below `e = 0` is replaced by the Gaussian that
//! has the probability, mean and covariance of its part above ([`Axes::cut`]); a component with hardly any probability
//! there is left out. The others count if their means are below `e = 1` and all their sigma points inside `|e| < 1`.
//! The weights of those that count are scaled to sum to 1.

use super::criterion::Criterion;
use super::error::MixtureError;
use super::library::Library;
use super::planar_component::Above;
use super::unscented::{Stencil, Unscented};
use crate::model::plane::State;
use crate::problem::InitialGaussian;

/// The direction along which the initial Gaussian is split.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Direction {
    /// Along `phi`, as the paper's text says.
    SolarAngle,
    /// Along `e`, which gives the numbers of the paper's Table 3.
    Eccentricity,
    /// At this angle from the `phi` axis towards the `e` axis \[rad\], in standardised coordinates.
    Angle(f64),
    /// Along the direction in which the flow bends most, see [`super::direction::strongest_nonlinearity`].
    StrongestNonlinearity,
    /// Along the direction that a criterion prefers, see [`super::criterion`].
    OfCriterion(Criterion),
}

/// Two perpendicular unit vectors in standardised coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axes {
    cos: f64,
    sin: f64,
}

impl Axes {
    /// Axes whose first vector is at `angle` from `u` towards `v` \[rad\]. A quarter turn is kept free of rounding.
    pub(super) fn new(angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        let clean = |x: f64| if x.abs() < 1e-15 { 0.0 } else { x };
        Self { cos: clean(cos), sin: clean(sin) }
    }

    /// `(u, v)` of the point at `p` along the first axis and `r` along the second.
    pub(super) fn point(&self, [p, r]: [f64; 2]) -> [f64; 2] {
        [p * self.cos - r * self.sin, p * self.sin + r * self.cos]
    }
}

/// Distance of the mean from `e = 0`, in standard deviations, beyond which a component is not cut there: the tail left
/// is 1e-3.
const UNCUT: f64 = 3.0;
/// Distance of the mean below `e = 0`, in standard deviations, beyond which a component is left out.
const OUT: f64 = 4.0;

/// A component after the cut at `e = 0`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum CutComponent {
    /// It does not reach `e = 0`.
    Whole,
    /// The share of the component that is above, with the points of its stencil in standardised coordinates `(u, v)`.
    Part(f64, Stencil<[f64; 2]>),
    /// The whole component is below.
    Nothing,
}

impl Axes {
    /// The part above `e = 0` of the component at `at` with standard deviations `sigma`, both along the axes in
    /// standardised coordinates. The sigma points lie `distance` standard deviations from the mean.
    ///
    /// Let `d` be the direction of `e` in the coordinates in which the component is round. The part above is a normal
    /// distribution cut along `d`: its mean moves along `d` and its standard deviation along `d` shrinks by a factor
    /// `c`, so columns `S` become `S (1 - (1 - c) d d^T)`.
    pub(super) fn cut(&self, initial: &InitialGaussian, at: [f64; 2], sigma: [f64; 2], distance: f64) -> CutComponent {
        let [_, v] = self.point(at);
        let (_, e) = initial.point(0.0, v);
        let slope = [self.sin * sigma[0], self.cos * sigma[1]];
        let deviation = slope[0].hypot(slope[1]);
        let height = e / (initial.sigma_e * deviation);
        if height > UNCUT {
            return CutComponent::Whole;
        }
        if height < -OUT {
            return CutComponent::Nothing;
        }
        let part = Above::new(height);
        let d = slope.map(|component| component / deviation);
        let shrink = 1.0 - part.variance.sqrt();
        let round = |offset: [f64; 2]| {
            let along = offset[0] * d[0] + offset[1] * d[1];
            let moved = [0, 1].map(|k| offset[k] + d[k] * (part.mean - shrink * along));
            self.point([0, 1].map(|k| at[k] + sigma[k] * moved[k]))
        };
        let offsets = [[0.0, 0.0], [distance, 0.0], [-distance, 0.0], [0.0, distance], [0.0, -distance]];
        CutComponent::Part(part.share, offsets.map(round))
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
    /// Share of the split Gaussian whose components were left out because they reach out of `0 < e < 1`.
    pub left_out: f64,
}

impl SigmaPoints {
    /// Adds a component with its own sigma points at standardised `(u, v)`, if all of them are inside `|e| < 1`.
    pub(super) fn add(&mut self, initial: &InitialGaussian, weight: f64, stencil: Stencil<[f64; 2]>) {
        let placed: Option<Vec<State>> = stencil.iter().map(|&at| state(initial, at)).collect();
        if let Some(states) = placed.filter(|_| is_inside(initial, stencil[0])) {
            let first = self.states.len() as u32;
            self.states.extend(states);
            self.stencils.push(std::array::from_fn(|k| first + k as u32));
            self.weights.push(weight);
        }
    }

    /// Scales the weights to sum to 1. `total` is the sum of the weights before components were left out.
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

/// Whether a component's mean is inside the range `0 < e < 1` to which the initial Gaussian is cut.
pub(super) fn is_inside(initial: &InitialGaussian, [u, v]: [f64; 2]) -> bool {
    let (_, e) = initial.point(u, v);
    e > 0.0 && e < 1.0
}

/// Splits along the direction at `angle` with the library `along`, and perpendicular to it with `across`.
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
            let whole = [[p, r], [p + step_p, r], [p - step_p, r], [p, r + step_r], [p, r - step_r]];
            let (share, stencil) = match axes.cut(initial, [p, r], [along.sigma, across.sigma], distance) {
                CutComponent::Whole => (1.0, whole.map(|at| axes.point(at))),
                CutComponent::Part(share, stencil) => (share, stencil),
                CutComponent::Nothing => continue,
            };
            points.add(initial, weight_p * weight_r * share, stencil);
        }
    }
    points.normalised(1.0)
}

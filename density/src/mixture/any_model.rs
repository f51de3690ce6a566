//! The unscented transform and the mixture over the variables of any model.
//!
//! This is [`super::unscented`] in any number `n` of variables: a component's mean and covariance are carried by
//! `2n + 1` points (Julier & Uhlmann, Proc. IEEE 92(3), 2004; Eqs. 17 to 19 of Sun et al. 2022),
//!
//! ```text
//! x_0 = m,   x_{±i} = m ± sqrt(n + zeta) S_i,   i = 1 .. n,   S S^T = P
//! ```
//!
//! and the initial Gaussian is split into components along one direction (Eq. 15); [`super::adaptive`] splits it
//! where the flow needs that. Only planar models have lattices, and a cut at `e = 0`.

use rayon::prelude::*;

use super::component::Component;
use super::error::MixtureError;
use super::fifth_degree::{self, Which};
use super::library::Library;
use super::pieces::Piece;
use super::unscented::Unscented;
use crate::angle::{Circular, nearest};
use crate::flow::Flow;
use crate::gaussian::Gaussian;
use crate::model::{Coordinates, Model, Variable};
use crate::variable_moments::VariableMoments;
use crate::wrapped::{self, BeyondCut};

/// The sigma points of a standard normal: the origin, then the points on the plus and the minus side along each axis.
fn sigma_points<const N: usize>(unscented: &Unscented) -> Vec<[f64; N]> {
    let distance = unscented.distance_squared_in(N).sqrt();
    let along = |k: usize, sign: f64| std::array::from_fn(|j| if j == k { sign * distance } else { 0.0 });
    let outer = (0..N).flat_map(|k| [along(k, 1.0), along(k, -1.0)]);
    [[0.0; N]].into_iter().chain(outer).collect()
}

/// Eq. 18 for a component's propagated sigma points; angles are taken on the branch nearest to that of the first point.
pub fn transform<const N: usize>(
    unscented: &Unscented,
    variables: &[Variable],
    weight: f64,
    points: &[[f64; N]],
) -> Component<N> {
    let centre = points[0];
    let offset = |point: &[f64; N]| -> [f64; N] {
        std::array::from_fn(|k| {
            let value = if variables[k].is_circle() { nearest(point[k], centre[k]) } else { point[k] };
            value - centre[k]
        })
    };
    let offsets: Vec<[f64; N]> = points[1..].iter().map(offset).collect();
    let outer = unscented.outer_weight_in(N);
    let shift: [f64; N] = std::array::from_fn(|k| outer * offsets.iter().map(|d| d[k]).sum::<f64>());
    let covariance = |a: usize, b: usize| {
        let spread: f64 = offsets.iter().map(|d| (d[a] - shift[a]) * (d[b] - shift[b])).sum();
        outer * spread + unscented.central_covariance_weight_in(N) * shift[a] * shift[b]
    };
    Component {
        weight,
        mean: std::array::from_fn(|k| centre[k] + shift[k]),
        covariance: std::array::from_fn(|a| std::array::from_fn(|b| covariance(a, b))),
    }
}

/// The least variance of a variable, that of a deviation of 5e-10. All points of a component may agree on a variable,
/// as those of a cloud in the equator on their node.
const LEAST_VARIANCE: f64 = 2.5e-19;

fn at_least_uncertain<const N: usize>(mut covariance: [[f64; N]; N]) -> [[f64; N]; N] {
    (0..N).for_each(|k| covariance[k][k] = covariance[k][k].max(LEAST_VARIANCE));
    covariance
}

/// The rule that places and weighs the points by which a component is carried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum SigmaPointRule {
    /// Those of the unscented transform.
    Unscented(Unscented),
    /// Two sets of the fifth degree.
    FifthDegree,
}

impl SigmaPointRule {
    /// Their number in `n` variables.
    pub(super) const fn count(self, n: usize) -> usize {
        match self {
            Self::Unscented(_) => 1 + 2 * n,
            Self::FifthDegree => fifth_degree::points(n),
        }
    }
}

/// The sigma points of a mixture, moved from time to time.
#[derive(Debug, Clone)]
pub struct MixturePropagator<M, const N: usize> {
    flow: Flow<M>,
    rule: SigmaPointRule,
    weights: Vec<f64>,
    /// States of the sigma points: one column per coordinate, equally many rows for every component.
    columns: Vec<Vec<f64>>,
    now: f64,
}

impl<M: Model<Variables = [f64; N]>, const N: usize> MixturePropagator<M, N> {
    /// Splits a Gaussian at `t = 0` along column `along` of its square root into the components of a library.
    ///
    /// # Errors
    /// As [`MixturePropagator::split_along`].
    pub fn new(
        flow: Flow<M>,
        initial: &Gaussian<N>,
        unscented: Unscented,
        library: &Library,
        along: usize,
    ) -> Result<Self, MixtureError> {
        Self::split_along(flow, initial, unscented, library, std::array::from_fn(|k| f64::from(k == along)))
    }

    /// Splits a Gaussian at `t = 0` along a direction of unit length in its standardised coordinates into the
    /// components of a library. A component is left out if one of its sigma points lies outside the variables' ranges;
    /// the weights of the others are scaled to sum to 1.
    ///
    /// # Errors
    /// [`MixtureError`], if the settings are out of range or no component is inside the variables' ranges.
    pub fn split_along(
        flow: Flow<M>,
        initial: &Gaussian<N>,
        unscented: Unscented,
        library: &Library,
        direction: [f64; N],
    ) -> Result<Self, MixtureError> {
        unscented.check_in(N)?;
        let is_inside = |point: &[f64; N]| M::VARIABLES.iter().zip(point).all(|(variable, &x)| variable.allows(x));
        let places = sigma_points(&unscented);
        let mut components = Vec::new();
        for piece in Piece::whole().split_by(direction, library) {
            let points: Vec<[f64; N]> = places.iter().map(|&place| piece.point(initial, place)).collect();
            if points.iter().all(is_inside) {
                components.push((piece.weight, points));
            }
        }
        let total: f64 = components.iter().map(|(weight, _)| weight).sum();
        if !(total > 0.0 && total.is_finite()) {
            return Err(MixtureError::NothingInside);
        }
        let components = components.into_iter().map(|(weight, points)| (weight / total, points));
        Ok(Self::of_components(flow, SigmaPointRule::Unscented(unscented), components))
    }

    /// From the weights and the sigma points of all components at `t = 0`.
    pub(super) fn of_components(
        flow: Flow<M>,
        rule: SigmaPointRule,
        components: impl Iterator<Item = (f64, Vec<[f64; N]>)>,
    ) -> Self {
        let (mut weights, mut columns) = (Vec::new(), vec![Vec::new(); M::State::<f64>::COUNT]);
        for (weight, points) in components {
            weights.push(weight);
            for state in points.iter().map(|&point| flow.model.state(0.0, point)) {
                columns.iter_mut().enumerate().for_each(|(k, column)| column.push(state.component(k)));
            }
        }
        Self { flow, rule, weights, columns, now: 0.0 }
    }

    /// Number of components.
    pub fn components(&self) -> usize {
        self.weights.len()
    }

    /// Moves the sigma points to `time` \[yr\].
    ///
    /// # Errors
    /// [`MixtureError::Time`], or [`MixtureError::Escaped`] after which the propagator holds no meaningful states.
    pub fn advance_to(&mut self, time: f64) -> Result<(), MixtureError> {
        if !time.is_finite() {
            return Err(MixtureError::Time(time));
        }
        let mut columns: Vec<&mut [f64]> = self.columns.iter_mut().map(Vec::as_mut_slice).collect();
        self.flow.carry(&mut columns, self.now, time)?;
        self.now = time;
        Ok(())
    }

    /// The mixture at the present time.
    pub fn mixture(&self) -> Vec<Component<N>> {
        self.mixture_of(Which::Both)
    }

    /// An estimate of the error of the mixture's moments at the present time, in standard deviations and products of
    /// them; `None` if its points say nothing of it.
    pub(super) fn moment_error(&self) -> Option<f64> {
        (self.rule == SigmaPointRule::FifthDegree).then(|| {
            let [a, b] = [Which::First, Which::Second].map(|which| moments(M::VARIABLES, &self.mixture_of(which)));
            fifth_degree::apart(M::VARIABLES, &a, &b)
        })
    }

    fn mixture_of(&self, which: Which) -> Vec<Component<N>> {
        let known =
            |component: Component<N>| Component { covariance: at_least_uncertain(component.covariance), ..component };
        let size = self.rule.count(N);
        let point = |row: usize| {
            let state = Coordinates::from_fn(|k| self.columns[k][row]);
            self.flow.model.read_out(self.now, state)
        };
        let component = |(index, &weight): (usize, &f64)| {
            let points: Vec<[f64; N]> = (index * size..(index + 1) * size).map(point).collect();
            match &self.rule {
                SigmaPointRule::Unscented(unscented) => transform(unscented, M::VARIABLES, weight, &points),
                SigmaPointRule::FifthDegree => fifth_degree::component(M::VARIABLES, weight, &points, which),
            }
        };
        self.weights.par_iter().enumerate().map(|place| known(component(place))).collect()
    }
}

/// Mean and covariance of a mixture (Eq. 16). The mean vector of a variable on a circle is that of normals wrapped
/// round the circle (Mardia & Jupp 2000, Eq. 3.5.60), and what lies beyond the cut of the circle counts at its other
/// end ([`crate::wrapped`]). Weights need not sum to 1.
pub fn moments<const N: usize>(variables: &[Variable], components: &[Component<N>]) -> VariableMoments<N> {
    let total: f64 = components.iter().map(|component| component.weight).sum();
    let weighted = |f: &dyn Fn(&Component<N>) -> f64| -> f64 {
        components.iter().map(|component| component.weight * f(component)).sum::<f64>() / total
    };
    let circular: [Option<Circular>; N] = std::array::from_fn(|k| {
        variables[k].is_circle().then(|| {
            let length = |component: &Component<N>| (-0.5 * component.covariance[k][k]).exp();
            let sin = weighted(&|component| length(component) * component.mean[k].sin());
            let cos = weighted(&|component| length(component) * component.mean[k].cos());
            Circular::from_mean_vector(sin, cos)
        })
    });
    let on_branch =
        |k: usize, value: f64| circular[k].map_or(value, |circular: Circular| nearest(value, circular.mean));
    let beyond = |k: usize, component: &Component<N>| -> Option<BeyondCut> {
        let middle = circular[k]?.mean;
        Some(BeyondCut::new(on_branch(k, component.mean[k]) - middle, component.covariance[k][k].sqrt()))
    };
    let mean_of = |k: usize, component: &Component<N>| {
        on_branch(k, component.mean[k]) + beyond(k, component).map_or(0.0, |beyond| beyond.mean())
    };
    let mean: [f64; N] = std::array::from_fn(|k| weighted(&|component| mean_of(k, component)));
    let off = |k: usize, component: &Component<N>| on_branch(k, component.mean[k]) - mean[k];
    let product = |a: usize, b: usize, component: &Component<N>| {
        wrapped::product([a, b], |i, j| component.covariance[i][j], |k| off(k, component), |k| beyond(k, component))
    };
    // The mean of an angle counts what lies beyond the cut, its distances from the mean do as well.
    let covariance = std::array::from_fn(|a| std::array::from_fn(|b| weighted(&|component| product(a, b, component))));
    VariableMoments { mean, covariance, circular }
}

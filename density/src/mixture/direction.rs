//! Finds the direction along which the flow bends the initial Gaussian most.
//!
//! Vittaldev & Russell (2016, Eq. 5) measure the second difference of the flow along a direction. Here it is the second
//! difference over one standard deviation to either side of the mean, in standard deviations of the linearly propagated
//! cloud; the largest over the snapshots counts. Plain second differences would compare radians with eccentricities,
//! and would count a bend along the cloud as much as one across it.
//!
//! In the three scenarios it finds 40, 175 and 155 degrees from `phi` towards `e`; neither axis is the best. The
//! direction also depends on the snapshot: it is 60, 40, 65 and 95 degrees at the four snapshots of scenario 1.

use std::f64::consts::PI;

use super::error::MixtureError;
use super::linearity::Bends;
use super::split::{Axes, state};
use super::unscented::Unscented;
use crate::flow::Flow;
use crate::model::plane::{PlanarHamiltonian, State};
use crate::problem::Problem;

/// The direction along which the flow bends the initial Gaussian most, as its angle from the `phi` axis in standardised
/// coordinates, in `[0, π)`; and the number of points propagated to find it.
///
/// # Errors
/// [`MixtureError::NothingInside`], [`MixtureError::Escaped`].
pub fn strongest_nonlinearity<M: PlanarHamiltonian>(
    problem: &Problem<M>,
    flow: &Flow<M>,
) -> Result<(f64, usize), MixtureError> {
    const DIRECTIONS: u32 = 36;
    let axes = |k: u32| Axes::new(PI * f64::from(k) / f64::from(DIRECTIONS));
    let initial = &problem.initial;
    let offsets = (0..DIRECTIONS).flat_map(|k| [axes(k).point([1.0, 0.0]), axes(k).point([-1.0, 0.0])]);
    let placed: Option<Vec<State>> = [[0.0; 2]].into_iter().chain(offsets).map(|at| state(initial, at)).collect();
    let states = placed.ok_or(MixtureError::NothingInside)?;
    let (mut x1, mut x2): (Vec<f64>, Vec<f64>) = states.iter().map(|state| (state.x1, state.x2)).unzip();
    let mut worst = [0.0f64; DIRECTIONS as usize];
    let mut now = 0.0;
    for &time in &problem.times {
        flow.advance(&mut x1, &mut x2, time - now)?;
        now = time;
        let at = |k: usize| State { x1: x1[k], x2: x2[k] };
        let one_sigma = Unscented { alpha: 1.0, beta: -1.0, eta: 0.0 };
        for (k, worst) in worst.iter_mut().enumerate() {
            let perpendicular = (k + DIRECTIONS as usize / 2) % DIRECTIONS as usize;
            let pair = |k: usize| [at(1 + 2 * k), at(2 + 2 * k)];
            let ([a, b], [c, d]) = (pair(k), pair(perpendicular));
            let mut bends = Bends::new(&one_sigma, &[at(0), a, b, c, d]);
            bends.shifts[1] = [0.0; 2];
            *worst = worst.max(bends.disagreement([0.0; 2]));
        }
    }
    let strongest =
        (0..DIRECTIONS).max_by(|&a, &b| worst[a as usize].total_cmp(&worst[b as usize])).unwrap_or_default();
    Ok((PI * f64::from(strongest) / f64::from(DIRECTIONS), states.len()))
}

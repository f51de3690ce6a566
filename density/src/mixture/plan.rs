//! Chooses the lattice that a problem needs, by a look ahead with a few hundred pilot points.
//!
//! A pilot lattice of spacing 0.5 is carried through all snapshots. At each of its nodes the nine points around it give
//! the first and second derivatives of the flow map, from which the disagreement `D` of [`super::linearity`] follows
//! for a component of any width and orientation:
//!
//! ```text
//! a_i = d_i ∂x/∂p_i,   b_i = ½ d_i² ∂²x/∂p_i²,   d_i the spacing along direction i
//! ```
//!
//! without propagating anything again. The twist `d_1 d_2 ∂²x/∂p_1∂p_2`, which sigma points on the axes do not see, is
//! added as a third bend. The plan is the lattice with the fewest points whose `D` is below the tolerance at every
//! snapshot. If that lattice has more points than allowed, the plan is the allowed lattice with the least `D`.
//!
//! One lattice serves the whole cloud and all snapshots. Refining only where the flow bends would break the lattice,
//! and with it the sharing of sigma points (see [`super::lattice`]). It was not tried, as the lattice needed fewer
//! points than were allowed.

use std::f64::consts::FRAC_PI_2;

use super::error::MixtureError;
use super::lattice::Lattice;
use super::pilot::Pilot;
use super::unscented::Unscented;
use crate::flow::Flow;
use crate::model::PlanarHamiltonian;
use crate::problem::Problem;

/// Smallest number of points to plan with: those of the pilot and of a coarse lattice.
pub const LEAST_POINTS: usize = 600;
/// Number of orientations tried in a quarter turn.
const ORIENTATIONS: u32 = 6;
/// Number of spacings tried, each a sixth of an octave below the one before.
const SPACINGS: i32 = 40;
/// The widest spacing tried \[standard deviations\].
const WIDEST: f64 = 0.6;

/// The permitted cost of a plan and its target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adaptive {
    /// Largest disagreement `D`, twist included, that the plan allows at any snapshot.
    pub tolerance: f64,
    /// Largest number of sigma points, including those of the pilot.
    pub sigma_points: usize,
}

impl Default for Adaptive {
    fn default() -> Self {
        Self { tolerance: 0.15, sigma_points: 5000 }
    }
}

/// A lattice and its expected disagreement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SplitPlan {
    /// The lattice.
    pub lattice: Lattice,
    /// The largest disagreement `D`, twist included, expected at any snapshot.
    pub disagreement: f64,
    /// Number of points propagated for the plan.
    pub pilot_points: usize,
}

/// Plans the lattice of a problem.
///
/// # Errors
/// [`MixtureError::SplitPlan`] if there is no room, [`MixtureError::NothingInside`], [`MixtureError::Escaped`].
pub fn plan<M: PlanarHamiltonian>(
    problem: &Problem<M>,
    flow: &Flow<M>,
    unscented: &Unscented,
    adaptive: &Adaptive,
) -> Result<SplitPlan, MixtureError> {
    let Adaptive { tolerance, sigma_points } = *adaptive;
    if sigma_points < LEAST_POINTS || tolerance.is_nan() || tolerance <= 0.0 {
        return Err(MixtureError::SplitPlan { tolerance, points: sigma_points, least: LEAST_POINTS });
    }
    let pilot = Pilot::fly(problem, flow)?;
    let room = (sigma_points - pilot.points) as f64;
    let widest = WIDEST.min(0.9 * Lattice::spacing_limit(unscented));
    let spacing = |k: i32| widest * (-f64::from(k) / 6.0).exp2();
    let mut best: Option<(SplitPlan, f64)> = None;
    for orientation in 0..ORIENTATIONS {
        let angle = FRAC_PI_2 * f64::from(orientation) / f64::from(ORIENTATIONS);
        for (i, j) in (0..SPACINGS).flat_map(|i| (0..SPACINGS).map(move |j| (i, j))) {
            let lattice = Lattice { angle, spacing: [spacing(i), spacing(j)], ..Lattice::default() };
            let points = 1.02 * lattice.points(unscented);
            if points > room {
                continue;
            }
            let disagreement = pilot.disagreement(&lattice, unscented);
            let better = best.as_ref().is_none_or(|(plan, least)| {
                if disagreement <= tolerance && plan.disagreement <= tolerance {
                    points < *least
                } else {
                    disagreement < plan.disagreement
                }
            });
            if better {
                best = Some((SplitPlan { lattice, disagreement, pilot_points: pilot.points }, points));
            }
        }
    }
    let refused = MixtureError::SplitPlan { tolerance, points: sigma_points, least: LEAST_POINTS };
    best.map(|(plan, _)| plan).ok_or(refused)
}

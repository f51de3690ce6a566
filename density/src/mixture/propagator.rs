//! Moves the sigma points through the snapshots.
//!
//! The components are made once, at `t = 0`; their sigma points are moved from snapshot to snapshot. The weights stay
//! as they are (Sect. 3.3.1 of the paper).

use std::f64::consts::{FRAC_PI_2, PI};

use super::criterion::search;
use super::error::MixtureError;
use super::library::Library;
use super::planar_component::PlanarComponent;
use super::settings::{MixtureSettings, Split};
use super::split::{Direction, SigmaPoints, split};
use super::unscented::{Stencil, Unscented};
use super::{direction, linearity, moments, plan};
use crate::angle::nearest;
use crate::flow::Flow;
use crate::gaussian::Gaussian;
use crate::model::planar::SrpJ2;
use crate::model::plane::{PlanarHamiltonian, State};
use crate::problem::Problem;

/// A mixture at one snapshot.
#[derive(Debug, Clone, PartialEq)]
pub struct Mixture {
    /// The components, their mean `phi` on the branch within π of the mixture's circular mean.
    pub components: Vec<PlanarComponent>,
    /// How far apart the unscented and the linear prediction of each component are ([`linearity`]).
    pub disagreements: Vec<f64>,
}

impl Mixture {
    /// `D`, the mean of the disagreements; above [`linearity::DISTRUST`] the density should not be trusted.
    pub fn disagreement(&self) -> f64 {
        linearity::mean_disagreement(&self.components, &self.disagreements)
    }
}

/// Carries the sigma points of a problem.
#[derive(Debug, Clone)]
pub struct PlanarMixturePropagator<M = SrpJ2> {
    flow: Flow<M>,
    unscented: Unscented,
    x1: Vec<f64>,
    x2: Vec<f64>,
    weights: Vec<f64>,
    stencils: Vec<Stencil<u32>>,
    now: f64,
    pilot_points: usize,
    left_out: f64,
}

impl<M: PlanarHamiltonian> PlanarMixturePropagator<M> {
    /// Splits the initial Gaussian of `problem`, at `t = 0`. An adaptive split looks ahead through all snapshots of the
    /// problem with a few hundred pilot points.
    ///
    /// # Errors
    /// [`MixtureError`], if the settings are out of range or the initial Gaussian is outside `0 < e < 1`.
    pub fn new(problem: &Problem<M>, flow: &Flow<M>, settings: &MixtureSettings) -> Result<Self, MixtureError> {
        let unscented = settings.unscented;
        unscented.check()?;
        let initial = &problem.initial;
        let (points, pilot_points) = match &settings.split {
            Split::Library { along, components, across, variance } => {
                let (along_library, across_library) =
                    (Library::new(*components, *variance)?, Library::new(*across, *variance)?);
                let (angle, pilot_points) = angle(*along, problem, flow)?;
                (split(initial, &unscented, angle, &along_library, &across_library)?, pilot_points)
            }
            Split::Lattice(lattice) => (lattice.split(initial, &unscented)?, 0),
            Split::Adaptive(adaptive) => {
                let plan = plan::plan(problem, flow, &unscented, adaptive)?;
                (plan.lattice.split(initial, &unscented)?, plan.pilot_points)
            }
        };
        Ok(Self::from_points(*flow, unscented, points, pilot_points))
    }

    fn from_points(flow: Flow<M>, unscented: Unscented, points: SigmaPoints, pilot_points: usize) -> Self {
        let SigmaPoints { states, weights, stencils, left_out } = points;
        let (x1, x2) = states.iter().map(|state| (state.x1, state.x2)).unzip();
        Self { flow, unscented, x1, x2, weights, stencils, now: 0.0, pilot_points, left_out }
    }

    /// Moves the sigma points to `time` \[yr\].
    ///
    /// # Errors
    /// [`MixtureError::Time`], or [`MixtureError::Escaped`] after which the propagator holds no meaningful states.
    pub fn advance_to(&mut self, time: f64) -> Result<(), MixtureError> {
        if !time.is_finite() {
            return Err(MixtureError::Time(time));
        }
        self.flow.advance(&mut self.x1, &mut self.x2, time - self.now)?;
        self.now = time;
        Ok(())
    }

    /// The mixture at the present time.
    pub fn mixture(&self) -> Mixture {
        let state = |k: u32| State { x1: self.x1[k as usize], x2: self.x2[k as usize] };
        let stencils: Vec<Stencil<State>> = self.stencils.iter().map(|stencil| stencil.map(state)).collect();
        let transform = |(points, &weight)| self.unscented.transform(weight, points);
        let mut components: Vec<PlanarComponent> = stencils.iter().zip(&self.weights).map(transform).collect();
        let (moments, circular) = moments::unchecked_moments(&components, 1.0);
        for component in &mut components {
            component.mean_phi = nearest(component.mean_phi, circular.mean);
        }
        let disagreements = linearity::disagreements(&self.unscented, &stencils, [moments.std_phi, moments.std_e]);
        Mixture { components, disagreements }
    }

    /// The present time \[yr\].
    pub fn time(&self) -> f64 {
        self.now
    }

    /// Number of components.
    pub fn components(&self) -> usize {
        self.stencils.len()
    }

    /// Number of sigma points that are carried through the snapshots.
    pub fn sigma_points(&self) -> usize {
        self.x1.len()
    }

    /// Number of points propagated beforehand to plan the split.
    pub fn pilot_points(&self) -> usize {
        self.pilot_points
    }

    /// Share of the initial Gaussian whose components were left out because they reach out of `0 < e < 1`.
    pub fn left_out(&self) -> f64 {
        self.left_out
    }
}

/// The angle of a direction from the `phi` axis in standardised coordinates, in `[0, π)`, and the number of points
/// spent on finding it.
fn angle<M: PlanarHamiltonian>(
    direction: Direction,
    problem: &Problem<M>,
    flow: &Flow<M>,
) -> Result<(f64, usize), MixtureError> {
    match direction {
        Direction::SolarAngle => Ok((0.0, 0)),
        Direction::Eccentricity => Ok((FRAC_PI_2, 0)),
        Direction::Angle(angle) => Ok((angle.rem_euclid(PI), 0)),
        Direction::StrongestNonlinearity => direction::strongest_nonlinearity(problem, flow),
        Direction::OfCriterion(criterion) => {
            let gaussian = Gaussian::from(problem.initial);
            let found = search(criterion, *flow, &gaussian, &problem.times)?;
            let [phi, e] = gaussian.point(found.preferred.direction);
            let (u, v) = problem.initial.standardise(phi, e);
            Ok((v.atan2(u).rem_euclid(PI), found.orbits))
        }
    }
}

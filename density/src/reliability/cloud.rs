//! Orbits that start in a cloud, each with a radiation parameter of its own, in the plane or in space.

use std::num::NonZeroUsize;

use rayon::prelude::*;

use crate::flow::{Accuracy, Flow};
use crate::in_space::SpaceProblem;
use crate::in_space::draws::{Distributed, Start};
use crate::model::irradiated::{Extended, WithRadiation};
use crate::model::model_name::ModelName;
use crate::model::registry::Planar;
use crate::model::uncertain_radiation::{Linear, UncertainRadiation};
use crate::model::vectorial::Vectorial;
use crate::model::{Coordinates, Model};
use crate::problem::Problem;
use crate::problem_error::{Field, ProblemError};
use crate::sampling::{Draws, SamplingPlan};
use crate::uncertain::{Distribution, Spread};

/// Orbits that a thread takes at a time.
const CHUNK: usize = 1024;
/// Years after which the orbits that have passed are left behind.
const SEGMENT: f64 = 0.5;

/// Where a cloud's orbits start, how they move, and when they re-enter.
pub struct Cloud {
    distributed: Distributed,
    moving: Box<dyn Moving>,
    critical_e: f64,
    /// Whether the logarithm of the radiation parameter is what is drawn.
    is_logarithmic: bool,
}

impl std::fmt::Debug for Cloud {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Cloud {{ critical_e: {} }}", self.critical_e)
    }
}

/// A start with the radiation parameter of its orbit.
pub type StartWithRadiation = (Start, f64);

impl Cloud {
    /// The cloud of a problem in the plane, which has the mean of the radiation parameter.
    ///
    /// # Errors
    /// [`ProblemError`] if its model has no radiation parameter, or its variables have no Gaussian.
    pub fn in_plane(problem: &Problem<Planar>, spread: Option<Spread>) -> Result<Self, ProblemError> {
        let mean = problem.model.value("radiation").unwrap_or(0.0);
        let distributed = Distributed::in_plane(problem.initial, spread, mean)?;
        Ok(Self::new(distributed, moving_in_plane(problem.model)?, (spread, problem.critical_e)))
    }

    /// The cloud of a problem in space, moved by its averaged model.
    ///
    /// # Errors
    /// [`ProblemError`] if the model is not averaged or has the Earth's shadow.
    pub fn in_space(problem: &SpaceProblem) -> Result<Self, ProblemError> {
        let model = averaged(problem)?;
        Self::of_space(problem, Box::new(OfSpace(flow(WithRadiation::new(model)))))
    }

    /// The same cloud, moved by the planar model: as if orbit, Sun and Moon were in one plane.
    ///
    /// # Errors
    /// As [`Cloud::in_space`].
    pub fn flattened(problem: &SpaceProblem) -> Result<Self, ProblemError> {
        averaged(problem)?;
        Self::of_space(problem, moving_in_plane(problem.model.planar())?)
    }

    fn of_space(problem: &SpaceProblem, moving: Box<dyn Moving>) -> Result<Self, ProblemError> {
        Ok(Self::new(Distributed::of(problem)?, moving, (problem.spread, problem.critical_e)))
    }

    fn new(distributed: Distributed, moving: Box<dyn Moving>, (spread, critical_e): (Option<Spread>, f64)) -> Self {
        let is_logarithmic = spread.is_some_and(|spread| spread.distribution == Distribution::LogNormal);
        Self { distributed, moving, critical_e, is_logarithmic }
    }

    /// Independent orbits of the cloud, each with the radiation parameter that was drawn for it.
    pub fn independent(&self, seed: u64, count: usize) -> Vec<StartWithRadiation> {
        let plan = SamplingPlan { draws: Draws::Independent, seed, replicates: NonZeroUsize::MIN };
        let draw = self.distributed.draw(&plan);
        (0..count).into_par_iter().map(|number| self.with_its_radiation(draw(number))).collect()
    }

    /// A start with the radiation parameter that was drawn for it.
    pub fn with_its_radiation(&self, start: Start) -> StartWithRadiation {
        (start, if self.is_logarithmic { start.radiation.exp() } else { start.radiation })
    }

    /// The starts of these numbers in one replicate of a quasi-random sample.
    pub fn starts(&self, replicate: usize, numbers: std::ops::Range<usize>) -> Vec<Start> {
        let plan = SamplingPlan { draws: Draws::Sobol, seed: replicate as u64, replicates: NonZeroUsize::MIN };
        let draw = self.distributed.draw(&plan);
        numbers.into_par_iter().map(draw).collect()
    }

    /// When each orbit first reaches the critical eccentricity \[yr\]: infinite if it does not within these years, NaN
    /// if it cannot be followed and has not passed before.
    pub fn passages(&self, orbits: &[StartWithRadiation], years: f64) -> Vec<f64> {
        orbits
            .par_chunks(CHUNK)
            .flat_map_iter(|orbits| self.moving.passages(orbits, (self.critical_e, years)))
            .collect()
    }

    /// The eccentricity of each orbit after these years; NaN if it cannot be followed.
    pub fn eccentricities(&self, orbits: &[StartWithRadiation], years: f64) -> Vec<f64> {
        orbits.par_chunks(CHUNK).flat_map_iter(|orbits| self.moving.eccentricities(orbits, years)).collect()
    }
}

/// The averaged model of a problem in space, if that is its model.
fn averaged(problem: &SpaceProblem) -> Result<Vectorial, ProblemError> {
    match problem.model.if_averaged() {
        Some(model) if !problem.shadow => Ok(model),
        Some(_) => Err(ProblemError::misfit(
            Field::Shadow,
            "\"shadow\" makes the semi-major axis a variable and an orbit a thousand times as costly, so that no map is computed with it; leave \
             it out, or run single scenarios with mc or qmc",
        )),
        None => Err(ProblemError::misfit(
            Field::Model,
            format!(
                "\"{}\" is not averaged, and an orbit takes a thousand times as long, so that no map is computed in it; a map takes {}",
                problem.model.name(),
                ModelName::listed(ModelName::is_averaged)
            ),
        )),
    }
}

fn flow<M>(model: M) -> Flow<M> {
    Flow { model, accuracy: Accuracy::Coarse }
}

fn moving_in_plane(model: Planar) -> Result<Box<dyn Moving>, ProblemError> {
    let none = || ProblemError::misfit(Field::Model, "has no radiation parameter");
    let without = model.with("radiation", 0.0).map_err(|_| none())?;
    Ok(Box::new(OfPlane(flow(UncertainRadiation::new(without)))))
}

/// What moves orbits.
trait Moving: Send + Sync {
    fn passages(&self, orbits: &[StartWithRadiation], passing: (f64, f64)) -> Vec<f64>;
    fn eccentricities(&self, orbits: &[StartWithRadiation], years: f64) -> Vec<f64>;
}

struct OfSpace(Flow<WithRadiation<Vectorial, Linear>>);

impl Moving for OfSpace {
    fn passages(&self, orbits: &[StartWithRadiation], passing: (f64, f64)) -> Vec<f64> {
        passages(&self.0, self.columns(orbits), passing)
    }

    fn eccentricities(&self, orbits: &[StartWithRadiation], years: f64) -> Vec<f64> {
        eccentricities(&self.0, self.columns(orbits), years)
    }
}

impl OfSpace {
    fn columns(&self, orbits: &[StartWithRadiation]) -> Vec<Vec<f64>> {
        columns(&self.0, orbits, |variables, radiation| Extended { first: variables, last: radiation })
    }
}

struct OfPlane(Flow<UncertainRadiation<Linear>>);

impl Moving for OfPlane {
    fn passages(&self, orbits: &[StartWithRadiation], passing: (f64, f64)) -> Vec<f64> {
        passages(&self.0, self.columns(orbits), passing)
    }

    fn eccentricities(&self, orbits: &[StartWithRadiation], years: f64) -> Vec<f64> {
        eccentricities(&self.0, self.columns(orbits), years)
    }
}

impl OfPlane {
    fn columns(&self, orbits: &[StartWithRadiation]) -> Vec<Vec<f64>> {
        columns(&self.0, orbits, |[phi, e, ..], radiation| [phi, e, radiation])
    }
}

/// The states at the start, one column per coordinate.
fn columns<M: Model>(
    flow: &Flow<M>,
    orbits: &[StartWithRadiation],
    variables: impl Fn([f64; 4], f64) -> M::Variables,
) -> Vec<Vec<f64>> {
    let mut columns = vec![Vec::with_capacity(orbits.len()); M::State::<f64>::COUNT];
    for (start, radiation) in orbits {
        let state = flow.model.state(0.0, variables(start.variables, *radiation));
        columns.iter_mut().enumerate().for_each(|(k, column)| column.push(state.component(k)));
    }
    columns
}

fn passages<M: Model>(flow: &Flow<M>, mut columns: Vec<Vec<f64>>, (critical, years): (f64, f64)) -> Vec<f64> {
    let mut passages = vec![f64::INFINITY; columns[0].len()];
    let mut open: Vec<usize> = (0..passages.len()).collect();
    let segments = (years / SEGMENT).ceil().max(1.0) as u32;
    let end = |segment: u32| years * f64::from(segment) / f64::from(segments);
    for segment in 0..segments {
        let mut times = vec![f64::INFINITY; open.len()];
        let mut slices: Vec<&mut [f64]> = columns.iter_mut().map(Vec::as_mut_slice).collect();
        flow.carry_passing(&mut slices, (end(segment), end(segment + 1)), critical, &mut times);
        let stays: Vec<bool> = times.iter().map(|time| *time == f64::INFINITY).collect();
        open.iter().zip(&times).for_each(|(&orbit, &time)| passages[orbit] = time);
        let mut is_open = stays.iter();
        open.retain(|_| is_open.next() == Some(&true));
        if open.is_empty() {
            break;
        }
        for column in &mut columns {
            let mut is_open = stays.iter();
            column.retain(|_| is_open.next() == Some(&true));
        }
    }
    passages
}

fn eccentricities<M: Model>(flow: &Flow<M>, mut columns: Vec<Vec<f64>>, years: f64) -> Vec<f64> {
    flow.carry_where_possible(&mut columns.iter_mut().map(Vec::as_mut_slice).collect::<Vec<_>>(), 0.0, years);
    let eccentricity = |i: usize| {
        let state = Coordinates::from_fn(|k| columns[k][i]);
        let is_lost = columns[0][i].is_nan();
        if is_lost { f64::NAN } else { flow.model.read_out(years, state).component(M::REENTRY) }
    };
    (0..columns[0].len()).map(eccentricity).collect()
}

//! A mixture on its way through a scenario: in the plane, or over the variables of any model.

use std::fmt::Debug;

use density::flow::{Accuracy, Flow};
use density::gaussian::Gaussian;
use density::in_space::SpaceProblem;
use density::in_space::task::SpaceTask;
use density::mixture::adaptive::{AdaptiveMixture, Fineness, MixturePlan};
use density::mixture::component::Component;
use density::mixture::merge::merge;
use density::mixture::unscented::Unscented;
use density::mixture::{Mixture, PlanarMixturePropagator};
use density::model::Model;
use density::model::registry::Planar;
use density::model::uncertain_radiation::{Scale, UncertainRadiation};
use density::model::unfolded::{InSpace, Unfolded};
use density::uncertain::{UncertainProblem, UncertainTask};
use messages::content;

use kit::failure::Failure;

/// A mixture on its way.
pub(super) trait Course: Debug {
    /// Does a part of the plan, and returns which share of it is done; `None` if nothing is left to plan.
    fn plan_on(&mut self) -> Result<Option<f64>, Failure> {
        Ok(None)
    }

    /// Moves the mixture to snapshot `index` and returns the number of its components there.
    fn advance(&mut self, index: usize) -> Result<usize, Failure>;

    /// How far the flow over a component is from linear; NaN before the first snapshot.
    fn disagreement(&self) -> f64;

    /// The most components of a snapshot.
    fn most_components(&self) -> usize;

    /// Number of orbits propagated.
    fn trajectories(&self) -> u64;

    /// Writes the components of the present snapshot.
    fn write(&self, columns: &mut [f64]);
}

/// A mixture in the plane.
#[derive(Debug)]
pub(super) struct InPlane {
    pub propagator: PlanarMixturePropagator<Planar>,
    pub times: Vec<f64>,
    /// The most components that are published.
    pub merge_to: Option<usize>,
    pub mixture: Option<Mixture>,
    pub disagreement: f64,
}

impl Course for InPlane {
    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        self.propagator.advance_to(self.times[index])?;
        let mut mixture = self.propagator.mixture();
        self.disagreement = mixture.disagreement(); // of the components as propagated
        if let Some(most) = self.merge_to {
            mixture.components = merge(&mixture.components, most)?;
        }
        Ok(self.mixture.insert(mixture).components.len())
    }

    fn disagreement(&self) -> f64 {
        self.disagreement
    }

    fn most_components(&self) -> usize {
        self.propagator.components()
    }

    /// The five sigma points of each component; those that neighbours share are counted for each.
    fn trajectories(&self) -> u64 {
        5 * self.propagator.components() as u64
    }

    fn write(&self, columns: &mut [f64]) {
        let Some(mixture) = &self.mixture else { return };
        for (row, component) in mixture.components.iter().enumerate() {
            content::Mixture::write_row(columns, row, component.to_array());
        }
    }
}

/// How far the mixture has come.
#[derive(Debug)]
enum Stage<M, const N: usize> {
    /// It is being planned, with at most this number of components.
    Planning(Box<MixturePlan<M, N>>, usize),
    /// It is on its way.
    Planned(AdaptiveMixture<M, N>),
}

/// A mixture over the variables of any model.
#[derive(Debug)]
struct OverVariables<M, const N: usize> {
    stage: Stage<M, N>,
    times: Vec<f64>,
    components: Vec<Component<N>>,
    disagreement: f64,
}

impl<M: Model<Variables = [f64; N]>, const N: usize> Course for OverVariables<M, N> {
    fn plan_on(&mut self) -> Result<Option<f64>, Failure> {
        let Stage::Planning(plan, _) = &mut self.stage else { return Ok(None) };
        let share = plan.go_on()?;
        if share.is_none() {
            self.stage = Stage::Planned(plan.mixture()?);
        }
        Ok(share)
    }

    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        while self.plan_on()?.is_some() {}
        let Stage::Planned(mixture) = &mut self.stage else { return Err(Failure::no_scenario()) };
        mixture.advance_to(self.times[index])?;
        self.components = mixture.mixture();
        self.disagreement = mixture.present_disagreement(index);
        Ok(self.components.len())
    }

    fn disagreement(&self) -> f64 {
        self.disagreement
    }

    fn most_components(&self) -> usize {
        match &self.stage {
            Stage::Planning(_, most) => *most,
            Stage::Planned(mixture) => mixture.components(),
        }
    }

    fn trajectories(&self) -> u64 {
        match &self.stage {
            Stage::Planning(..) => 0,
            Stage::Planned(mixture) => mixture.trajectories() as u64,
        }
    }

    /// The weight, the means, and the upper triangle of the covariance, row by row.
    fn write(&self, columns: &mut [f64]) {
        let rows = self.components.len();
        for (row, Component { weight, mean, covariance }) in self.components.iter().enumerate() {
            let upper = (0..N).flat_map(|a| covariance[a][a..].iter());
            let numbers = [weight].into_iter().chain(mean).chain(upper);
            numbers.enumerate().for_each(|(column, &number)| columns[column * rows + row] = number);
        }
    }
}

/// The task of planning the mixture of a problem in more than two variables.
pub(super) struct Planned<'a, P> {
    pub problem: &'a P,
    pub accuracy: Accuracy,
    pub unscented: Unscented,
    pub fineness: Fineness,
}

impl<P> Planned<'_, P> {
    fn course<M: Model<Variables = [f64; N]>, const N: usize>(
        &self,
        model: M,
        initial: &Gaussian<N>,
        times: &[f64],
    ) -> Result<Box<dyn Course>, Failure> {
        let flow = Flow { model, accuracy: self.accuracy };
        let plan = MixturePlan::new(flow, initial, times, self.unscented, self.fineness)?;
        let stage = Stage::Planning(Box::new(plan), self.fineness.components);
        Ok(Box::new(OverVariables { stage, times: times.to_vec(), components: Vec::new(), disagreement: f64::NAN }))
    }
}

impl UncertainTask for Planned<'_, UncertainProblem> {
    type Output = Result<Box<dyn Course>, Failure>;

    fn with<S: Scale>(self, model: UncertainRadiation<S>) -> Self::Output {
        self.course(model, &self.problem.gaussian(), &self.problem.plane.times)
    }
}

impl SpaceTask for Planned<'_, SpaceProblem> {
    type Output = Result<Box<dyn Course>, Failure>;

    fn with<M: InSpace<N>, const N: usize>(self, model: Unfolded<M, N>, initial: Gaussian<N>) -> Self::Output {
        self.course(model, &initial, &self.problem.times)
    }
}

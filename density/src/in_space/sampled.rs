//! Orbits of a cloud on their way, in the scenario's model or in a simpler one.

use std::ops::Range;

use rayon::prelude::*;

use super::cloud::Cloud;
use super::draws::{Distributed, Start};
use super::mean_cloud::{MeanCloud, Unaveraged};
use super::{SpaceProblem, VARIABLES};
use crate::flow::{Accuracy, Flow, Passages};
use crate::model::Model;
use crate::model::irradiated::{Irradiated, WithRadiation};
use crate::model::model_name::ModelName;
use crate::model::osculating::Osculating;
use crate::model::shadow::{ShadowedOsculating, ShadowedVectorial};
use crate::model::space_registry::SpaceModel;
use crate::model::uncertain_radiation::{Linear, Logarithmic, UncertainRadiation};
use crate::model::vectorial::Vectorial;
use crate::orbits::{LostOrbit, Orbits};
use crate::problem_error::{Field, ProblemError};
use crate::sampling::SamplingPlan;

/// Orbits of a planar model in the place of orbits in space: they have no inclination and no node.
#[derive(Debug)]
struct InPlane<M>(Orbits<M>);

impl<M: Model> Cloud for InPlane<M> {
    fn advance_watching(&mut self, time: f64, critical: f64, passages: Passages<'_, u8>) -> Result<(), LostOrbit> {
        self.0.advance_watching(time, critical, passages)
    }

    fn read_out(&self, columns: &mut [f64]) {
        const OF_PLANE: usize = 2;
        let (in_plane, rest) = columns.split_at_mut(OF_PLANE * self.0.len());
        let (beyond, radiation) = rest.split_at_mut((VARIABLES.len() - OF_PLANE) * self.0.len());
        beyond.fill(f64::NAN);
        let length = self.0.len().max(1);
        let both = in_plane.chunks_exact_mut(length).chain(radiation.chunks_exact_mut(length));
        self.0.read_out_columns(&mut both.collect::<Vec<_>>());
    }
}

/// Orbits of a model whose variables are others than the cloud's, or in another order.
#[derive(Debug)]
struct Renamed<M> {
    orbits: Orbits<M>,
    /// The model's variable that each of the cloud's is, if it is one.
    of_cloud: Vec<Option<usize>>,
}

impl<M: Model> Cloud for Renamed<M> {
    fn advance_watching(&mut self, time: f64, critical: f64, passages: Passages<'_, u8>) -> Result<(), LostOrbit> {
        self.orbits.advance_watching(time, critical, passages)
    }

    fn read_out(&self, columns: &mut [f64]) {
        let length = self.orbits.len().max(1);
        let mut own = vec![0.0; length * M::VARIABLES.len()];
        self.orbits.read_out_columns(&mut own.chunks_exact_mut(length).collect::<Vec<_>>());
        for (column, of_cloud) in columns.chunks_exact_mut(length).zip(&self.of_cloud) {
            match of_cloud {
                Some(k) => column.copy_from_slice(&own[k * length..(k + 1) * length]),
                None => column.fill(f64::NAN),
            }
        }
    }
}

/// What a case does with a problem in space.
#[derive(Debug, Clone, Copy)]
pub struct Sampled<'a> {
    /// The problem.
    pub problem: &'a SpaceProblem,
    /// The model in which orbits move, if not in the problem's.
    pub simplification: Option<ModelName>,
    /// How orbits are drawn.
    pub plan: SamplingPlan,
    /// How accurately they are moved.
    pub accuracy: Accuracy,
}

impl Sampled<'_> {
    /// The orbits of the numbers in `range`.
    ///
    /// # Errors
    /// [`ProblemError`] if the model asks for more than the problem states.
    pub fn cloud(&self, range: Range<usize>) -> Result<Box<dyn Cloud>, ProblemError> {
        let draw = Distributed::of(self.problem)?.draw(&self.plan);
        let starts: Vec<Start> = range.into_par_iter().map(draw).collect();
        match (self.simplification, self.problem.model) {
            (Some(ModelName::Planar), _) if self.problem.shadow => self.shadowed(true, &starts),
            (Some(ModelName::Planar), _) => Ok(self.in_plane(&starts)),
            (Some(ModelName::Vectorial), _) | (None, SpaceModel::Vectorial { .. }) if self.problem.shadow => {
                self.shadowed(false, &starts)
            }
            (Some(ModelName::Vectorial), _) | (None, SpaceModel::Vectorial { .. }) => Ok(self.averaged(&starts)),
            (None | Some(ModelName::Osculating), SpaceModel::Osculating { model, mean_anomaly }) => {
                let (has_shadow, reentry_radius) = (self.problem.shadow, self.problem.reentry_radius());
                match (has_shadow, reentry_radius) {
                    (false, None) => Ok(self.unaveraged(model, &model, mean_anomaly, &starts)),
                    _ => {
                        let shadowed = ShadowedOsculating { model, has_shadow, reentry_radius };
                        Ok(self.unaveraged(shadowed, &model, mean_anomaly, &starts))
                    }
                }
            }
            (Some(ModelName::Osculating), SpaceModel::Vectorial { .. }) => {
                let name = ModelName::Osculating.text();
                let why = "needs a scenario of that model: an averaged one does not say where the Moon is";
                Err(ProblemError::misfit(Field::Model, format!("\"{name}\" {why}")))
            }
        }
    }

    /// Averaged orbits with the shadow; in the plane if so, where the orbit and the Sun stay in the equator.
    fn shadowed(&self, is_in_plane: bool, starts: &[Start]) -> Result<Box<dyn Cloud>, ProblemError> {
        let of_space = self.problem.model.averaged_with_shadow(self.problem.reentry_radius());
        let model =
            of_space.ok_or_else(|| ProblemError::misfit(Field::Shadow, "\"shadow\" needs the semi-major axis"))?;
        let zero = || vec![0.0; starts.len()];
        let [phi, e, inclination, node] = [0, 1, 2, 3].map(|k| variable(starts, k));
        let axis = vec![model.semi_major_axis; starts.len()];
        let mut of_cloud = vec![Some(0), Some(1), Some(2), Some(3)];
        let (model, columns) = if is_in_plane {
            (of_cloud[2], of_cloud[3]) = (None, None);
            let in_equator = Vectorial { obliquity: 0.0, sun_longitude: 0.0, ..model.model };
            (ShadowedVectorial { model: in_equator, ..model }, [phi, e, zero(), zero(), axis])
        } else {
            (model, [phi, e, inclination, node, axis])
        };
        if self.problem.spread.is_some() {
            of_cloud.push(Some(columns.len()));
        }
        Ok(match (self.problem.spread.is_some(), self.problem.is_logarithmic()) {
            (false, _) => Box::new(Renamed { orbits: self.orbits(model, &columns), of_cloud }),
            (_, false) => {
                let model = WithRadiation::<_, Linear>::new(model);
                Box::new(Renamed { orbits: self.orbits(model, &with_radiation(&columns, starts)), of_cloud })
            }
            (_, true) => {
                let model = WithRadiation::<_, Logarithmic>::new(model);
                Box::new(Renamed { orbits: self.orbits(model, &with_radiation(&columns, starts)), of_cloud })
            }
        })
    }

    fn in_plane(&self, starts: &[Start]) -> Box<dyn Cloud> {
        let planar = self.problem.model.planar();
        let without = planar.with("radiation", 0.0).unwrap_or(planar);
        let columns = [variable(starts, 0), variable(starts, 1)];
        match (self.problem.spread.is_some(), self.problem.is_logarithmic()) {
            (false, _) => Box::new(InPlane(self.orbits(planar, &columns))),
            (_, false) => {
                let model = UncertainRadiation::<Linear>::new(without);
                Box::new(InPlane(self.orbits(model, &with_radiation(&columns, starts))))
            }
            (_, true) => {
                let model = UncertainRadiation::<Logarithmic>::new(without);
                Box::new(InPlane(self.orbits(model, &with_radiation(&columns, starts))))
            }
        }
    }

    fn averaged(&self, starts: &[Start]) -> Box<dyn Cloud> {
        let model = self.problem.model.averaged();
        let columns = [0, 1, 2, 3].map(|k| variable(starts, k));
        match (self.problem.spread.is_some(), self.problem.is_logarithmic()) {
            (false, _) => Box::new(self.orbits(model, &columns)),
            (_, false) => {
                Box::new(self.orbits(WithRadiation::<_, Linear>::new(model), &with_radiation(&columns, starts)))
            }
            (_, true) => {
                Box::new(self.orbits(WithRadiation::<_, Logarithmic>::new(model), &with_radiation(&columns, starts)))
            }
        }
    }

    fn unaveraged<M: Unaveraged + Irradiated<Linear> + Irradiated<Logarithmic>>(
        &self,
        model: M,
        nominal: &Osculating,
        mean_anomaly: Option<f64>,
        starts: &[Start],
    ) -> Box<dyn Cloud> {
        let anomalies = starts.iter().map(|start| mean_anomaly.unwrap_or(start.mean_anomaly)).collect();
        let axes = vec![nominal.semi_major_axis; starts.len()];
        let variables = [0, 1, 2, 3].map(|k| variable(starts, k)).into_iter();
        let columns: Vec<Vec<f64>> = variables.chain([anomalies, axes]).collect();
        let accuracy = self.accuracy;
        match (self.problem.spread.is_some(), self.problem.is_logarithmic()) {
            (false, _) => Box::new(MeanCloud::new(Flow { model, accuracy }, &columns)),
            (_, false) => {
                let flow = Flow { model: WithRadiation::<_, Linear>::new(model), accuracy };
                Box::new(MeanCloud::new(flow, &with_radiation(&columns, starts)))
            }
            (_, true) => {
                let flow = Flow { model: WithRadiation::<_, Logarithmic>::new(model), accuracy };
                Box::new(MeanCloud::new(flow, &with_radiation(&columns, starts)))
            }
        }
    }

    fn orbits<M: Model>(&self, model: M, columns: &[Vec<f64>]) -> Orbits<M> {
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        Orbits::from_variables(Flow { model, accuracy: self.accuracy }, &columns)
    }
}

/// One variable of all orbits.
fn variable(starts: &[Start], k: usize) -> Vec<f64> {
    starts.iter().map(|start| start.variables[k]).collect()
}

/// The columns, and one with the radiation parameters.
fn with_radiation(columns: &[Vec<f64>], starts: &[Start]) -> Vec<Vec<f64>> {
    let radiation = starts.iter().map(|start| start.radiation).collect();
    columns.iter().cloned().chain([radiation]).collect()
}

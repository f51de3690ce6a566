//! The settings of a Monte Carlo case.

use std::num::NonZeroUsize;
use std::ops::Range;

use density::sampling::{Draws, SamplingPlan};
use kit::assignment::Assignment;
use kit::failure::Failure;
use kit::shard::Shard;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::MonteCarlo;
use crate::files::toml_words::choice;
use crate::methods::accuracy::AccuracySetting;
use crate::methods::choices::check_forces;
use crate::methods::drawing::Drawing;
use crate::methods::map_refusal::By;
use crate::methods::mapped_samples::{MAP_ERROR, MappedSamples, check_map_error};
use crate::methods::sampling_settings::sampling_settings;
use crate::methods::{Method, Misfit};

/// How draws depend on one another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DrawsChoice {
    /// Not at all: independent draws.
    Independent,
    /// In antithetic pairs, which lie opposite one another about the mean.
    Antithetic,
    /// As points of a scrambled Sobol sequence.
    Sobol,
}

/// How samples get from the start to a snapshot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Through {
    /// Each is propagated on its own.
    #[default]
    Orbits,
    /// By a flow map, interpolated from a lattice of orbits.
    FlowMap,
}

sampling_settings! {
    /// Settings of a Monte Carlo case. Independent draws need no replicates: 1 is allowed only for them.
    after_seed {
        /// How draws depend on one another: independent, antithetic pairs, or a scrambled Sobol sequence.
        #[serde(deserialize_with = "choice")]
        draws: DrawsChoice,
    }
    after_replicates {
        /// How samples get from the start to a snapshot.
        #[serde(deserialize_with = "choice")]
        through: Through,
        /// Largest error of a flow map; 1e-9 unless set.
        #[serde(skip_serializing_if = "Option::is_none")]
        map_error: Option<f64>,
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            samples: 100_000,
            seed: 1,
            draws: DrawsChoice::Independent,
            replicates: 1,
            through: Through::Orbits,
            map_error: None,
            accuracy: None,
            model: None,
            forces: None,
        }
    }
}

impl Settings {
    pub(super) fn plan(&self) -> SamplingPlan {
        let draws = match self.draws {
            DrawsChoice::Independent => Draws::Independent,
            DrawsChoice::Antithetic => Draws::Antithetic,
            DrawsChoice::Sobol => Draws::Sobol,
        };
        SamplingPlan {
            draws,
            seed: self.seed,
            replicates: NonZeroUsize::new(self.replicates).unwrap_or(NonZeroUsize::MIN),
        }
    }

    /// The orbits of these numbers, propagated one by one.
    pub(super) fn drawing(&self, range: Range<usize>) -> Drawing {
        Drawing {
            plan: self.plan(),
            simplification: self.model.map(Into::into),
            forces: self.forces.clone(),
            accuracy: self.accuracy.unwrap_or_default().0,
            range,
        }
    }
}

impl Method for Settings {
    const NAME: &'static str = "mc";
    type Propagator = MonteCarlo;

    fn propagator(self) -> MonteCarlo {
        MonteCarlo::new(self)
    }

    fn check(&self) -> Result<(), Misfit> {
        if self.draws != DrawsChoice::Independent && self.replicates < 2 {
            let problem = "draws that depend on one another need replicates = 2 or more to have standard errors";
            return Err(Misfit::new("draws", problem));
        }
        if self.samples / 2 < self.replicates {
            let Self { samples, replicates, .. } = self;
            let least = replicates.saturating_mul(2);
            let problem = format!("{samples} is not enough for replicates = {replicates}, it must be at least {least}");
            return Err(Misfit::new("samples", problem));
        }
        check_forces(self.forces.as_ref())?;
        match (self.through, self.map_error) {
            (Through::Orbits, Some(_)) => {
                return Err(Misfit::no_effect("map_error", "unless through = \"flow-map\""));
            }
            (Through::FlowMap, Some(error)) => check_map_error(error)?,
            (_, None) => {}
        }
        if self.through == Through::FlowMap && (self.model.is_some() || self.forces.is_some()) {
            let key = if self.model.is_some() { "model" } else { "forces" };
            let because = "beside through = \"flow-map\", which is for scenarios in their own model";
            return Err(Misfit::no_effect(key, because));
        }
        Ok(())
    }

    fn check_scenario(&self, assignment: &Assignment, _: Shard) -> Result<(), Failure> {
        match self.through {
            Through::FlowMap => {
                let map_error = self.map_error.unwrap_or(MAP_ERROR);
                MappedSamples::check(By::Cells, &self.plan(), map_error, assignment)
            }
            // No orbits are drawn, but all that may be wrong is.
            Through::Orbits => self.drawing(0..0).cloud(assignment).map(drop),
        }
    }

    fn resolved(&self) -> Self {
        let is_mapped = self.through == Through::FlowMap;
        Self { map_error: is_mapped.then_some(self.map_error.unwrap_or(MAP_ERROR)), ..self.clone() }
    }

    fn accuracy_mut(&mut self) -> &mut Option<AccuracySetting> {
        &mut self.accuracy
    }

    fn most_numbers(&self, _: (usize, usize), variables: usize) -> usize {
        self.samples.saturating_mul(variables)
    }

    fn rows_to_share(&self) -> Result<usize, String> {
        Ok(self.samples)
    }

    fn check_reduce(&self) -> Result<(), String> {
        match self.replicates {
            1 => Ok(()),
            _ => Err("the standard errors of replicates need the samples of each; leave out one".into()),
        }
    }
}

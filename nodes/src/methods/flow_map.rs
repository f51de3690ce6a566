//! The flow map as a propagator: samples, or the density along characteristics, that move by a map instead of one by
//! one.

#[cfg(test)]
mod tests;

use density::grid::Grid;
use density::mesh::Placement;
use density::mesh::lattice::MOST_DEGREE;
use density::sample_sums::{SampleSums, TooFar};
use density::sampling::{Draws, SamplingPlan};
use messages::content::Samples;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::files::input::{at_least, natural_option, positive_option};
use crate::files::toml_words::choice;
use crate::methods::accuracy::AccuracySetting;
use crate::methods::lattice_degree::usual_degree;
use crate::methods::map_refusal::By;
use crate::methods::mapped_characteristics::MappedCharacteristics;
use crate::methods::mapped_samples::{
    MAP_ERROR, MappedSamples, Mapping, check_map_error, check_map_error_over, map_for,
};
use crate::methods::{Method, Misfit};
use kit::assignment::{Assignment, Plane};
use kit::failure::Failure;
use kit::shard::Shard;
use kit::{Form, Passage, Propagator};

/// The least number of characteristics: they span a square at least.
const LEAST_CHARACTERISTICS: usize = 4;

/// What moves by the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SendsChoice {
    /// Random draws from the initial Gaussian.
    #[default]
    Samples,
    /// The points of a lattice, with the density that each carries along.
    Characteristics,
}

/// What a map is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ByChoice {
    /// Cells of the cloud, in each of which the flow is interpolated.
    #[default]
    Cells,
    /// Orbit and time on the orbit: the period is known, and the cost does not grow with the horizon.
    ActionAngle,
}

/// Settings of a flow-map case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// What moves by the map.
    #[serde(deserialize_with = "choice")]
    pub sends: SendsChoice,
    /// What the map is made of.
    #[serde(deserialize_with = "choice")]
    pub by: ByChoice,
    /// Number of samples, or of characteristics: of these the largest square number up to it.
    #[serde(deserialize_with = "at_least::<2, _>")]
    pub samples: usize,
    /// Seed of the samples; 1 unless set.
    #[serde(deserialize_with = "natural_option", skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Degree to which the density is interpolated between characteristics; unless set, it is 7, or the largest that
    /// fits.
    #[serde(deserialize_with = "positive_option", skip_serializing_if = "Option::is_none")]
    pub degree: Option<usize>,
    /// Largest error of the map.
    pub map_error: f64,
    /// How accurately those orbits are propagated that the map leaves; the launch file's `accuracy` unless set here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracySetting>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            sends: SendsChoice::default(),
            by: ByChoice::default(),
            samples: 100_000,
            seed: None,
            degree: None,
            map_error: MAP_ERROR,
            accuracy: None,
        }
    }
}

impl Settings {
    fn degree(&self) -> usize {
        self.degree.unwrap_or_else(|| usual_degree(self.samples.isqrt()))
    }

    fn by(&self) -> By {
        match self.by {
            ByChoice::Cells => By::Cells,
            ByChoice::ActionAngle => By::ActionAngle,
        }
    }

    fn plan(&self) -> SamplingPlan {
        SamplingPlan {
            draws: Draws::Independent,
            seed: self.seed.unwrap_or(1),
            replicates: std::num::NonZeroUsize::MIN,
        }
    }
}

/// The plane of a scenario, which characteristics need.
fn plane(assignment: &Assignment) -> Result<&Plane, Failure> {
    assignment.plane().map_err(|_| {
        let why = "sends = \"characteristics\" is for scenarios in the plane whose radiation parameter is certain; \
                   with samples a flow map takes every scenario";
        Failure::Refused(why.into())
    })
}

impl Method for Settings {
    const NAME: &'static str = "flow-map";
    type Propagator = ByMap;

    fn propagator(self) -> ByMap {
        ByMap { settings: self, shard: Shard::WHOLE, work: None }
    }

    fn check(&self) -> Result<(), Misfit> {
        let Self { sends, samples, seed, degree, map_error, .. } = *self;
        let carries = sends == SendsChoice::Characteristics;
        let side = samples.isqrt();
        check_map_error(map_error)?;
        match () {
            () if seed.is_some() && carries => {
                Err(Misfit::no_effect("seed", "where the points are on a lattice (sends = \"characteristics\")"))
            }
            () if degree.is_some() && !carries => {
                Err(Misfit::no_effect("degree", "unless sends = \"characteristics\""))
            }
            () if carries && samples < LEAST_CHARACTERISTICS => Err(Misfit::new(
                "samples",
                format!("{samples} is not enough for characteristics, it must be at least {LEAST_CHARACTERISTICS}"),
            )),
            () if carries && (self.degree() > MOST_DEGREE || self.degree() >= side) => {
                let (degree, most) = (self.degree(), MOST_DEGREE.min(side - 1));
                Err(Misfit::new(
                    "degree",
                    format!("{degree} does not fit {side} points per side; it must be at most {most}"),
                ))
            }
            () => Ok(()),
        }
    }

    fn check_scenario(&self, assignment: &Assignment, _: Shard) -> Result<(), Failure> {
        match self.sends {
            SendsChoice::Samples => MappedSamples::check(self.by(), &self.plan(), self.map_error, assignment),
            SendsChoice::Characteristics => {
                plane(assignment)?;
                check_map_error_over(self.map_error, assignment)
            }
        }
    }

    fn resolved(&self) -> Self {
        match self.sends {
            SendsChoice::Samples => Self { seed: Some(self.seed.unwrap_or(1)), degree: None, ..self.clone() },
            SendsChoice::Characteristics => Self { degree: Some(self.degree()), seed: None, ..self.clone() },
        }
    }

    fn accuracy_mut(&mut self) -> &mut Option<AccuracySetting> {
        &mut self.accuracy
    }

    fn most_numbers(&self, _: (usize, usize), variables: usize) -> usize {
        let columns = if self.sends == SendsChoice::Characteristics { variables + 1 } else { variables };
        self.samples.saturating_mul(columns)
    }

    fn rows_to_share(&self) -> Result<usize, String> {
        match self.sends {
            SendsChoice::Samples => Ok(self.samples),
            SendsChoice::Characteristics => Ok(self.samples.isqrt().pow(2)),
        }
    }

    fn check_reduce(&self) -> Result<(), String> {
        match self.sends {
            SendsChoice::Samples => Ok(()),
            SendsChoice::Characteristics => Err("characteristics carry a density and are no samples".into()),
        }
    }
}

/// The propagator by a map.
#[derive(Debug)]
pub struct ByMap {
    settings: Settings,
    shard: Shard,
    work: Option<Work>,
}

/// The scenario under way.
#[derive(Debug)]
enum Work {
    Samples(MappedSamples),
    Characteristics(Box<MappedCharacteristics>),
}

impl Propagator for ByMap {
    fn take_shard(&mut self, shard: Shard) -> Result<(), Failure> {
        self.shard = shard;
        Ok(())
    }

    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        let Settings { sends, samples, map_error, accuracy, .. } = self.settings;
        let (by, plan) = (self.settings.by(), self.settings.plan());
        self.work = None;
        let accuracy = accuracy.unwrap_or_default().0;
        let mapping =
            Mapping { by, plan, numbers: 0..samples, accuracy, map: map_for(samples, map_error), passages: true };
        match sends {
            SendsChoice::Samples => {
                let numbers = self.shard.part(samples)?;
                let form = Form { content: Samples::INDEPENDENT.into(), most_rows: numbers.len(), total_rows: samples };
                self.work = Some(Work::Samples(MappedSamples::new(Mapping { numbers, ..mapping }, assignment)?));
                Ok(form)
            }
            SendsChoice::Characteristics => {
                let plane = plane(assignment)?;
                let start = density::mesh::initial_points(&plane.problem, samples, Placement::Lattice, 1)?;
                let range = self.shard.part(start.phi.len())?;
                let work = MappedCharacteristics::new(&plane.problem, start, range, mapping)?;
                let form = work.form(self.settings.degree());
                self.work = Some(Work::Characteristics(Box::new(work)));
                Ok(form)
            }
        }
    }

    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        match self.work.as_mut().ok_or_else(Failure::no_scenario)? {
            Work::Samples(samples) => samples.advance(index),
            Work::Characteristics(work) => work.advance(index),
        }
    }

    fn write(&self, columns: &mut [f64]) {
        match &self.work {
            Some(Work::Samples(samples)) => samples.write(columns),
            Some(Work::Characteristics(work)) => work.write(columns),
            None => {}
        }
    }

    fn reduce(&self, grid: &Grid, critical_e: f64) -> Option<Result<SampleSums, TooFar>> {
        match &self.work {
            Some(Work::Samples(samples)) => Some(samples.reduce(grid, critical_e)),
            _ => None,
        }
    }

    fn trajectories(&self) -> u64 {
        match &self.work {
            Some(Work::Samples(samples)) => samples.orbits() as u64,
            Some(Work::Characteristics(work)) => work.orbits() as u64,
            None => 0,
        }
    }

    fn trajectory_error(&self) -> f64 {
        match &self.work {
            Some(Work::Samples(samples)) => samples.error(),
            Some(Work::Characteristics(work)) => work.error(),
            None => 0.0,
        }
    }

    fn first_passage(&mut self, times: &[f64]) -> Result<Passage, Failure> {
        match self.work.as_ref().ok_or_else(Failure::no_scenario)? {
            Work::Samples(samples) => {
                let (rows, samples) = (Passage::rows(&samples.curve(times)), samples.samples() as u64);
                Ok(Passage::Counted { rows, samples, independent: true })
            }
            Work::Characteristics(_) => Ok(Passage::Cannot(
                "characteristics of a flow map are known at the snapshots alone; sends = \"samples\" has a curve"
                    .into(),
            )),
        }
    }
}

//! Monte Carlo: random draws from the initial Gaussian, each propagated on its own (Sect. 3.1).

use std::num::NonZeroUsize;
use std::ops::Range;

use density::first_passage::empirical::{EmpiricalCurve, curve_of_groups, curve_of_points, point};
use density::first_passage::given::Given;
use density::flow::Passages;
use density::grid::Grid;
use density::in_space::cloud::Cloud;
use density::sample_sums::{SampleSums, TooFar};
use density::sampling::{Draws, SamplingPlan};
use messages::content::Samples;
use messages::layout::{GIVEN_COLUMNS, PASSAGE_TIMES};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::files::toml_words::choice;
use crate::methods::accuracy::AccuracySetting;
use crate::methods::drawing::{Drawing, check_forces};
use crate::methods::mapped_samples::{By, MappedSamples, Mapping, map_for};
use crate::methods::radiation::Radiation;
use crate::methods::sampling_settings::sampling_settings;
use crate::methods::{Method, Misfit};
use kit::assignment::Assignment;
use kit::failure::Failure;
use kit::propagator::given_row;
use kit::shard::Shard;
use kit::{Form, Passage, Propagator};

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

/// The error of a flow map unless it is set.
const MAP_ERROR: f64 = 1e-9;

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
    fn plan(&self) -> SamplingPlan {
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
    fn drawing(&self, range: Range<usize>) -> Drawing {
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
        let is_own = self.model.is_some() || self.forces.is_some();
        match (self.through, self.map_error, is_own) {
            (Through::Orbits, Some(_), _) => Err(Misfit::no_effect("map_error", "unless through = \"flow-map\"")),
            (_, Some(error), _) if !(1e-11..=1e-3).contains(&error) => {
                Err(Misfit::new("map_error", format!("{error} is not allowed, it must be between 1e-11 and 1e-3")))
            }
            (Through::FlowMap, _, true) => Err(Misfit::no_effect(
                if self.model.is_some() { "model" } else { "forces" },
                "beside through = \"flow-map\", which is for scenarios in their own model",
            )),
            _ => Ok(()),
        }
    }

    fn check_scenario(&self, assignment: &Assignment, _: Shard) -> Result<(), Failure> {
        match self.through {
            Through::FlowMap => MappedSamples::check(By::Cells, &self.plan(), assignment),
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

/// The Monte Carlo propagator.
#[derive(Debug)]
pub struct MonteCarlo {
    settings: Settings,
    shard: Shard,
    sample: Option<Sample>,
    /// The samples, if they move by a flow map.
    mapped: Option<MappedSamples>,
    interval_of_replicates: bool,
}

/// The orbits of the scenario under way, and when each first had the critical eccentricity.
#[derive(Debug)]
struct Sample {
    /// Number of the first orbit in the case.
    first: usize,
    cloud: Box<dyn Cloud>,
    /// Position in `curve_times` of the time by which each orbit had passed, or [`PENDING`]. It takes one byte per
    /// orbit, since there may be many orbits.
    points: Vec<u8>,
    curve_times: Vec<f64>,
    times: Vec<f64>,
    critical: f64,
    /// Which variable is an uncertain radiation parameter, if any is.
    radiation: Option<Radiation>,
    /// Where the orbits are \[yr\].
    now: f64,
}

impl Sample {
    fn advance_to(&mut self, time: f64) -> Result<(), Failure> {
        let Self { first, cloud, points, curve_times, critical, now, .. } = self;
        let note = |time| point(time, curve_times) as u8;
        let passages = Passages { passages: points, pending: PENDING, note: &note };
        let moved = cloud.advance_watching(time, *critical, passages);
        moved.map_err(|lost| lost.counted_from(*first))?;
        *now = time;
        Ok(())
    }
}

/// Stands for an orbit that has not passed. No time of the curve has this position.
const PENDING: u8 = u8::MAX;
const _: () = assert!(PASSAGE_TIMES < PENDING as usize);

impl MonteCarlo {
    /// A propagator with these settings.
    pub fn new(settings: Settings) -> Self {
        Self { settings, shard: Shard::WHOLE, sample: None, mapped: None, interval_of_replicates: false }
    }

    /// The samples of these numbers, which move by a flow map.
    fn map(&self, assignment: &Assignment, numbers: Range<usize>) -> Result<MappedSamples, Failure> {
        let Settings { samples, accuracy, map_error, .. } = self.settings;
        let (accuracy, map_error) = (accuracy.unwrap_or_default().0, map_error.unwrap_or(MAP_ERROR));
        let mapping = Mapping {
            by: By::Cells,
            plan: self.settings.plan(),
            numbers,
            accuracy,
            map: map_for(samples, map_error),
            passages: true,
        };
        MappedSamples::new(mapping, assignment)
    }

    /// The curve of the samples and their number.
    fn curve(&self, times: &[f64]) -> Result<(EmpiricalCurve, usize), Failure> {
        if let Some(mapped) = &self.mapped {
            return Ok((mapped.curve(times), mapped.samples()));
        }
        let sample = self.sample.as_ref().ok_or_else(Failure::no_scenario)?;
        if times != sample.curve_times {
            return Err(Failure::Refused("passages are asked for at other times than they were noted for".into()));
        }
        let points = sample.points.iter().map(|&point| usize::from(point));
        let curve = match self.interval_of_replicates {
            true => curve_of_groups(points, self.settings.replicates, times),
            false => curve_of_points(points, times),
        };
        Ok((curve, sample.points.len()))
    }

    /// The same, whose passages have an interval from the spread of the replicates.
    pub(super) fn with_interval_of_replicates(settings: Settings) -> Self {
        Self { interval_of_replicates: true, ..Self::new(settings) }
    }
}

impl Propagator for MonteCarlo {
    fn take_shard(&mut self, shard: Shard) -> Result<(), Failure> {
        self.shard = shard;
        Ok(())
    }

    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        let Settings { samples, replicates, .. } = self.settings;
        let range = self.shard.part(samples)?;
        let (first, most_rows) = (range.start, range.len());
        let replicates = if replicates > 1 { replicates as u32 } else { 0 };
        let form = Form { content: Samples { replicates }.into(), most_rows, total_rows: samples };
        (self.sample, self.mapped) = (None, None);
        if self.settings.through == Through::FlowMap {
            self.mapped = Some(self.map(assignment, range)?);
            return Ok(form);
        }
        let (points, curve_times) = (vec![PENDING; most_rows], assignment.passage_times());
        let (times, critical) = (assignment.times.clone(), assignment.said.critical);
        let cloud = self.settings.drawing(range).cloud(assignment)?;
        let radiation = Radiation::find(&assignment.space);
        self.sample = Some(Sample { first, cloud, points, curve_times, times, critical, radiation, now: 0.0 });
        Ok(form)
    }

    /// Clouds that take long are moved in strides.
    fn approach(&mut self, index: usize) -> Result<Option<f64>, Failure> {
        if self.mapped.is_some() {
            return Ok(None);
        }
        let sample = self.sample.as_mut().ok_or_else(Failure::no_scenario)?;
        let (from, to) = (if index > 0 { sample.times[index - 1] } else { 0.0 }, sample.times[index]);
        let next = sample.cloud.stride().map(|stride| sample.now + stride);
        let Some(next) = next.filter(|next| *next < to) else { return Ok(None) };
        sample.advance_to(next)?;
        Ok(Some((next - from) / (to - from)))
    }

    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        if let Some(mapped) = &mut self.mapped {
            return mapped.advance(index);
        }
        let sample = self.sample.as_mut().ok_or_else(Failure::no_scenario)?;
        sample.advance_to(sample.times[index])?;
        sample.cloud.settle().map_err(|lost| lost.counted_from(sample.first))?;
        Ok(sample.points.len())
    }

    fn write(&self, columns: &mut [f64]) {
        match (&self.sample, &self.mapped) {
            (_, Some(mapped)) => mapped.write(columns),
            (Some(Sample { cloud, .. }), None) => cloud.read_out(columns),
            (None, None) => {}
        }
    }

    fn reduce(&self, grid: &Grid, critical_e: f64) -> Option<Result<SampleSums, TooFar>> {
        self.mapped.as_ref().map(|mapped| mapped.reduce(grid, critical_e))
    }

    fn trajectories(&self) -> u64 {
        self.mapped.as_ref().map_or(0, |mapped| mapped.orbits() as u64)
    }

    fn trajectory_error(&self) -> f64 {
        self.mapped.as_ref().map_or(0.0, MappedSamples::error)
    }

    /// The curve is counted from the same orbits while they are propagated. It has an interval for independent draws, and for replicates
    /// whose spread is asked for.
    fn first_passage(&mut self, times: &[f64]) -> Result<Passage, Failure> {
        let independent = self.settings.draws == DrawsChoice::Independent;
        let (curve, samples) = self.curve(times)?;
        let has_interval = independent || self.interval_of_replicates;
        let curve = EmpiricalCurve { interval: curve.interval.filter(|_| has_interval), ..curve };
        Ok(Passage::Counted { rows: Passage::rows(&curve), samples: samples as u64, independent })
    }

    /// Standard errors are known of independent draws alone. Samples that move by a flow map do not say which of them have passed.
    fn given_re_entry(&self) -> Vec<[f64; GIVEN_COLUMNS]> {
        let Some(Sample { cloud, points, curve_times, radiation: Some(radiation), .. }) = &self.sample else {
            return Vec::new();
        };
        let given = radiation.given_re_entry(&**cloud, points, curve_times.len());
        let is_independent = self.settings.draws == DrawsChoice::Independent;
        let known = |given: Given| if is_independent { given } else { given.without_errors() };
        given.into_iter().map(|events| given_row(events.map(known))).collect()
    }
}

//! Monte Carlo: random draws from the initial Gaussian, each propagated on its own (Sect. 3.1).

use std::fmt::Debug;
use std::num::NonZeroUsize;
use std::ops::Range;

use density::first_passage::empirical::{EmpiricalCurve, curve_of_points, point};
use density::flow::{Accuracy, Flow, Passages};
use density::model::Model;
use density::model::uncertain_radiation::{Scale, UncertainRadiation};
use density::orbits::{LostOrbit, Orbits};
use density::sampling::{Draws, SamplingPlan, draw_variables};
use density::uncertain::{UncertainProblem, UncertainTask};
use messages::content::Samples;
use messages::layout::PASSAGE_TIMES;
use serde::{Deserialize, Serialize};

use crate::files::input::{natural, positive};
use crate::files::toml_words::choice;
use crate::methods::accuracy::AccuracySetting;
use crate::methods::{Method, Misfit};
use kit::assignment::{Assignment, Uncertain};
use kit::failure::Failure;
use kit::shard::Shard;
use kit::{Form, Passage, Propagator};

/// How draws depend on one another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DrawsChoice {
    /// Not at all: independent draws.
    Independent,
    /// In antithetic pairs, which lie opposite one another about the mean.
    Antithetic,
    /// As points of a scrambled Sobol sequence.
    Sobol,
}

/// Settings of a Monte Carlo case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Number of samples.
    #[serde(deserialize_with = "positive")]
    pub samples: usize,
    /// Seed of the draws.
    #[serde(deserialize_with = "natural")]
    pub seed: u64,
    /// How draws depend on one another: independent, antithetic pairs, or a scrambled Sobol sequence.
    #[serde(deserialize_with = "choice")]
    pub draws: DrawsChoice,
    /// Number of independent groups, from whose spread the standard errors follow; 1 is allowed only for independent
    /// draws.
    #[serde(deserialize_with = "positive")]
    pub replicates: usize,
    /// How accurately orbits are propagated; the launch file's `accuracy` unless set here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracySetting>,
}

impl Default for Settings {
    fn default() -> Self {
        Self { samples: 100_000, seed: 1, draws: DrawsChoice::Independent, replicates: 1, accuracy: None }
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
        Ok(())
    }

    fn accuracy_mut(&mut self) -> &mut Option<AccuracySetting> {
        &mut self.accuracy
    }

    fn most_numbers(&self, _: (usize, usize)) -> usize {
        self.samples.saturating_mul(3)
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
}

/// Orbits of any model.
trait Cloud: Debug {
    /// Moves all orbits to a time \[yr\] and notes when each first reached the critical value.
    fn advance_watching(&mut self, time: f64, critical: f64, passages: Passages<'_, u8>) -> Result<(), LostOrbit>;

    /// Writes the variables of all orbits, one column after the other.
    fn read_out(&self, columns: &mut [f64]);
}

impl<M: Model> Cloud for Orbits<M> {
    fn advance_watching(&mut self, time: f64, critical: f64, passages: Passages<'_, u8>) -> Result<(), LostOrbit> {
        Orbits::advance_watching(self, time, critical, passages)
    }

    fn read_out(&self, columns: &mut [f64]) {
        self.read_out_columns(&mut columns.chunks_exact_mut(self.len().max(1)).collect::<Vec<_>>());
    }
}

/// Draws the orbits of some numbers where the radiation parameter is uncertain.
struct Draw<'a> {
    problem: &'a UncertainProblem,
    seed: u64,
    accuracy: Accuracy,
    range: Range<usize>,
}

impl UncertainTask for Draw<'_> {
    type Output = Box<dyn Cloud>;

    fn with<S: Scale>(self, model: UncertainRadiation<S>) -> Box<dyn Cloud> {
        let start = draw_variables(&self.problem.gaussian(), UncertainRadiation::<S>::VARIABLES, self.seed, self.range);
        let flow = Flow { model, accuracy: self.accuracy };
        Box::new(Orbits::from_variables(flow, &start.each_ref().map(Vec::as_slice)))
    }
}

/// Stands for an orbit that has not passed. No time of the curve has this position.
const PENDING: u8 = u8::MAX;
const _: () = assert!(PASSAGE_TIMES < PENDING as usize);

impl MonteCarlo {
    /// A propagator with these settings.
    pub fn new(settings: Settings) -> Self {
        Self { settings, shard: Shard::WHOLE, sample: None }
    }

    /// The orbits of the numbers in `range`.
    fn draw(
        &self,
        assignment: &Assignment,
        range: Range<usize>,
        accuracy: Option<AccuracySetting>,
    ) -> Result<Box<dyn Cloud>, Failure> {
        if let Some(Uncertain { problem, .. }) = &assignment.uncertain {
            if self.settings.draws != DrawsChoice::Independent || self.settings.replicates > 1 {
                let why =
                    "where the radiation parameter is uncertain, mc takes independent draws without replicates alone";
                return Err(Failure::Refused(why.into()));
            }
            let accuracy = accuracy.unwrap_or_default().0;
            return Ok(problem.perform(Draw { problem, seed: self.settings.seed, accuracy, range }));
        }
        let problem = &assignment.plane()?.problem;
        let (x1, x2) = self.settings.plan().draw_range(&problem.initial, range);
        Ok(Box::new(Orbits::new(AccuracySetting::flow(accuracy, problem.model), x1, x2)))
    }
}

impl Propagator for MonteCarlo {
    fn take_shard(&mut self, shard: Shard) -> Result<(), Failure> {
        self.shard = shard;
        Ok(())
    }

    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        let Settings { samples, replicates, accuracy, .. } = self.settings;
        let range = self.shard.part(samples)?;
        let (first, most_rows) = (range.start, range.len());
        let (points, curve_times) = (vec![PENDING; most_rows], assignment.passage_times());
        let (times, critical) = (assignment.times.clone(), assignment.said.critical);
        let cloud = self.draw(assignment, range, accuracy)?;
        self.sample = Some(Sample { first, cloud, points, curve_times, times, critical });
        let replicates = if replicates > 1 { replicates as u32 } else { 0 };
        Ok(Form { content: Samples { replicates }.into(), most_rows, total_rows: samples })
    }

    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        let Sample { first, cloud, points, curve_times, times, critical } =
            self.sample.as_mut().ok_or_else(Failure::no_scenario)?;
        let count = points.len();
        let note = |time| point(time, curve_times) as u8;
        let passages = Passages { passages: points, pending: PENDING, note: &note };
        let moved = cloud.advance_watching(times[index], *critical, passages);
        moved.map_err(|lost| lost.counted_from(*first))?;
        Ok(count)
    }

    fn write(&self, columns: &mut [f64]) {
        if let Some(Sample { cloud, .. }) = &self.sample {
            cloud.read_out(columns);
        }
    }

    /// The curve is counted from the same orbits while they are propagated. It has an interval only for independent
    /// draws.
    fn first_passage(&mut self, times: &[f64]) -> Result<Passage, Failure> {
        let sample = self.sample.as_ref().ok_or_else(Failure::no_scenario)?;
        if times != sample.curve_times {
            return Err(Failure::Refused("passages are asked for at other times than they were noted for".into()));
        }
        let curve = curve_of_points(sample.points.iter().map(|&point| point.into()), times);
        let independent = self.settings.draws == DrawsChoice::Independent;
        let interval = curve.interval.filter(|_| independent);
        let rows = Passage::rows(&EmpiricalCurve { interval, ..curve });
        Ok(Passage::Counted { rows, samples: sample.points.len() as u64, independent })
    }
}

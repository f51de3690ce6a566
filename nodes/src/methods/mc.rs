//! Monte Carlo: random draws from the initial Gaussian, propagated one by one or moved by a flow map (Sect. 3.1). It is
//! the propagator of `qmc` as well.

mod direct_samples;
mod settings;

use std::ops::Range;

use density::first_passage::empirical::{EmpiricalCurve, curve_of_groups, curve_of_points};
use density::first_passage::given::Given;
use density::grid::Grid;
use density::sample_sums::{SampleSums, TooFar};
use kit::assignment::Assignment;
use kit::failure::Failure;
use kit::passage::given_row;
use kit::shard::Shard;
use kit::{Form, Passage, Propagator};
use messages::content::Samples;
use messages::layout::GIVEN_COLUMNS;

use self::direct_samples::{DirectSamples, PENDING};
use crate::methods::map_refusal::By;
use crate::methods::mapped_samples::{MAP_ERROR, MappedSamples, Mapping, map_for};
use crate::methods::radiation::Radiation;

pub use self::settings::{DrawsChoice, Settings, Through};

/// The Monte Carlo propagator.
#[derive(Debug)]
pub struct MonteCarlo {
    settings: Settings,
    shard: Shard,
    /// The samples, if each is propagated on its own.
    direct: Option<DirectSamples>,
    /// The samples, if they move by a flow map.
    mapped: Option<MappedSamples>,
    interval_of_replicates: bool,
}

impl MonteCarlo {
    /// A propagator with these settings.
    pub fn new(settings: Settings) -> Self {
        Self { settings, shard: Shard::WHOLE, direct: None, mapped: None, interval_of_replicates: false }
    }

    /// The same, whose passages have an interval from the spread of the replicates. It takes no shards, since an
    /// interval needs all replicates.
    pub(super) fn with_interval_of_replicates(settings: Settings) -> Self {
        Self { interval_of_replicates: true, ..Self::new(settings) }
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
        let direct = self.direct.as_ref().ok_or_else(Failure::no_scenario)?;
        if times != direct.curve_times {
            return Err(Failure::Refused("passages are asked for at other times than they were noted for".into()));
        }
        let points = direct.points.iter().map(|&point| usize::from(point));
        let curve = match self.interval_of_replicates {
            true => curve_of_groups(points, self.settings.replicates, times),
            false => curve_of_points(points, times),
        };
        Ok((curve, direct.points.len()))
    }
}

impl Propagator for MonteCarlo {
    fn take_shard(&mut self, shard: Shard) -> Result<(), Failure> {
        if self.interval_of_replicates {
            return Err(Failure::no_shards());
        }
        self.shard = shard;
        Ok(())
    }

    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        let Settings { samples, replicates, .. } = self.settings;
        let range = self.shard.part(samples)?;
        let (first, most_rows) = (range.start, range.len());
        let replicates = if replicates > 1 { replicates as u32 } else { 0 };
        let form = Form { content: Samples { replicates }.into(), most_rows, total_rows: samples };
        (self.direct, self.mapped) = (None, None);
        if self.settings.through == Through::FlowMap {
            self.mapped = Some(self.map(assignment, range)?);
            return Ok(form);
        }
        let (points, curve_times) = (vec![PENDING; most_rows], assignment.passage_times());
        let (times, critical) = (assignment.times.clone(), assignment.description.critical);
        let cloud = self.settings.drawing(range).cloud(assignment)?;
        let radiation = Radiation::find(&assignment.space);
        self.direct = Some(DirectSamples { first, cloud, points, curve_times, times, critical, radiation, now: 0.0 });
        Ok(form)
    }

    /// Clouds that take long are moved in strides.
    fn approach(&mut self, index: usize) -> Result<Option<f64>, Failure> {
        if self.mapped.is_some() {
            return Ok(None);
        }
        let direct = self.direct.as_mut().ok_or_else(Failure::no_scenario)?;
        let (from, to) = (if index > 0 { direct.times[index - 1] } else { 0.0 }, direct.times[index]);
        let next = direct.cloud.stride().map(|stride| direct.now + stride);
        let Some(next) = next.filter(|next| *next < to) else { return Ok(None) };
        direct.advance_to(next)?;
        Ok(Some((next - from) / (to - from)))
    }

    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        if let Some(mapped) = &mut self.mapped {
            return mapped.advance(index);
        }
        let direct = self.direct.as_mut().ok_or_else(Failure::no_scenario)?;
        direct.advance_to(direct.times[index])?;
        direct.cloud.settle().map_err(|lost| lost.counted_from(direct.first))?;
        Ok(direct.points.len())
    }

    fn write(&self, columns: &mut [f64]) {
        match (&self.direct, &self.mapped) {
            (_, Some(mapped)) => mapped.write(columns),
            (Some(DirectSamples { cloud, .. }), None) => cloud.read_out(columns),
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

    /// The curve is counted from the same orbits while they are propagated. It has an interval for independent draws,
    /// and for replicates whose spread is asked for.
    fn first_passage(&mut self, times: &[f64]) -> Result<Passage, Failure> {
        let independent = self.settings.draws == DrawsChoice::Independent;
        let (curve, samples) = self.curve(times)?;
        let has_interval = independent || self.interval_of_replicates;
        let curve = EmpiricalCurve { interval: curve.interval.filter(|_| has_interval), ..curve };
        Ok(Passage::Counted { rows: Passage::rows(&curve), samples: samples as u64, independent })
    }

    /// Standard errors are known of independent draws alone. Samples that move by a flow map do not say which of them
    /// have passed.
    fn given_re_entry(&self) -> Vec<[f64; GIVEN_COLUMNS]> {
        let Some(DirectSamples { cloud, points, curve_times, radiation: Some(radiation), .. }) = &self.direct else {
            return Vec::new();
        };
        let given = radiation.given_re_entry(&**cloud, points, curve_times.len());
        let is_independent = self.settings.draws == DrawsChoice::Independent;
        let known = |given: Given| if is_independent { given } else { given.without_errors() };
        given.into_iter().map(|events| given_row(events.map(known))).collect()
    }
}

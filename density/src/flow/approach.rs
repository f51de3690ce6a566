//! How near orbits come to re-entry: the least clearance on their way.

use rayon::prelude::*;

use super::carry::{Batch, Carry, Step, Watch};
use super::threshold::{Passages, Threshold};
use super::{CHUNK, Flow, chunks};
use crate::model::Model;

/// Number of places of a step at which the clearance is read. A step is about 0.4 rad of the Sun, so the least of them
/// is within about 1e-4 of the least clearance of the step.
const PLACES: usize = 8;

/// Notes the least clearance of every orbit.
struct Approach<'a> {
    lowest: &'a mut [f64],
}

impl Watch for Approach<'_> {
    fn sees_clearance(&self) -> bool {
        true
    }

    fn see(&mut self, &Step { clearance, lengths, crew, .. }: &Step<'_>) {
        for (lane, &length) in lengths.iter().enumerate() {
            let Some(lowest) = crew.orbit[lane].and_then(|orbit| self.lowest.get_mut(orbit)) else { continue };
            for place in 0..=PLACES {
                let time = length * place as f64 / PLACES as f64;
                let value = clearance.iter().rev().fold(0.0, |sum, lanes| sum * time + lanes[lane]);
                *lowest = lowest.min(value);
            }
        }
    }
}

/// Two observers of the same orbits.
struct Both<'a>(&'a mut dyn Watch, &'a mut dyn Watch);

impl Watch for Both<'_> {
    fn sees_clearance(&self) -> bool {
        self.0.sees_clearance() || self.1.sees_clearance()
    }

    fn see(&mut self, step: &Step<'_>) {
        self.0.see(step);
        self.1.see(step);
    }
}

impl<M: Model> Flow<M> {
    /// Like [`Flow::carry_where_possible`], forwards in time. Notes when each orbit first reaches the critical value of
    /// the re-entry variable, in `times`, which is infinite before, and lowers `lowest` to its least clearance. Of an
    /// orbit that cannot be followed, all is NaN but the time of a passage before.
    ///
    /// # Panics
    /// As [`Flow::carry`], or if there is not one time and one clearance for every orbit.
    pub(crate) fn carry_approaching(
        &self,
        columns: &mut [&mut [f64]],
        (from, to): (f64, f64),
        critical: f64,
        times: &mut [f64],
        lowest: &mut [f64],
    ) {
        assert!(columns.iter().all(|column| column.len() == times.len() && times.len() == lowest.len()));
        let critical = self.model.critical_clearance(critical);
        let notes = times.par_chunks_mut(CHUNK).zip(lowest.par_chunks_mut(CHUNK));
        chunks::<M>(columns).into_par_iter().zip(notes).for_each(|(mut columns, (times, lowest))| {
            let note = |time: f64| time;
            let passages = Passages { passages: &mut *times, pending: f64::INFINITY, note: &note };
            let mut threshold = Threshold { critical, end: to, passages };
            let mut approach = Approach { lowest: &mut *lowest };
            let mut watch = Both(&mut threshold, &mut approach);
            let batch = Batch { columns: &mut columns, from, years: &[to - from] };
            for (lost, _) in self.model.carry(Carry { accuracy: self.accuracy, batch, watch: Some(&mut watch) }) {
                columns.iter_mut().for_each(|column| column[lost] = f64::NAN);
                // One that has passed before is known to have passed.
                times[lost] = if times[lost].is_finite() { times[lost] } else { f64::NAN };
                lowest[lost] = f64::NAN;
            }
        });
    }

    /// The same without the least clearances.
    ///
    /// # Panics
    /// As [`Flow::carry`], or if there is not one time for every orbit.
    pub(crate) fn carry_passing(
        &self,
        columns: &mut [&mut [f64]],
        (from, to): (f64, f64),
        critical: f64,
        times: &mut [f64],
    ) {
        assert!(columns.iter().all(|column| column.len() == times.len()));
        let critical = self.model.critical_clearance(critical);
        let pieces = chunks::<M>(columns).into_par_iter().zip(times.par_chunks_mut(CHUNK));
        pieces.for_each(|(mut columns, times)| {
            let note = |time: f64| time;
            let passages = Passages { passages: &mut *times, pending: f64::INFINITY, note: &note };
            let mut watch = Threshold { critical, end: to, passages };
            let batch = Batch { columns: &mut columns, from, years: &[to - from] };
            for (lost, _) in self.model.carry(Carry { accuracy: self.accuracy, batch, watch: Some(&mut watch) }) {
                columns.iter_mut().for_each(|column| column[lost] = f64::NAN);
                times[lost] = if times[lost].is_finite() { times[lost] } else { f64::NAN };
            }
        });
    }
}

//! Reduces samples part by part, whole batches at once and the rest one by one.

use super::by_batch::Accumulator;
use super::{Frame, Question, SampleSums, TooFar};
use crate::grid::Grid;
use crate::lanes::BATCH;

/// Reduces samples part by part.
#[derive(Debug)]
pub struct Reducer {
    sums: SampleSums,
    accumulator: Accumulator,
}

impl Reducer {
    /// For samples on a grid.
    pub fn new(grid: &Grid, critical_e: f64) -> Self {
        Self::in_frame(Frame::of(grid), grid, critical_e)
    }

    pub(super) fn in_frame(frame: Frame, grid: &Grid, critical_e: f64) -> Self {
        let accumulator = Accumulator::new(Question { frame, grid: *grid, critical_e });
        Self { sums: SampleSums::empty(grid.len()), accumulator }
    }

    /// Takes more samples.
    ///
    /// # Errors
    /// [`TooFar`] names a sample that cannot be summed.
    ///
    /// # Panics
    /// If `phi` and `e` differ in length.
    pub fn take(&mut self, phi: &[f64], e: &[f64]) -> Result<(), TooFar> {
        assert_eq!(phi.len(), e.len(), "one phi for every e");
        let ((phi, last_phi), (e, last_e)) = (phi.as_chunks::<BATCH>(), e.as_chunks::<BATCH>());
        for (phi, e) in phi.iter().zip(e) {
            if !self.accumulator.take(phi, e, &mut self.sums) {
                self.take_each(phi, e)?;
            }
        }
        self.take_each(last_phi, last_e)
    }

    /// Takes samples one by one.
    fn take_each(&mut self, phi: &[f64], e: &[f64]) -> Result<(), TooFar> {
        phi.iter().zip(e).try_for_each(|(&phi, &e)| self.sums.take(self.accumulator.question(), phi, e))
    }

    /// The sums of all samples.
    pub fn finish(mut self) -> SampleSums {
        self.accumulator.add_to(&mut self.sums);
        self.sums
    }
}

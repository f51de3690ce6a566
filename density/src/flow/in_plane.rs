//! The flow of a planar model, on the slices `x1` and `x2`.
//!
//! The motion does not depend on time, so only the length of an interval matters.

use super::carry::{Batch, Carry};
use super::record::{Recorder, Step};
use super::threshold::Passages;
use super::{Escaped, Flow};
use crate::model::Model;
use crate::model::plane::{PlanarHamiltonian, State};

impl<M: PlanarHamiltonian> Flow<M> {
    /// Moves the orbits `(x1[i], x2[i])` by `years`, backwards if negative, on all threads of the current rayon pool.
    ///
    /// # Errors
    /// [`Escaped`] names the first orbit that cannot be continued; the slices then hold no meaningful states.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn advance(&self, x1: &mut [f64], x2: &mut [f64], years: f64) -> Result<(), Escaped> {
        self.carry(&mut [x1, x2], 0.0, years)
    }

    /// Like [`Flow::advance`], from `from` to `to` \[yr\], and notes when each orbit first has `e >= critical_e`, to
    /// the accuracy of the flow.
    ///
    /// # Errors
    /// As [`Flow::advance`].
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn advance_watching<T: Copy + PartialEq + Send + Sync>(
        &self,
        x1: &mut [f64],
        x2: &mut [f64],
        interval: (f64, f64),
        critical_e: f64,
        passages: Passages<'_, T>,
    ) -> Result<(), Escaped> {
        self.carry_watching(&mut [x1, x2], interval, critical_e, passages)
    }

    /// Moves the orbits `(x1[i], x2[i])` by `years[i]` each.
    ///
    /// # Errors
    /// [`Escaped`] names the first orbit that cannot be continued; the slices then hold no meaningful states.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn advance_each(&self, x1: &mut [f64], x2: &mut [f64], years: &[f64]) -> Result<(), Escaped> {
        assert!(x1.len() == x2.len() && x1.len() == years.len(), "one x1 and one interval for every x2");
        self.carry_batch(Batch { columns: &mut [x1, x2], from: 0.0, years }, 0, None)
    }

    /// Like [`Flow::advance`], but an orbit that cannot be continued ends as NaN instead of stopping the others. A
    /// backward orbit from a point outside a cloud may reach `e >= 1` before `t = 0`; the density is zero there.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn advance_where_possible(&self, x1: &mut [f64], x2: &mut [f64], years: f64) {
        self.carry_where_possible(&mut [x1, x2], 0.0, years);
    }

    /// Moves one orbit by `years`.
    ///
    /// # Errors
    /// [`Escaped`] if it cannot be followed.
    pub fn advance_one(&self, state: State, years: f64) -> Result<State, Escaped> {
        self.carry_one(state, 0.0, years)
    }

    /// The orbits that start at `states`, each followed for `years[i]` > 0 and recorded step by step, with their final
    /// states; `None` for an orbit that cannot be followed.
    pub(crate) fn record(&self, states: &[State], years: &[f64]) -> Vec<Option<(Vec<Step>, State)>> {
        let (mut x1, mut x2): (Vec<f64>, Vec<f64>) = states.iter().map(|state| (state.x1, state.x2)).unzip();
        let mut recorder = Recorder { steps: vec![Vec::new(); states.len()] };
        let batch = Batch { columns: &mut [&mut x1, &mut x2], from: 0.0, years };
        let lost = self.model.carry(Carry { accuracy: self.accuracy, batch, watch: Some(&mut recorder) });
        let mut recorded: Vec<_> = (recorder.steps.into_iter().zip(x1.iter().zip(&x2)))
            .map(|(steps, (&x1, &x2))| Some((steps, State { x1, x2 })))
            .collect();
        lost.into_iter().for_each(|(orbit, _)| recorded[orbit] = None);
        recorded
    }
}

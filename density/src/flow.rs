//! The flow: many orbits moved forward or backward in time by one batched Taylor-series integrator, whatever the model.
//!
//! | file | idea |
//! |---|---|
//! | `carry` | what is asked of the integrator and what it tells |
//! | `taylor` | the integrator: lanes, steps, which orbit enters a lane and which has arrived |
//! | `step_size` | how far a series reaches |
//! | `accuracy` | how accurately orbits are propagated |
//! | [`equations`], `from_equations` | the series of a model, made from the model's equations of motion |
//! | `runge_kutta` | steps of models whose equations are not smooth, in the place of a series |
//! | `threshold` | first passages, read off the series |
//! | `approach` | how near orbits come to re-entry |
//! | `record` | orbits kept step by step |
//! | `in_plane` | the same for planar models, with the orbits in two slices |

mod accuracy;
mod approach;
pub(crate) mod carry;
pub mod equations;
mod from_equations;
mod in_plane;
pub(crate) mod record;
mod runge_kutta;
mod step_size;
mod taylor;
mod threshold;

use carry::{Batch, Watch};
use rayon::prelude::*;
use threshold::Threshold;

pub use accuracy::Accuracy;
pub use carry::{Carry, Loss};
pub use from_equations::FromEquations;
pub use runge_kutta::{Edged, RungeKutta};
pub use threshold::Passages;

use crate::model::variable::Place;
use crate::model::{Coordinates, Model};

/// Number of orbits that a thread takes at a time.
const CHUNK: usize = 1024;

/// The flow of a model: moves orbits in time. Orbits are given as columns, one per coordinate of the model's state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flow<M> {
    /// The model that drives the flow.
    pub model: M,
    /// How accurately orbits are propagated.
    pub accuracy: Accuracy,
}

/// An orbit could not be followed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("orbit {index} {why} within {years} yr of the state {place}")]
pub struct Escaped {
    /// Index of the orbit among those given.
    pub index: usize,
    /// Why it could not be followed.
    pub why: Loss,
    /// Length of the interval \[yr\].
    pub years: f64,
    /// Where the orbit was at the start of the interval.
    pub place: Place,
}

impl<M: Model> Flow<M> {
    /// The flow of `model` at the default accuracy.
    pub fn new(model: M) -> Self {
        Self { model, accuracy: Accuracy::default() }
    }

    /// Moves orbits from `from` to `to` \[yr\], backwards if `to` is earlier, on all threads of the current rayon pool.
    ///
    /// # Errors
    /// [`Escaped`] names the first orbit that cannot be continued; the columns then hold no meaningful states.
    ///
    /// # Panics
    /// If there is not one column for every coordinate, or if they differ in length.
    pub fn carry(&self, columns: &mut [&mut [f64]], from: f64, to: f64) -> Result<(), Escaped> {
        chunks::<M>(columns)
            .into_par_iter()
            .enumerate()
            .map(|(chunk, mut columns)| {
                let batch = Batch { columns: &mut columns, from, years: &[to - from] };
                self.carry_batch(batch, chunk * CHUNK, None)
            })
            .reduce(|| Ok(()), Result::and)
    }

    /// Like [`Flow::carry`], and notes when each orbit's re-entry variable first reaches `critical` or goes beyond it,
    /// to the accuracy of the flow.
    ///
    /// # Errors
    /// As [`Flow::carry`].
    ///
    /// # Panics
    /// As [`Flow::carry`], if there is not one passage for every orbit, or if `to` is before `from`.
    pub fn carry_watching<T: Copy + PartialEq + Send + Sync>(
        &self,
        columns: &mut [&mut [f64]],
        (from, to): (f64, f64),
        critical: f64,
        Passages { passages, pending, note }: Passages<'_, T>,
    ) -> Result<(), Escaped> {
        assert!(columns.iter().all(|column| column.len() == passages.len()), "one passage for every orbit");
        assert!(from <= to, "passages are noted forwards in time");
        let critical = self.model.critical_clearance(critical);
        chunks::<M>(columns)
            .into_par_iter()
            .zip(passages.par_chunks_mut(CHUNK))
            .enumerate()
            .map(|(chunk, (mut columns, passages))| {
                let mut watch = Threshold { critical, end: to, passages: Passages { passages, pending, note } };
                let batch = Batch { columns: &mut columns, from, years: &[to - from] };
                self.carry_batch(batch, chunk * CHUNK, Some(&mut watch))
            })
            .reduce(|| Ok(()), Result::and)
    }

    /// Like [`Flow::carry`], but an orbit that cannot be continued ends as NaN instead of stopping the others. A
    /// backward orbit from a point outside a cloud may have no start at all; the density is zero there.
    ///
    /// # Panics
    /// As [`Flow::carry`].
    pub fn carry_where_possible(&self, columns: &mut [&mut [f64]], from: f64, to: f64) {
        chunks::<M>(columns).into_par_iter().for_each(|mut columns| {
            let batch = Batch { columns: &mut columns, from, years: &[to - from] };
            for (lost, _) in self.model.carry(Carry { accuracy: self.accuracy, batch, watch: None }) {
                columns.iter_mut().for_each(|column| column[lost] = f64::NAN);
            }
        });
    }

    /// Moves one orbit from `from` to `to` \[yr\].
    ///
    /// # Errors
    /// [`Escaped`] if it cannot be followed.
    pub fn carry_one(&self, state: M::State<f64>, from: f64, to: f64) -> Result<M::State<f64>, Escaped> {
        let mut values: Vec<[f64; 1]> = (0..M::State::<f64>::COUNT).map(|k| [state.component(k)]).collect();
        let mut columns: Vec<&mut [f64]> = values.iter_mut().map(|value| value.as_mut_slice()).collect();
        let batch = Batch { columns: &mut columns, from, years: &[to - from] };
        self.carry_batch(batch, 0, None)?;
        Ok(Coordinates::from_fn(|k| values[k][0]))
    }

    /// Moves a batch of orbits, the first of which has the number `first`; the error names the first orbit that is
    /// lost.
    fn carry_batch(&self, batch: Batch<'_, '_>, first: usize, watch: Option<&mut dyn Watch>) -> Result<(), Escaped> {
        let Batch { columns, from, years } = batch;
        let batch = Batch { columns, from, years };
        let lost = self.model.carry(Carry { accuracy: self.accuracy, batch, watch }).into_iter().min();
        lost.map_or(Ok(()), |(lost, why)| {
            let start = self.model.read_out(from, Coordinates::from_fn(|k| columns[k][lost]));
            let years = years[lost.min(years.len() - 1)];
            let place = Place::new(M::VARIABLES, |k| start.component(k));
            Err(Escaped { index: first + lost, why, years, place })
        })
    }
}

/// Columns of orbits, cut into pieces that a thread takes at a time.
fn chunks<'a, M: Model>(columns: &'a mut [&mut [f64]]) -> Vec<Vec<&'a mut [f64]>> {
    assert_eq!(columns.len(), M::State::<f64>::COUNT, "one column for every coordinate");
    let rows = columns[0].len();
    assert!(columns.iter().all(|column| column.len() == rows), "columns of the same length");
    let mut pieces: Vec<Vec<&mut [f64]>> = (0..rows.div_ceil(CHUNK)).map(|_| Vec::new()).collect();
    for column in columns {
        pieces.iter_mut().zip(column.chunks_mut(CHUNK)).for_each(|(piece, chunk)| piece.push(chunk));
    }
    pieces
}

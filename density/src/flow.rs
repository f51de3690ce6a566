//! The flow: many orbits moved forward or backward in time by one batched Taylor-series integrator (`flow/taylor.rs`).

pub(crate) mod record;
mod taylor;
mod threshold;

use rayon::prelude::*;
use record::{Recorder, Step};
use taylor::Watch;
use threshold::Threshold;

pub use taylor::Loss;
pub use threshold::Passages;

use crate::dynamics::{Force, State};

/// Orbits a thread takes at a time.
const CHUNK: usize = 1024;

/// How accurately orbits are propagated: the largest error of `x1` or `x2` after two years in the paper's scenarios. It
/// grows about linearly with time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Accuracy {
    /// 1e-6: enough for pictures.
    Coarse,
    /// 1e-9: far below any sampling error.
    Medium,
    /// 1e-12; the Hamiltonian is kept as well.
    #[default]
    Fine,
}

impl Accuracy {
    /// All, the coarsest first.
    pub const ALL: [Self; 3] = [Self::Coarse, Self::Medium, Self::Fine];

    /// The largest error.
    pub fn largest_error(self) -> f64 {
        match self {
            Self::Coarse => 1e-6,
            Self::Medium => 1e-9,
            Self::Fine => 1e-12,
        }
    }
}

/// The flow of a force: moves orbits in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flow {
    /// The force that drives it.
    pub force: Force,
    /// How accurately.
    pub accuracy: Accuracy,
}

/// An orbit could not be followed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("orbit {index} {why} within {years} yr of the state phi = {phi} rad, e = {e}")]
pub struct Escaped {
    /// Which of the orbits given.
    pub index: usize,
    /// Why.
    pub why: Loss,
    /// Length of the interval \[yr\].
    pub years: f64,
    /// Solar angle at the start of the interval \[rad\].
    pub phi: f64,
    /// Eccentricity at the start of the interval.
    pub e: f64,
}

impl Flow {
    /// The flow of `force` at the default accuracy.
    pub fn new(force: Force) -> Self {
        Self { force, accuracy: Accuracy::default() }
    }

    /// Moves the orbits `(x1[i], x2[i])` by `years`, backwards if negative, on all threads of the current rayon pool.
    ///
    /// # Errors
    /// [`Escaped`] names the first orbit that cannot be continued; the slices then hold no meaningful states.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn advance(&self, x1: &mut [f64], x2: &mut [f64], years: f64) -> Result<(), Escaped> {
        assert_eq!(x1.len(), x2.len(), "one x1 for every x2");
        x1.par_chunks_mut(CHUNK)
            .zip(x2.par_chunks_mut(CHUNK))
            .enumerate()
            .map(|(chunk, (x1, x2))| self.advance_chunk(x1, x2, &[years], chunk * CHUNK))
            .reduce(|| Ok(()), Result::and)
    }

    /// As [`Flow::advance`], from `from` to `to` \[yr\], and notes when each orbit first has `e >= critical_e`, to the
    /// accuracy of the flow.
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
        (from, to): (f64, f64),
        critical_e: f64,
        Passages { passages, pending, note }: Passages<'_, T>,
    ) -> Result<(), Escaped> {
        assert!(x1.len() == x2.len() && x1.len() == passages.len(), "one x1 and one passage for every x2");
        let critical_s = ((1.0 - critical_e) * (1.0 + critical_e)).sqrt();
        x1.par_chunks_mut(CHUNK)
            .zip(x2.par_chunks_mut(CHUNK))
            .zip(passages.par_chunks_mut(CHUNK))
            .enumerate()
            .map(|(chunk, ((x1, x2), passages))| {
                let mut watch = Threshold { critical_s, end: to, passages: Passages { passages, pending, note } };
                self.advance_chunk_watched(x1, x2, &[to - from], chunk * CHUNK, &mut watch)
            })
            .reduce(|| Ok(()), Result::and)
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
        self.advance_chunk(x1, x2, years, 0)
    }

    /// As [`Flow::advance`], but an orbit that cannot be continued ends as NaN instead of stopping the others. Backward
    /// orbits from outside a cloud may have come from nowhere (`e >= 1`), where the density is zero.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn advance_where_possible(&self, x1: &mut [f64], x2: &mut [f64], years: f64) {
        assert_eq!(x1.len(), x2.len(), "one x1 for every x2");
        x1.par_chunks_mut(CHUNK).zip(x2.par_chunks_mut(CHUNK)).for_each(|(x1, x2)| {
            for (lost, _) in self.integrate(x1, x2, &[years], &mut ()) {
                (x1[lost], x2[lost]) = (f64::NAN, f64::NAN);
            }
        });
    }

    /// The orbits that start at `states`, each followed for `years[i]` > 0 and recorded step by step, and where each ends;
    /// `None` for an orbit that cannot be followed.
    pub(crate) fn record(&self, states: &[State], years: &[f64]) -> Vec<Option<(Vec<Step>, State)>> {
        let (mut x1, mut x2): (Vec<f64>, Vec<f64>) = states.iter().map(|state| (state.x1, state.x2)).unzip();
        let mut recorder = Recorder { steps: vec![Vec::new(); states.len()] };
        let lost = self.integrate(&mut x1, &mut x2, years, &mut recorder);
        let mut recorded: Vec<_> = (recorder.steps.into_iter().zip(x1.iter().zip(&x2)))
            .map(|(steps, (&x1, &x2))| Some((steps, State { x1, x2 })))
            .collect();
        lost.into_iter().for_each(|(orbit, _)| recorded[orbit] = None);
        recorded
    }

    /// Moves one orbit by `years`.
    ///
    /// # Errors
    /// [`Escaped`] if it leaves the domain.
    pub fn advance_one(&self, state: State, years: f64) -> Result<State, Escaped> {
        let (mut x1, mut x2) = ([state.x1], [state.x2]);
        self.advance_chunk(&mut x1, &mut x2, &[years], 0)?;
        Ok(State { x1: x1[0], x2: x2[0] })
    }

    /// Moves orbits, the first of which is number `first`, and names the first that is lost.
    fn advance_chunk(&self, x1: &mut [f64], x2: &mut [f64], years: &[f64], first: usize) -> Result<(), Escaped> {
        self.advance_chunk_watched(x1, x2, years, first, &mut ())
    }

    fn advance_chunk_watched(
        &self,
        x1: &mut [f64],
        x2: &mut [f64],
        years: &[f64],
        first: usize,
        watch: &mut impl Watch,
    ) -> Result<(), Escaped> {
        let lost = self.integrate(x1, x2, years, watch).into_iter().min();
        lost.map_or(Ok(()), |(lost, why)| {
            let start = State { x1: x1[lost], x2: x2[lost] };
            let years = years[lost.min(years.len() - 1)];
            Err(Escaped { index: first + lost, why, years, phi: start.solar_angle(), e: start.eccentricity() })
        })
    }

    /// Moves orbits by their `years`, or all by the last of them, and returns which were lost; those stay where they were.
    /// The largest error after two years is about 14 tolerances in a cloud of 1e5 orbits and 24 among orbits four standard
    /// deviations from the mean, whatever the order; the orders are the cheapest by measurement, if not by much.
    fn integrate<W: Watch>(&self, x1: &mut [f64], x2: &mut [f64], years: &[f64], watch: &mut W) -> Vec<(usize, Loss)> {
        match self.accuracy {
            Accuracy::Coarse => taylor::advance::<12, W>(self.force, x1, x2, years, 4e-8, watch),
            Accuracy::Medium => taylor::advance::<15, W>(self.force, x1, x2, years, 3.5e-11, watch),
            Accuracy::Fine => taylor::advance::<19, W>(self.force, x1, x2, years, 3.5e-14, watch),
        }
    }
}

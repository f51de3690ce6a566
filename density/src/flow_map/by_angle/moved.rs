//! A set of orbits that moves by action and angle from snapshot to snapshot.
//!
//! Each start is found in the tables once. Up to [`KEPT`] spots are kept; more are found again at every snapshot, so
//! that memory does not grow with their number. Each value depends on its own start alone: results are the same bytes
//! for any number of threads.

use std::fmt;
use std::ops::Range;

use rayon::prelude::*;

use super::AngleMap;
use super::panel::Spot;
use crate::angle::fold;
use crate::first_passage::empirical::point;
use crate::flow_map::draw::{Draw, numbers_of};
use crate::flow_map::left::Left;
use crate::grid::Grid;
use crate::model::plane::{PlanarHamiltonian, State};
use crate::orbits::LostOrbit;
use crate::sample_sums::{Reducer, SampleSums, TooFar};

/// Number of starts that a thread takes at a time.
const CHUNK: usize = 8192;
/// Largest number of spots that are kept, of 24 bytes each.
const KEPT: usize = 1 << 24;

/// A start on its panel; `None` if it is propagated directly.
type Found = Option<(u32, Spot)>;

/// Orbits on their way by a map.
pub struct AngleOrbits<M> {
    map: AngleMap<M>,
    draw: Draw<2>,
    numbers: Range<usize>,
    pub(super) kept: Option<Vec<Vec<Found>>>,
    left: Left<M>,
    index: usize,
}

impl<M: PlanarHamiltonian> fmt::Debug for AngleOrbits<M> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { numbers, left, index, .. } = self;
        write!(f, "AngleOrbits {{ {numbers:?}, {} directly, at snapshot {index} }}", left.len())
    }
}

impl<M: PlanarHamiltonian> AngleOrbits<M> {
    /// The orbits of these numbers, at the start.
    pub fn new(map: AngleMap<M>, numbers: Range<usize>, draw: Draw<2>) -> Self {
        let keeps = numbers.len() <= KEPT;
        let found = |chunk: usize| {
            let found = find(&map, &draw, &numbers, chunk);
            let left = (0..found.len()).filter(|&row| found[row].is_none()).map(|row| chunk * CHUNK + row);
            let left: Vec<usize> = left.collect();
            (keeps.then_some(found), left)
        };
        let chunks = numbers.len().div_ceil(CHUNK);
        let (kept, left): (Vec<_>, Vec<Vec<usize>>) = (0..chunks).into_par_iter().map(found).unzip();
        let left = Left::new(map.flow, numbers.start, left.concat(), &draw);
        Self { kept: kept.into_iter().collect(), map, draw, numbers, left, index: 0 }
    }

    /// The map by which they move.
    pub fn map(&self) -> &AngleMap<M> {
        &self.map
    }

    /// Number of orbits.
    pub fn len(&self) -> usize {
        self.numbers.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }

    /// Number of orbits that are propagated directly.
    pub fn direct(&self) -> usize {
        self.left.len()
    }

    /// Moves all orbits to snapshot `index`, the next one.
    ///
    /// # Errors
    /// [`LostOrbit`] names the first orbit that cannot be followed.
    pub fn advance_watching(&mut self, index: usize, critical: f64) -> Result<(), LostOrbit> {
        self.index = index;
        self.left.advance_watching(self.map.times[index], critical)
    }

    /// Writes the solar angles and eccentricities of all orbits at the snapshot that has been reached.
    ///
    /// # Panics
    /// If a column is not as long as there are orbits.
    pub fn read_out_columns(&self, phi: &mut [f64], e: &mut [f64]) {
        assert!(phi.len() == self.len() && e.len() == self.len(), "room for every orbit");
        let chunks = phi.par_chunks_mut(CHUNK).zip(e.par_chunks_mut(CHUNK)).enumerate();
        chunks.for_each(|(chunk, (phi, e))| self.read_out_chunk(chunk, phi, e));
    }

    fn read_out_chunk(&self, chunk: usize, phi: &mut [f64], e: &mut [f64]) {
        if self.index == 0 {
            return self.read_out_starts(chunk, phi, e);
        }
        let time = self.map.times[self.index];
        self.with_found(chunk, |row, found| {
            let Some((number, spot)) = found else { return };
            let panel = &self.map.panels[number as usize];
            let state: State = panel.state(panel.later(spot, time));
            (phi[row], e[row]) = (state.solar_angle(), state.eccentricity());
        });
        self.left.read_out(time, self.places_of(chunk), |row, variables| [phi[row], e[row]] = variables);
    }

    /// Writes the starts of a chunk as they were drawn: a state next to `e = 0` that went through the tables would have
    /// lost its angle.
    fn read_out_starts(&self, chunk: usize, phi: &mut [f64], e: &mut [f64]) {
        let starts = (self.draw)(numbers_of(&self.numbers, CHUNK, chunk));
        for (row, [start_phi, start_e]) in starts.into_iter().enumerate() {
            (phi[row], e[row]) = (fold(start_phi, 0.0), start_e);
        }
    }

    /// Calls `work` with the row and the spot of every start of a chunk.
    fn with_found(&self, chunk: usize, mut work: impl FnMut(usize, Found)) {
        let mut all = |found: &[Found]| found.iter().enumerate().for_each(|(row, &found)| work(row, found));
        match &self.kept {
            Some(kept) => all(&kept[chunk]),
            None => all(&find(&self.map, &self.draw, &self.numbers, chunk)),
        }
    }

    /// The places of a chunk, counted from the first orbit.
    fn places_of(&self, chunk: usize) -> Range<usize> {
        chunk * CHUNK..self.len().min((chunk + 1) * CHUNK)
    }

    /// Reduces the orbits, at the snapshot that has been reached, to sums, chunk by chunk.
    ///
    /// # Errors
    /// [`TooFar`] names an orbit that cannot be summed.
    pub fn reduce(&self, grid: &Grid, critical: f64) -> Result<SampleSums, TooFar> {
        let begun = || (Reducer::new(grid, critical), [vec![0.0; CHUNK], vec![0.0; CHUNK]]);
        let reduced = |(mut reducer, mut columns): (Reducer, [Vec<f64>; 2]), chunk| {
            let rows = self.places_of(chunk).len();
            let [phi, e] = columns.each_mut().map(|column| &mut column[..rows]);
            self.read_out_chunk(chunk, phi, e);
            reducer.take(phi, e)?;
            Ok((reducer, columns))
        };
        let parts = (0..self.len().div_ceil(CHUNK)).into_par_iter().try_fold(begun, reduced);
        parts.map(|part| Ok(part?.0.finish())).try_reduce(|| SampleSums::empty(grid.len()), SampleSums::plus)
    }

    /// For each of `times`, how many orbits first reached the critical eccentricity with which the map was made after
    /// the time before it and up to this one. Orbits that are propagated directly are counted only up to the snapshot
    /// that has been reached.
    pub fn passage_counts(&self, times: &[f64]) -> Vec<u64> {
        let chunk_counts = |chunk: usize| {
            let mut counts = vec![0u64; times.len() + 1];
            let mut note = |time: f64| counts[point(time, times)] += 1;
            if let Some(critical) = self.map.critical {
                self.with_found(chunk, |_, found| {
                    let Some((number, spot)) = found else { return };
                    note(self.map.panels[number as usize].passage(spot, critical));
                });
            }
            self.left.passages_in(self.places_of(chunk), |_, time| note(time));
            counts
        };
        let add = |mut sums: Vec<u64>, counts: Vec<u64>| {
            sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
            sums
        };
        let chunks = (0..self.len().div_ceil(CHUNK)).into_par_iter();
        let mut counts = chunks.map(chunk_counts).reduce(|| vec![0; times.len() + 1], add);
        counts.truncate(times.len());
        counts
    }
}

/// The starts of a chunk on their panels.
fn find<M: PlanarHamiltonian>(map: &AngleMap<M>, draw: &Draw<2>, numbers: &Range<usize>, chunk: usize) -> Vec<Found> {
    draw(numbers_of(numbers, CHUNK, chunk)).iter().map(|&[phi, e]| map.locate(State::from_polar(phi, e))).collect()
}

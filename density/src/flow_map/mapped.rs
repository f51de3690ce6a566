//! A set of orbits that moves by a flow map from snapshot to snapshot.
//!
//! Starts are drawn by their number and taken in chunks. In a chunk they are sorted by the cell in which they lie, so
//! that the polynomials of a cell are evaluated at many starts side by side. A start that lies in no cell is propagated
//! directly, with the others of its kind. Up to [`KEPT`] starts are kept from snapshot to snapshot; more are drawn
//! again, so that memory does not grow with their number. Each value depends on its own start alone: results are the
//! same bytes for any number of threads.

use std::fmt;
use std::ops::Range;

use rayon::prelude::*;

use super::FlowMap;
use super::chebyshev::evaluate;
use super::draw::{Draw, numbers_of};
use super::left::Left;
use super::passing::Passing;
use crate::angle::fold;
use crate::first_passage::empirical::point;
use crate::grid::Grid;
use crate::model::{Coordinates, LANES, Lanes, Model};
use crate::orbits::LostOrbit;
use crate::sample_sums::{Reducer, SampleSums, TooFar};

/// Number of starts that a thread takes at a time.
const CHUNK: usize = 32_768;
/// Largest number of starts that are kept: with two variables they take 20 bytes each.
const KEPT: usize = 1 << 24;

/// Orbits on their way by a map.
pub struct MappedOrbits<M, const N: usize> {
    map: FlowMap<M, N>,
    draw: Draw<N>,
    numbers: Range<usize>,
    pub(super) kept: Option<Vec<Sorted<N>>>,
    /// The orbits that are propagated directly.
    left: Left<M>,
    index: usize,
}

impl<M: Model, const N: usize> fmt::Debug for MappedOrbits<M, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { numbers, left, index, .. } = self;
        write!(f, "MappedOrbits {{ {numbers:?}, {} directly, at snapshot {index} }}", left.len())
    }
}

/// The starts of a chunk that lie in cells, sorted by cell.
#[derive(Debug)]
pub(super) struct Sorted<const N: usize> {
    /// Each cell that has starts, with their number.
    runs: Vec<(u32, u32)>,
    /// Their local coordinates.
    local: [Vec<f64>; N],
    /// Their places in the chunk.
    places: Vec<u32>,
}

impl<M: Model, const N: usize> MappedOrbits<M, N> {
    /// The orbits of these numbers, at the start.
    pub fn new(map: FlowMap<M, N>, numbers: Range<usize>, draw: Draw<N>) -> Self {
        let keeps = numbers.len() <= KEPT;
        let sorted = |chunk: usize| {
            let (sorted, direct) = sort(&map, &draw, numbers_of(&numbers, CHUNK, chunk));
            (keeps.then_some(sorted), direct.into_iter().map(|place| chunk * CHUNK + place as usize).collect())
        };
        let chunks = numbers.len().div_ceil(CHUNK);
        let (kept, direct): (Vec<_>, Vec<Vec<usize>>) = (0..chunks).into_par_iter().map(sorted).unzip();
        let left = Left::new(map.flow, numbers.start, direct.concat(), &draw);
        Self { kept: kept.into_iter().collect(), map, draw, numbers, left, index: 0 }
    }

    /// The map by which they move.
    pub fn map(&self) -> &FlowMap<M, N> {
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

    /// Moves all orbits to snapshot `index`, the next one, and notes when the orbits that are propagated directly first
    /// reach the critical value.
    ///
    /// # Errors
    /// [`LostOrbit`] names the first orbit that cannot be followed.
    pub fn advance_watching(&mut self, index: usize, critical: f64) -> Result<(), LostOrbit> {
        self.index = index;
        self.left.advance_watching(self.map.times[index], critical)
    }

    /// Writes the variables of all orbits at the snapshot that has been reached, one column per variable.
    ///
    /// # Panics
    /// If there is not one column for every variable, or one is not as long as there are orbits.
    pub fn read_out_columns(&self, columns: &mut [&mut [f64]]) {
        assert_eq!(columns.len(), N, "one column for every variable");
        assert!(columns.iter().all(|column| column.len() == self.len()), "room for every orbit");
        let mut pieces: Vec<Vec<&mut [f64]>> = (0..self.len().div_ceil(CHUNK)).map(|_| Vec::new()).collect();
        for column in columns {
            pieces.iter_mut().zip(column.chunks_mut(CHUNK)).for_each(|(piece, chunk)| piece.push(chunk));
        }
        pieces.par_iter_mut().enumerate().for_each(|(chunk, columns)| self.read_out_chunk(chunk, columns));
    }

    /// Writes the variables of the orbits of one chunk.
    fn read_out_chunk(&self, chunk: usize, columns: &mut [&mut [f64]]) {
        self.with_sorted(chunk, |sorted| {
            self.evaluate(sorted, |range, variables| {
                for (column, values) in columns.iter_mut().zip(variables) {
                    let places = &sorted.places[range.clone()];
                    places.iter().zip(values).for_each(|(&place, &value)| column[place as usize] = value);
                }
            });
        });
        self.left.read_out(self.map.times[self.index], self.places_of(chunk), |row, variables| {
            columns.iter_mut().enumerate().for_each(|(k, column)| column[row] = variables.component(k));
        });
    }

    /// Makes `columns` the variables of the orbits of one chunk, sorted by cell.
    fn read_out_sorted(&self, chunk: usize, columns: &mut [Vec<f64>; N]) {
        columns.iter_mut().for_each(Vec::clear);
        self.with_sorted(chunk, |sorted| {
            self.evaluate(sorted, |range, variables| {
                let pairs = columns.iter_mut().zip(variables);
                pairs.for_each(|(column, values)| column.extend_from_slice(&values[..range.len()]));
            });
        });
        self.left.read_out(self.map.times[self.index], self.places_of(chunk), |_, variables| {
            columns.iter_mut().enumerate().for_each(|(k, column)| column.push(variables.component(k)));
        });
    }

    /// The places of a chunk, counted from the first orbit.
    fn places_of(&self, chunk: usize) -> Range<usize> {
        chunk * CHUNK..self.len().min((chunk + 1) * CHUNK)
    }

    /// Does something with the sorted starts of a chunk, kept or drawn again.
    fn with_sorted<T>(&self, chunk: usize, work: impl FnOnce(&Sorted<N>) -> T) -> T {
        match &self.kept {
            Some(kept) => work(&kept[chunk]),
            None => work(&sort(&self.map, &self.draw, numbers_of(&self.numbers, CHUNK, chunk)).0),
        }
    }

    /// Calls `write` with the variables of up to [`LANES`] orbits at the snapshot that has been reached, and where they
    /// are among the sorted ones.
    fn evaluate(&self, sorted: &Sorted<N>, mut write: impl FnMut(Range<usize>, &[Lanes; N])) {
        let mut states = vec![[0.0; LANES]; M::State::<f64>::COUNT];
        let mut variables = [[0.0; LANES]; N];
        let (index, time) = (self.index, self.map.times[self.index]);
        sorted.for_lanes(|cell, point, range| {
            if index == 0 {
                self.at_start(cell, point, &mut variables);
            } else {
                evaluate(self.map.states(cell, index), point, &mut states);
                self.map.flow.model.read_out_lanes(time, &states, &mut variables);
            }
            write(range, &variables);
        });
    }

    /// The variables at the start.
    fn at_start(&self, cell: u32, point: &[Lanes; N], variables: &mut [Lanes; N]) {
        for l in 0..LANES {
            let local = std::array::from_fn(|k| point[k][l]);
            let values = self.map.gaussian.point(self.map.cells[cell as usize].cell.point(&local));
            for (k, variable) in M::VARIABLES.iter().enumerate() {
                variables[k][l] = if variable.is_circle() { fold(values[k], 0.0) } else { values[k] };
            }
        }
    }

    /// For each of `times`, how many orbits first reached the critical value after the time before it and up to this
    /// one. Orbits that are propagated directly are counted only up to the snapshot that has been reached.
    pub fn passage_counts(&self, times: &[f64]) -> Vec<u64> {
        let chunk_counts = |chunk: usize| {
            let mut counts = vec![0u64; times.len() + 1];
            self.passages_in(chunk, |_, time| counts[point(time, times)] += 1);
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

    /// Calls `note` with the place in a chunk and the time of passage of the orbits that pass.
    fn passages_in(&self, chunk: usize, mut note: impl FnMut(usize, f64)) {
        self.with_sorted(chunk, |sorted| {
            let mut value = [[0.0; LANES]];
            sorted.for_lanes(|cell, at, range| {
                let Passing::At(polynomial) = &self.map.cells[cell as usize].passing else { return };
                evaluate(std::slice::from_ref(polynomial), at, &mut value);
                sorted.places[range].iter().zip(&value[0]).for_each(|(&place, &time)| note(place as usize, time));
            });
        });
        self.left.passages_in(self.places_of(chunk), note);
    }
}

impl<M: Model, const N: usize> MappedOrbits<M, N> {
    /// Reduces the first two variables of the orbits, at the snapshot that has been reached, to sums, chunk by chunk.
    ///
    /// # Errors
    /// [`TooFar`] names an orbit that cannot be summed.
    pub fn reduce(&self, grid: &Grid, critical: f64) -> Result<SampleSums, TooFar> {
        let begun = || (Reducer::new(grid, critical), std::array::from_fn(|_| Vec::new()));
        let reduced = |(mut reducer, mut columns): (Reducer, [Vec<f64>; N]), chunk| {
            self.read_out_sorted(chunk, &mut columns);
            reducer.take(&columns[0], &columns[1])?;
            Ok((reducer, columns))
        };
        let parts = (0..self.len().div_ceil(CHUNK)).into_par_iter().try_fold(begun, reduced);
        parts.map(|part| Ok(part?.0.finish())).try_reduce(|| SampleSums::empty(grid.len()), SampleSums::plus)
    }
}

impl<const N: usize> Sorted<N> {
    /// Calls `work` with each cell, the local coordinates of up to [`LANES`] starts in it, and where they are among the
    /// sorted ones.
    fn for_lanes(&self, mut work: impl FnMut(u32, &[Lanes; N], Range<usize>)) {
        let mut next = 0;
        for &(cell, count) in &self.runs {
            let end = next + count as usize;
            while next < end {
                let several = next..end.min(next + LANES);
                let mut point = [[0.0; LANES]; N];
                for (lanes, local) in point.iter_mut().zip(&self.local) {
                    lanes[..several.len()].copy_from_slice(&local[several.clone()]);
                }
                next = several.end;
                work(cell, &point, several);
            }
        }
    }
}

/// Draws the starts of a chunk and sorts them by cell; also returns the places of those that lie in none.
fn sort<M: Model, const N: usize>(map: &FlowMap<M, N>, draw: &Draw<N>, numbers: Range<usize>) -> (Sorted<N>, Vec<u32>) {
    let points: Vec<[f64; N]> = draw(numbers).into_iter().map(|start| map.gaussian.standardise(&start)).collect();
    let cells: Vec<u32> = points.iter().map(|point| map.tree.locate(point)).collect();
    let mut next = vec![0u32; map.cells.len()];
    let mut direct = Vec::new();
    for (place, cell) in cells.iter().enumerate() {
        match next.get_mut(*cell as usize) {
            Some(count) => *count += 1,
            None => direct.push(place as u32),
        }
    }
    let counts = next.iter().enumerate().filter(|(_, count)| **count > 0);
    let runs: Vec<(u32, u32)> = counts.map(|(cell, &count)| (cell as u32, count)).collect();
    let mut sum = 0;
    next.iter_mut().for_each(|count| {
        let first = sum;
        sum += *count;
        *count = first;
    });
    let mut local: [Vec<f64>; N] = std::array::from_fn(|_| vec![0.0; sum as usize]);
    let mut places = vec![0; sum as usize];
    for (place, (&cell, point)) in cells.iter().zip(&points).enumerate() {
        let Some(next) = next.get_mut(cell as usize) else { continue };
        let at = map.cells[cell as usize].locals.of(point);
        (0..N).for_each(|k| local[k][*next as usize] = at[k]);
        places[*next as usize] = place as u32;
        *next += 1;
    }
    (Sorted { runs, local, places }, direct)
}

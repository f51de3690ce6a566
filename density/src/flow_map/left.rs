//! The orbits that a map leaves to direct propagation.

use std::ops::Range;

use super::draw::Draw;
use crate::flow::{Flow, Passages};
use crate::model::{Coordinates, Model};
use crate::orbits::{LostOrbit, Orbits};

/// Those orbits of a set that are propagated one by one.
pub(super) struct Left<M> {
    /// The number of the set's first orbit.
    first: usize,
    /// Their numbers, counted from the first orbit of the set, in ascending order.
    places: Vec<usize>,
    orbits: Orbits<M>,
    /// When each has passed \[yr\].
    passages: Vec<f64>,
}

impl<M: Model> Left<M> {
    /// The orbits at these places of a set whose first orbit has the number `first`.
    pub fn new<const N: usize>(flow: Flow<M>, first: usize, places: Vec<usize>, draw: &Draw<N>) -> Self {
        let starts: Vec<[f64; N]> = places.iter().flat_map(|&place| draw(first + place..first + place + 1)).collect();
        let columns: [Vec<f64>; N] = std::array::from_fn(|k| starts.iter().map(|start| start[k]).collect());
        let orbits = Orbits::from_variables(flow, &columns.each_ref().map(Vec::as_slice));
        let passages = vec![f64::INFINITY; places.len()];
        Self { first, places, orbits, passages }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Moves them to `time` \[yr\] and notes when they first reach the critical value.
    pub fn advance_watching(&mut self, time: f64, critical: f64) -> Result<(), LostOrbit> {
        let note = |time| time;
        let passages = Passages { passages: &mut self.passages, pending: f64::INFINITY, note: &note };
        let moved = self.orbits.advance_watching(time, critical, passages);
        moved.map_err(|lost| LostOrbit { index: self.first + self.places[lost.index], ..lost })
    }

    /// Calls `write` with the row in the chunk and the variables at `time`, where they are, of those in it.
    pub fn read_out(&self, time: f64, chunk: Range<usize>, mut write: impl FnMut(usize, M::Variables)) {
        for position in self.positions(&chunk) {
            let state = Coordinates::from_fn(|k| self.orbits.columns()[k][position]);
            write(self.places[position] - chunk.start, self.orbits.flow.model.read_out(time, state));
        }
    }

    /// Calls `note` with the row in the chunk and the time of passage of those in it.
    pub fn passages_in(&self, chunk: Range<usize>, mut note: impl FnMut(usize, f64)) {
        self.positions(&chunk).for_each(|position| note(self.places[position] - chunk.start, self.passages[position]));
    }

    /// The positions of those that lie in a chunk.
    fn positions(&self, chunk: &Range<usize>) -> Range<usize> {
        let position = |place: usize| self.places.partition_point(|&number| number < place);
        position(chunk.start)..position(chunk.end)
    }
}

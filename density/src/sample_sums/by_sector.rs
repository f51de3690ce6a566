//! Gathers samples and adds them up sector by sector.
//!
//! The samples of a sector are brought side by side, so that many of them are added up at once and no sum is looked up
//! for a single sample.

use multiversion::multiversion;

use super::halves::Halves;
use super::{SECTOR_SUMS, SECTORS, Sector};
use crate::lanes::{BATCH, Batch};

/// Batches that are gathered before they are added up: as many as the cache of a core holds with them brought side by
/// side.
const GATHERED: usize = 128;
/// Room for a sector's samples is rounded up to a multiple of this, since a remainder that fills no vector is slow.
/// Unused places hold 0, which adds nothing.
const WIDE: usize = 8;

/// A batch of samples.
#[derive(Debug, Clone, Copy)]
pub(super) struct Samples {
    pub s: Batch,
    pub t: Batch,
    pub sectors: [u8; BATCH],
}

const NONE: Samples = Samples { s: [0.0; BATCH], t: [0.0; BATCH], sectors: [0; BATCH] };

/// Samples that have not been added up.
#[derive(Debug)]
pub(super) struct Gathered {
    /// Room for batches, of which those that have been taken come first.
    batches: Vec<Samples>,
    /// Number of batches that have been taken.
    taken: usize,
    /// The samples, side by side where they are of the same sector.
    s: Vec<f64>,
    t: Vec<f64>,
}

impl Gathered {
    pub fn new() -> Self {
        Self { batches: Vec::new(), taken: 0, s: Vec::new(), t: Vec::new() }
    }

    /// Room for the next batch.
    pub fn next(&mut self) -> &mut Samples {
        if self.batches.len() == self.taken {
            self.batches.push(NONE);
        }
        &mut self.batches[self.taken]
    }

    /// Takes the batch that was written into the room for the next one; adds them all up if there are many.
    pub fn take(&mut self, sectors: &mut [Sector]) {
        self.taken += 1;
        if self.taken == GATHERED {
            self.add_up(sectors);
        }
    }

    /// Adds all samples to the sums of their sectors.
    pub fn add_up(&mut self, sectors: &mut [Sector]) {
        let mut counts = [0usize; SECTORS];
        self.batches[..self.taken]
            .iter()
            .flat_map(|batch| &batch.sectors)
            .for_each(|&sector| counts[usize::from(sector)] += 1);
        self.sort(&counts);
        let mut first = 0;
        for (sector, &count) in sectors.iter_mut().zip(&counts).filter(|(_, count)| **count > 0) {
            let places = first..first + count.next_multiple_of(WIDE);
            first = places.end;
            sector.samples += count as u64;
            let sums = sums_of(&self.s[places.clone()], &self.t[places.clone()]);
            sector.sums.iter_mut().zip(&sums).for_each(|(sum, halves)| *sum += halves.total(places.len()));
        }
        self.taken = 0;
    }

    /// Brings the samples of each sector, of which there are so many, side by side.
    fn sort(&mut self, counts: &[usize; SECTORS]) {
        let mut next = [0; SECTORS];
        let mut places = 0;
        for (next, count) in next.iter_mut().zip(counts) {
            *next = places;
            places += count.next_multiple_of(WIDE);
        }
        for column in [&mut self.s, &mut self.t] {
            column.clear();
            column.resize(places, 0.0);
        }
        for batch in &self.batches[..self.taken] {
            for l in 0..BATCH {
                let place = &mut next[usize::from(batch.sectors[l])];
                (self.s[*place], self.t[*place]) = (batch.s[l], batch.t[l]);
                *place += 1;
            }
        }
    }
}

/// The sums of the samples of a sector, see [`SECTOR_SUMS`].
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
fn sums_of(s: &[f64], t: &[f64]) -> [Halves; SECTOR_SUMS] {
    let mut sums = [Halves::NONE; SECTOR_SUMS];
    for (&s, &t) in s.iter().zip(t) {
        let (s2, t2) = (s * s, t * t);
        let terms = [s, s2, s2 * s, s2 * s2, t, t2, s * t, s2 * t, s * t2, s2 * t2];
        for k in 0..SECTOR_SUMS {
            sums[k].add(terms[k]);
        }
    }
    sums
}

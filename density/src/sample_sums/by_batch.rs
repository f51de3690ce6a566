//! Reduces samples, a batch at a time.
//!
//! What does not depend on the sector of a sample is counted and summed at once; the rest is
//! [gathered](super::by_sector). What is done with each sample is written as a loop over the batch without branches,
//! which the compiler turns into vectors.

use std::f64::consts::{PI, TAU};

use multiversion::multiversion;

use super::by_sector::{Gathered, Samples};
use super::halves::Halves;
use super::{COMMON_SUMS, Question, REACH, SECTORS, SECTORS_PER_RADIAN, SampleSums};
use crate::grid::by_batch;
use crate::lanes::{BATCH, Batch, LARGEST_ANGLE, sin_cos, whole_number};

/// Most batches that are counted in numbers of 32 bits.
const MOST: usize = u32::MAX as usize / BATCH;

/// Sums under way.
#[derive(Debug)]
pub(super) struct Accumulator {
    question: Question,
    /// Batches that have been taken.
    batches: usize,
    above: u64,
    counts: Vec<u32>,
    common: [i128; COMMON_SUMS],
    seen: Seen,
    gathered: Gathered,
}

/// What a batch of samples is, beside its [`Samples`].
#[derive(Debug)]
struct Seen {
    /// The bin of each.
    bins: [usize; BATCH],
    /// How many are above the critical eccentricity.
    above: u64,
    common: [Halves; COMMON_SUMS],
}

/// The same bits as [`nearest`](crate::angle::nearest) to 0 gives, for an angle less than one and a half turns from 0.
#[inline(always)]
fn nearest_to_zero(offset: f64) -> f64 {
    let from_low = offset + PI;
    let folded = if from_low >= TAU { from_low - TAU } else { from_low + TAU } - PI;
    let folded = if folded >= TAU - PI { -PI } else { folded };
    if (-PI..PI).contains(&offset) { offset } else { folded }
}

/// The sector of an angle from the grid's centre, as [`sector_of`](super::sector_of) finds it.
#[inline(always)]
fn sector_near(offset: f64) -> u8 {
    let position = (offset + PI) * SECTORS_PER_RADIAN;
    whole_number(position.trunc().min(SECTORS as f64 - 1.0)) as u8
}

/// Looks at a batch of samples; false, and what was seen says nothing, if one of them needs closer attention.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
fn look(question: &Question, phi: &Batch, e: &Batch, samples: &mut Samples, seen: &mut Seen) -> bool {
    let (frame, grid, critical_e) = (question.frame, question.grid, question.critical_e);
    let (mut common, mut above, mut are_plain) = ([Halves::NONE; COMMON_SUMS], 0, true);
    for l in 0..BATCH {
        let from_centre = phi[l] - frame.phi;
        let offset = nearest_to_zero(from_centre);
        let (s, t) = (offset / frame.half_phi, (e[l] - frame.e) / frame.half_e);
        let is_near = s.abs() <= REACH && t.abs() <= REACH && phi[l].abs() <= LARGEST_ANGLE;
        let (bin, is_known) = by_batch::bin(&grid, phi[l], e[l]);
        are_plain &= is_near & is_known & (-TAU..2.0 * TAU).contains(&(from_centre + PI));
        let ((sin, cos), t2) = (sin_cos(phi[l]), t * t);
        let terms = [sin, cos, t2 * t, t2 * t2];
        for k in 0..COMMON_SUMS {
            common[k].add(terms[k]);
        }
        (samples.s[l], samples.t[l], samples.sectors[l]) = (s, t, sector_near(offset));
        seen.bins[l] = bin;
        above += u64::from(e[l] > critical_e);
    }
    (seen.common, seen.above) = (common, above);
    are_plain
}

impl Accumulator {
    pub fn new(question: Question) -> Self {
        let common = [Halves::NONE; COMMON_SUMS];
        Self {
            batches: 0,
            above: 0,
            counts: vec![0; question.grid.len()],
            question,
            common: [0; COMMON_SUMS],
            seen: Seen { bins: [0; BATCH], above: 0, common },
            gathered: Gathered::new(),
        }
    }

    /// Adds a batch of samples, the sums of sectors to those of `sums`; false, and nothing is added, if one of them
    /// needs closer attention.
    pub fn take(&mut self, phi: &Batch, e: &Batch, sums: &mut SampleSums) -> bool {
        let seen = &mut self.seen;
        if !look(&self.question, phi, e, self.gathered.next(), seen) {
            return false;
        }
        self.batches += 1;
        self.above += seen.above;
        self.common.iter_mut().zip(&seen.common).for_each(|(sum, halves)| *sum += halves.total(BATCH));
        by_batch::add(&mut self.counts, &seen.bins);
        self.gathered.take(&mut sums.sectors);
        if self.batches == MOST {
            self.add_to(sums);
        }
        true
    }

    /// Adds all that has not been added yet to the sums.
    pub fn add_to(&mut self, sums: &mut SampleSums) {
        sums.samples += (self.batches * BATCH) as u64;
        sums.above += self.above;
        sums.counts.iter_mut().zip(&self.counts).for_each(|(sum, count)| *sum += u64::from(*count));
        sums.common.iter_mut().zip(&self.common).for_each(|(sum, part)| *sum += part);
        self.gathered.add_up(&mut sums.sectors);
        (self.batches, self.above, self.common) = (0, 0, [0; COMMON_SUMS]);
        self.counts.fill(0);
    }

    pub fn question(&self) -> &Question {
        &self.question
    }
}

#[cfg(test)]
mod tests {
    use super::super::sector_of;
    use super::*;
    use crate::angle::nearest;

    #[test]
    fn an_angle_is_brought_next_to_zero_as_everywhere_else() {
        for k in -9400..9400 {
            for offset in [f64::from(k) * 1e-3, f64::from(k / 3000) * PI, (f64::from(k / 3000) * PI).next_up()] {
                if (-TAU..2.0 * TAU).contains(&(offset + PI)) {
                    let nearest = if (-PI..PI).contains(&offset) { offset } else { nearest(offset, 0.0) };
                    assert_eq!(nearest_to_zero(offset).to_bits(), nearest.to_bits(), "{offset}");
                }
            }
        }
    }

    #[test]
    fn a_sector_is_found_as_everywhere_else() {
        for k in -256..256 {
            let edge = f64::from(k) * TAU / 512.0;
            for offset in [edge, edge.next_up(), edge.next_down(), PI.next_down()] {
                let offset = offset.clamp(-PI, PI);
                assert_eq!(usize::from(sector_near(offset)), sector_of(offset), "{offset}");
            }
        }
    }
}

//! Reduces samples, in any number of parts, to the sums from which their density and moments follow.
//!
//! A part of the samples becomes counts and sums of powers; parts are added, and only the whole becomes an estimate.
//! Each term is rounded to a whole number of [`UNIT`]s, and adding whole numbers is exact. So the estimate is the same
//! bytes whatever the parts, threads or order of the samples.
//!
//! With the comparison grid's centre as origin and its half widths as units,
//!
//! ```text
//! s = (phi - phi_c)/h_phi,   t = (e - e_c)/h_e,     S_jk = Σ s^j t^k  for j, k <= 2, j <= 4 and k <= 4
//! ```
//!
//! a cloud that fills its grid has `s` and `t` of order one, so central moments by shifting the origin lose few digits
//! (`μ_20 = a_20 - a_10²` and so on, `a_jk = S_jk/n`; Kendall & Stuart, *The Advanced Theory of Statistics* 1, 1977,
//! Chapter 3).
//!
//! | file | idea |
//! |---|---|
//! | `halves` | the whole numbers in which is summed, in two halves of 64 bits |
//! | `reducer` | samples in parts: whole batches at once, the rest one by one |
//! | `by_batch` | a batch of samples |
//! | `by_sector` | samples gathered by sector, and the sums of a sector |
//! | `branch` | sums on the branch of `phi` around the circular mean |
//! | `finish` | density, moments and standard errors from the sums of all samples |

mod branch;
mod by_batch;
mod by_sector;
mod finish;
mod halves;
mod reducer;
#[cfg(test)]
mod tests;

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use crate::angle::nearest;
use crate::grid::{Axis, Grid};
use crate::lanes::{LARGEST_ANGLE, sin_cos};

pub use finish::estimate;
pub use reducer::Reducer;

/// Number of sectors of the circle.
pub const SECTORS: usize = 256;
/// Sectors per radian.
const SECTORS_PER_RADIAN: f64 = SECTORS as f64 / TAU;
/// Number of sums of a sector: `s, s², s³, s⁴, t, t², st, s²t, st², s²t²`.
pub const SECTOR_SUMS: usize = 10;
/// Number of sums over all samples: `sin(phi), cos(phi), t³, t⁴`.
pub const COMMON_SUMS: usize = 4;
/// The unit of the sums, which are whole numbers of it.
const UNIT: f64 = 1.0 / (1u64 << 60) as f64;
/// Distance from the grid's centre, in half widths of the grid, within which a sample must lie for its terms to be
/// summed: 2^76 units at most.
const REACH: f64 = 16.0;
/// Number of samples that a thread takes at a time.
const CHUNK: usize = 65_536;
const _: () = assert!(SECTORS <= 1 << u8::BITS, "the number of a sector is a byte");

/// Samples reduced to counts and sums.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SampleSums {
    /// Number of samples.
    pub samples: u64,
    /// Number of samples above the critical eccentricity.
    pub above: u64,
    /// Number of samples in each bin of the grid.
    pub counts: Vec<u64>,
    /// Sums over all samples, see [`COMMON_SUMS`].
    pub common: [i128; COMMON_SUMS],
    /// Sums of each sector; the first sector is at the lower end of the grid's branch.
    pub sectors: Vec<Sector>,
}

/// The samples of a sector.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Sector {
    /// Number of samples.
    pub samples: u64,
    /// Their sums, see [`SECTOR_SUMS`].
    pub sums: [i128; SECTOR_SUMS],
}

/// A sample too far from the grid to be summed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("phi = {phi} rad, e = {e} lies more than {REACH} half widths of the comparison grid from its centre")]
pub struct TooFar {
    /// Solar angle \[rad\].
    pub phi: f64,
    /// Eccentricity.
    pub e: f64,
}

/// Origin and units of the sums.
#[derive(Debug, Clone, Copy)]
struct Frame {
    phi: f64,
    e: f64,
    half_phi: f64,
    half_e: f64,
}

impl Frame {
    fn of(grid: &Grid) -> Self {
        let half = |axis: &Axis| 0.5 * (axis.high - axis.low);
        Self {
            phi: grid.phi.low.midpoint(grid.phi.high),
            e: grid.e.low.midpoint(grid.e.high),
            half_phi: half(&grid.phi),
            half_e: half(&grid.e),
        }
    }
}

/// How samples are reduced.
#[derive(Debug, Clone, Copy)]
struct Question {
    frame: Frame,
    grid: Grid,
    critical_e: f64,
}

/// A value, rounded to whole units.
fn units(value: f64) -> i128 {
    let scaled = (value / UNIT).round_ties_even();
    // This is the common case, and much the quicker one.
    if scaled.abs() < i64::MAX as f64 { i128::from(scaled as i64) } else { scaled as i128 }
}

impl SampleSums {
    /// The sums of no samples, on a grid of `bins` bins.
    pub fn empty(bins: usize) -> Self {
        Self {
            samples: 0,
            above: 0,
            counts: vec![0; bins],
            common: [0; COMMON_SUMS],
            sectors: vec![Sector::default(); SECTORS],
        }
    }

    /// Reduces samples.
    ///
    /// # Errors
    /// [`TooFar`] names a sample that cannot be summed.
    ///
    /// # Panics
    /// If `phi` and `e` differ in length.
    pub fn reduce(phi: &[f64], e: &[f64], grid: &Grid, critical_e: f64) -> Result<Self, TooFar> {
        Self::reduce_in(Frame::of(grid), phi, e, grid, critical_e)
    }

    fn reduce_in(frame: Frame, phi: &[f64], e: &[f64], grid: &Grid, critical_e: f64) -> Result<Self, TooFar> {
        assert_eq!(phi.len(), e.len(), "one phi for every e");
        let begun = || Reducer::in_frame(frame, grid, critical_e);
        let reduced = |mut reducer: Reducer, (phi, e): (&[f64], &[f64])| {
            reducer.take(phi, e)?;
            Ok(reducer)
        };
        let parts = phi.par_chunks(CHUNK).zip(e.par_chunks(CHUNK)).try_fold(begun, reduced);
        parts.map(|part| Ok(part?.finish())).try_reduce(|| Self::empty(grid.len()), Self::plus)
    }

    /// With the sums of another part on the same grid.
    pub(crate) fn plus(mut self, other: Self) -> Result<Self, TooFar> {
        self.add(&other);
        Ok(self)
    }

    /// Adds a sample.
    fn take(&mut self, question: &Question, phi: f64, e: f64) -> Result<(), TooFar> {
        let Question { frame, grid, critical_e } = question;
        let offset = phi - frame.phi;
        let offset = if (-PI..PI).contains(&offset) { offset } else { nearest(offset, 0.0) };
        let (s, t) = (offset / frame.half_phi, (e - frame.e) / frame.half_e);
        if !(phi.is_finite() && s.abs() <= REACH && t.abs() <= REACH) {
            return Err(TooFar { phi, e });
        }
        self.samples += 1;
        grid.bin(phi, e).into_iter().for_each(|bin| self.counts[bin] += 1);
        self.above += u64::from(e > *critical_e);
        // The same sine and cosine as of many samples side by side.
        let is_usual = phi.abs() <= LARGEST_ANGLE;
        let (sin, cos) = if is_usual { sin_cos(phi) } else { phi.sin_cos() };
        let (s2, t2) = (s * s, t * t);
        let add = |sums: &mut [i128], terms: &[f64]| {
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += units(*term));
        };
        add(&mut self.common, &[sin, cos, t2 * t, t2 * t2]);
        let sector = &mut self.sectors[sector_of(offset)];
        sector.samples += 1;
        add(&mut sector.sums, &[s, s2, s2 * s, s2 * s2, t, t2, s * t, s2 * t, s * t2, s2 * t2]);
        Ok(())
    }

    /// Adds the sums of another part on the same grid.
    pub fn add(&mut self, other: &Self) {
        self.samples += other.samples;
        self.above += other.above;
        self.counts.iter_mut().zip(&other.counts).for_each(|(sum, count)| *sum += count);
        self.common.iter_mut().zip(&other.common).for_each(|(sum, term)| *sum += term);
        self.sectors.iter_mut().zip(&other.sectors).for_each(|(sum, sector)| sum.add(sector));
    }
}

impl Sector {
    fn add(&mut self, other: &Self) {
        self.samples += other.samples;
        self.sums.iter_mut().zip(&other.sums).for_each(|(sum, term)| *sum += term);
    }
}

/// The sector of an angle in `[-π, π)` from the grid's centre.
fn sector_of(offset: f64) -> usize {
    (((offset + PI) * SECTORS_PER_RADIAN) as usize).min(SECTORS - 1)
}

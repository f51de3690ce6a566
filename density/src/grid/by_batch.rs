//! The bins of many samples side by side.
//!
//! What is done with each sample is written as a loop over a whole [`Batch`] without branches, which the compiler turns
//! into vectors.

use std::f64::consts::TAU;

use multiversion::multiversion;

use super::{Axis, Grid};
use crate::lanes::{BATCH, Batch, whole_number};

/// The bin of a value, as [`Axis::bin`] finds it, or -1 for a value beside the axis.
#[inline(always)]
fn position(axis: &Axis, value: f64) -> f64 {
    let position = (value - axis.low) / (axis.high - axis.low) * axis.bins as f64;
    let is_inside = axis.low <= value && value <= axis.high && axis.bins > 0;
    if is_inside { position.trunc().min(axis.bins as f64 - 1.0) } else { -1.0 }
}

/// The flat index of the bin of a sample, as [`Grid::bin`] finds it, or the number of bins for a sample beside the
/// grid; and whether that is so: if `phi` lies more than a turn beside the grid's branch, or is no number, the index
/// says nothing.
#[inline(always)]
pub(crate) fn bin(grid: &Grid, phi: f64, e: f64) -> (usize, bool) {
    let low = grid.branch_low();
    let offset = phi - low;
    let from_below = if offset < 0.0 { offset + TAU } else { offset };
    let angle = low + if offset >= TAU { offset - TAU } else { from_below };
    let folded = if angle >= low + TAU { low } else { angle };
    let (i, j) = (position(&grid.phi, folded), position(&grid.e, e));
    let index = i * grid.e.bins as f64 + j;
    let index = if i < 0.0 || j < 0.0 { grid.len() as f64 } else { index };
    (whole_number(index) as usize, (-TAU..2.0 * TAU).contains(&offset))
}

/// The bins of a batch; false if one of them is not known.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
fn bins(grid: &Grid, phi: &Batch, e: &Batch, bins: &mut [usize; BATCH]) -> bool {
    let (grid, mut are_known) = (*grid, true);
    for l in 0..BATCH {
        let (index, is_known) = bin(&grid, phi[l], e[l]);
        bins[l] = index;
        are_known &= is_known;
    }
    are_known
}

/// Counts samples; there are fewer than 2^32.
pub(super) fn count(grid: &Grid, phi: &[f64], e: &[f64]) -> Vec<u32> {
    let mut counts = vec![0; grid.len()];
    let ((batches_phi, last_phi), (batches_e, last_e)) = (phi.as_chunks::<BATCH>(), e.as_chunks::<BATCH>());
    let mut indices = [0; BATCH];
    let one_by_one = |phi: &[f64], e: &[f64], counts: &mut [u32]| {
        phi.iter().zip(e).filter_map(|(&phi, &e)| grid.bin(phi, e)).for_each(|bin| counts[bin] += 1);
    };
    for (phi, e) in batches_phi.iter().zip(batches_e) {
        if bins(grid, phi, e, &mut indices) {
            add(&mut counts, &indices);
        } else {
            one_by_one(phi, e, &mut counts);
        }
    }
    one_by_one(last_phi, last_e, &mut counts);
    counts
}

/// Counts samples in bins; those beside the grid have no bin.
#[inline(always)]
pub(crate) fn add(counts: &mut [u32], bins: &[usize; BATCH]) {
    for &bin in bins {
        if let Some(count) = counts.get_mut(bin) {
            *count += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// Values about the edges of the bins and about the ends of the axis.
    fn values(axis: Axis) -> Vec<f64> {
        let edges = axis.edges().into_iter().chain([axis.low - 0.01, axis.high + 0.01]);
        edges.flat_map(|edge| [edge.next_down(), edge, edge.next_up(), edge + 0.4 * axis.width()]).collect()
    }

    #[test]
    fn samples_side_by_side_fall_into_the_bins_of_each_alone() {
        let e = Axis { low: 0.1, high: 0.3, bins: 3 };
        for (low, high) in [(1.0, 2.0), (5.9, 2.0 * PI), (-0.3, 0.2), (0.5, 0.5 + TAU), (-PI, PI), (0.0, TAU)] {
            let grid = Grid { phi: Axis { low, high, bins: 7 }, e };
            let starts = values(grid.phi).into_iter().chain([grid.branch_low(), grid.branch_low().next_down()]);
            for phi in starts.flat_map(|phi| [phi, phi + TAU, phi - TAU]) {
                for e in values(e).into_iter().chain([f64::NAN]) {
                    let (found, is_known) = bin(&grid, phi, e);
                    if is_known {
                        assert_eq!(found, grid.bin(phi, e).unwrap_or(grid.len()), "{phi} {e} {grid:?}");
                    } else {
                        let offset = phi - grid.branch_low();
                        assert!(!(-TAU..2.0 * TAU).contains(&offset), "{phi} {grid:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn every_sample_is_counted_in_its_bin_wherever_it_stands() {
        let grid = Grid { phi: Axis { low: 1.0, high: 2.0, bins: 4 }, e: Axis { low: 0.1, high: 0.3, bins: 5 } };
        let phi: Vec<f64> = (0..1003).map(|i| f64::from(i % 97) * 0.2 - 5.0).chain([1e9, f64::NAN, 1.5]).collect();
        let e: Vec<f64> = (0..1006).map(|i| 0.4 * f64::from(i % 13) / 13.0).collect();
        let mut expected = vec![0; grid.len()];
        phi.iter().zip(&e).filter_map(|(&phi, &e)| grid.bin(phi, e)).for_each(|bin| expected[bin] += 1);
        assert_eq!(count(&grid, &phi, &e), expected);
        assert!(expected.iter().sum::<u32>() > 50);
        assert_eq!(grid.count(&phi, &e), expected.iter().map(|&count| u64::from(count)).collect::<Vec<_>>());
    }
}

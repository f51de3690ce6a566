//! Sums of samples on the branch of `phi` around their circular mean.
//!
//! Moments are taken on the branch around the circular mean, which is known only when all samples are. So sums with `s`
//! are kept for each of [`SECTORS`] sectors of the circle. At the end, the sectors beyond the cut are moved by a turn,
//! which is a shift of their origin. The sector that holds the point opposite the circular mean is cut there as if its
//! samples were spread evenly over it. A cloud that does not reach round the circle has no samples in that sector, and
//! its branch is exactly `[mean - π, mean + π)`.

use std::f64::consts::{PI, TAU};

use super::{SECTOR_SUMS, SECTORS, SampleSums, Sector, UNIT};

/// The samples of a sector, or of one part of the sector that is cut, on the branch of the circular mean.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rolled {
    pub(super) samples: f64,
    /// Middle of the sector, in half widths of the grid from its centre.
    pub(super) middle: f64,
    pub(super) sums: [f64; SECTOR_SUMS],
}

/// Sums over all parts.
pub(super) fn total(rolled: &[Rolled]) -> [f64; SECTOR_SUMS] {
    rolled.iter().fold([0.0; SECTOR_SUMS], |mut total, part| {
        total.iter_mut().zip(part.sums).for_each(|(total, sum)| *total += sum);
        total
    })
}

impl SampleSums {
    /// Sums of the sectors' terms on the branch of the circular mean, which lies `from_centre` rad from the grid's
    /// centre, with their numbers of samples; `turn` is a turn in half widths of the grid. The sector that is cut is
    /// returned as two parts.
    pub(super) fn unrolled(&self, from_centre: f64, turn: f64) -> Vec<Rolled> {
        // If the cloud lies right of the grid's centre, samples below its cut move up; if it lies left, samples above
        // its cut move down.
        let (cut, shift) = if from_centre >= 0.0 { (from_centre - PI, turn) } else { (from_centre + PI, -turn) };
        let position = ((cut + PI) / TAU * SECTORS as f64).clamp(0.0, SECTORS as f64);
        let width = turn / SECTORS as f64;
        let mut rolled = Vec::with_capacity(SECTORS + 1);
        for (k, sector) in self.sectors.iter().enumerate().filter(|(_, sector)| sector.samples > 0) {
            let middle = (k as f64 + 0.5) * width - 0.5 * turn;
            let below = (position - k as f64).clamp(0.0, 1.0);
            let (moved, edge) =
                if shift > 0.0 { (below, middle - 0.5 * width) } else { (1.0 - below, middle + 0.5 * width) };
            // The middle of the moved part, from the edge that is moved.
            let centre = edge + 0.5 * moved * width * shift.signum();
            rolled.extend(sector.rolled(middle, moved, centre, shift));
        }
        rolled
    }
}

impl Sector {
    /// The sector about `middle`, as one part or as two. Its share `moved`, about `centre`, moves by `k`.
    fn rolled(&self, middle: f64, moved: f64, centre: f64, k: f64) -> impl Iterator<Item = Rolled> {
        let all = self.sums.map(|sum| sum as f64 * UNIT);
        let n = self.samples as f64;
        let [_, _, _, _, t, t2, ..] = all;
        // The sums of an evenly filled part about `centre`, in which t does not depend on s.
        let (m, c) = (moved * n, centre);
        let part = if moved < 1.0 {
            let [t, t2] = [moved * t, moved * t2];
            [c * m, c * c * m, c.powi(3) * m, c.powi(4) * m, t, t2, c * t, c * c * t, c * t2, c * c * t2]
        } else {
            all
        };
        let mut rest = all;
        rest.iter_mut().zip(part).for_each(|(rest, part)| *rest -= part);
        let stays = Rolled { samples: n - m, middle, sums: rest };
        let moves = Rolled { samples: m, middle: middle + k, sums: shifted(part, m, k) };
        [(moved < 1.0).then_some(stays), (moved > 0.0).then_some(moves)].into_iter().flatten()
    }
}

/// Sums of `n` samples with `s + k` in the place of `s`.
fn shifted([s, s2, s3, s4, t, t2, st, s2t, st2, s2t2]: [f64; SECTOR_SUMS], n: f64, k: f64) -> [f64; SECTOR_SUMS] {
    [
        s + k * n,
        s2 + k * (2.0 * s + k * n),
        s3 + k * (3.0 * s2 + k * (3.0 * s + k * n)),
        s4 + k * (4.0 * s3 + k * (6.0 * s2 + k * (4.0 * s + k * n))),
        t,
        t2,
        st + k * t,
        s2t + k * (2.0 * st + k * t),
        st2 + k * t2,
        s2t2 + k * (2.0 * st2 + k * t2),
    ]
}

//! Samples reduced to sums: what their density and moments follow from, in any number of parts.
//!
//! A part of the samples becomes counts and sums of powers, parts are added, and only the whole becomes an estimate. The sums
//! are whole numbers of [`UNIT`]s, to which each term is cut, and adding whole numbers is exact: the estimate is the same
//! bytes in whatever parts, threads or order the samples came.
//!
//! With the comparison grid's centre as origin and its half widths as units,
//!
//! ```text
//! s = (phi - phi_c)/h_phi,   t = (e - e_c)/h_e,     S_jk = Σ s^j t^k  for j, k <= 2, j <= 4 and k <= 4
//! ```
//!
//! a cloud that fills its grid has `s` and `t` of order one, so central moments by shifting the origin lose few digits
//! (`μ_20 = a_20 - a_10²` and so on, `a_jk = S_jk/n`; Kendall & Stuart, *The Advanced Theory of Statistics* 1, 1977, Chapter 3).
//!
//! **The branch of `phi`.** Moments are taken on the branch around the circular mean, which is known only when all samples are. So
//! sums with `s` are kept for each of [`SECTORS`] sectors of the circle, and at the end those that lie beyond the cut move by
//! a turn, which is a shift of their origin. The sector that the circular mean's antipode lies in is cut there as if its
//! samples were spread evenly over it. For clouds that leave out that sector, which all do that do not reach round the
//! circle, that is the branch `[mean - π, mean + π)` itself.
//!
//! **What the cut does to standard errors.** The cut follows the sample's circular mean `c`, which has an error of its own:
//! moving the cut by `δ` moves the probability `p δ` beside it by a turn, `p` the density of `phi` there, and so the mean by
//! `2π p δ`. With resultant length `R`, a sample at `phi` moves `c` by `g/n`, `g = sin(phi - c)/R`, so the moments' influence
//! functions become
//!
//! ```text
//! mean of phi   (phi - μ) + 2π p g
//! variance      (phi - μ)² - σ² + 4π p (c - μ) g
//! covariance    (phi - μ)(e - ν) - κ + 2π p (e_cut - ν) g       e_cut the mean of e beside the cut
//! ```
//!
//! whose variances over `n` are the squares of the standard errors.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use crate::angle::{Circular, nearest};
use crate::binning::count;
use crate::estimate::{Estimate, Moments};
use crate::grid::{Axis, Grid};
use crate::standard_errors::{self, Cut};

/// Sectors of the circle.
pub const SECTORS: usize = 256;
/// Sums of a sector: `s, s², s³, s⁴, t, t², st, s²t, st², s²t²`.
pub const SECTOR_SUMS: usize = 10;
/// Sums of all samples: `sin(phi), cos(phi), t³, t⁴`.
pub const COMMON_SUMS: usize = 4;
/// What sums are whole numbers of.
const UNIT: f64 = 1.0 / (1u64 << 60) as f64;
/// Half widths of the grid, from its centre, within which a sample must lie for its terms to be summed: 2^76 units at most.
const REACH: f64 = 16.0;
/// Samples that a thread takes at a time.
const CHUNK: usize = 65_536;

/// Samples reduced to counts and sums.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Partial {
    /// How many samples.
    pub samples: u64,
    /// How many of them exceed the critical eccentricity.
    pub above: u64,
    /// How many lie in each bin of the grid.
    pub counts: Vec<u64>,
    /// Sums over all, see [`COMMON_SUMS`].
    pub common: [i128; COMMON_SUMS],
    /// Sums by sector, the first at the lower end of the grid's branch.
    pub sectors: Vec<Sector>,
}

/// Samples of a sector.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Sector {
    /// How many.
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

/// Whole units of a value, the rest cut off.
fn units(value: f64) -> i128 {
    let scaled = value / UNIT;
    // The common case, and much the quicker one.
    if scaled.abs() < i64::MAX as f64 { i128::from(scaled as i64) } else { scaled as i128 }
}

impl Partial {
    /// Nothing, on a grid of `bins` bins.
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
    /// [`TooFar`] names one that cannot be summed.
    ///
    /// # Panics
    /// If `phi` and `e` differ in length.
    pub fn reduce(phi: &[f64], e: &[f64], grid: &Grid, critical_e: f64) -> Result<Self, TooFar> {
        Self::reduce_in(Frame::of(grid), phi, e, grid, critical_e)
    }

    fn reduce_in(frame: Frame, phi: &[f64], e: &[f64], grid: &Grid, critical_e: f64) -> Result<Self, TooFar> {
        assert_eq!(phi.len(), e.len(), "one phi for every e");
        let chunks = phi.par_chunks(CHUNK).zip(e.par_chunks(CHUNK));
        chunks
            .map(|(phi, e)| {
                let mut sums = Self::empty(0);
                phi.iter().zip(e).try_for_each(|(&phi, &e)| sums.take(&frame, phi, e, critical_e))?;
                Ok(sums)
            })
            .try_reduce(
                || Self::empty(0),
                |mut sum, part| {
                    sum.add(&part);
                    Ok(sum)
                },
            )
            .map(|sums| Self { counts: count(phi, e, grid), ..sums })
    }

    /// Adds a sample to all but the counts of the bins.
    fn take(&mut self, frame: &Frame, phi: f64, e: f64, critical_e: f64) -> Result<(), TooFar> {
        let offset = phi - frame.phi;
        let offset = if (-PI..PI).contains(&offset) { offset } else { nearest(offset, 0.0) };
        let (s, t) = (offset / frame.half_phi, (e - frame.e) / frame.half_e);
        if !(phi.is_finite() && s.abs() <= REACH && t.abs() <= REACH) {
            return Err(TooFar { phi, e });
        }
        self.samples += 1;
        self.above += u64::from(e > critical_e);
        let (sin, cos) = phi.sin_cos();
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

    /// Adds a part on the same grid.
    pub fn add(&mut self, other: &Self) {
        self.samples += other.samples;
        self.above += other.above;
        self.counts.iter_mut().zip(&other.counts).for_each(|(sum, count)| *sum += count);
        self.common.iter_mut().zip(&other.common).for_each(|(sum, term)| *sum += term);
        self.sectors.iter_mut().zip(&other.sectors).for_each(|(sum, sector)| sum.add(sector));
    }

    /// The density, marginals, moments and standard errors of all samples, which are independent and equally weighted.
    pub fn finish(&self, grid: Grid) -> Estimate {
        self.finish_in(Frame::of(&grid), grid)
    }

    fn finish_in(&self, frame: Frame, grid: Grid) -> Estimate {
        let n = self.samples as f64;
        let scale = 1.0 / (n * grid.bin_area());
        let joint = self.counts.iter().map(|&count| count as f64 * scale).collect();
        let mean = |sum: i128| sum as f64 * UNIT / n;
        let [sin, cos, t3, t4] = self.common.map(mean);
        let circular = Circular::from_mean_vector(sin, cos);
        let from_centre = nearest(circular.mean - frame.phi, 0.0);
        let turn = TAU / frame.half_phi;
        let rolled = self.unrolled(from_centre, turn);
        let [s, s2, s3, s4, t, t2, st, s2t, st2, s2t2] = total(&rolled).map(|sum| sum / n);
        // Central moments from those about the grid's centre.
        let (var_s, var_t) = (s2 - s * s, t2 - t * t);
        let fourth = |m: f64, m2: f64, m3: f64, m4: f64| m4 - 4.0 * m * m3 + 6.0 * m * m * m2 - 3.0 * m.powi(4);
        let square =
            s2t2 - 2.0 * (t * s2t + s * st2) + t * t * s2 + s * s * t2 + 4.0 * s * t * st - 3.0 * (s * t).powi(2);
        let (p, q) = (frame.half_phi, frame.half_e);
        let (var_phi, var_e, cov) = (p * p * var_s, q * q * var_t, p * q * (st - s * t));
        let moments = Moments {
            mean_phi: circular.mean + (p * s - from_centre),
            std_phi: var_phi.max(0.0).sqrt(),
            mean_e: frame.e + q * t,
            std_e: var_e.max(0.0).sqrt(),
            cov_phi_e: cov,
            prob_above_critical_e: self.above as f64 / n,
        };
        let fourth_phi = p.powi(4) * fourth(s, s2, s3, s4);
        let fourth_e = q.powi(4) * fourth(t, t2, t3, t4);
        let central = [var_phi, fourth_phi, var_e, fourth_e, cov, (p * q).powi(2) * square];
        let cut = self.cut(&rolled, [s, t, var_s, st - s * t], from_centre / p, circular.resultant, &frame);
        let standard_errors = standard_errors::of_independent(n, central, cut, moments.prob_above_critical_e);
        Estimate { standard_errors, ..Estimate::from_joint(grid, joint, moments, circular) }
    }

    /// Sums of the sectors' terms on the branch of the circular mean, which lies `from_centre` rad from the grid's centre, with
    /// their numbers of samples; `turn` is a turn in half widths of the grid. The sector that is cut comes in two.
    fn unrolled(&self, from_centre: f64, turn: f64) -> Vec<Rolled> {
        // Samples below the cut of a cloud right of the grid's centre move up, those above that of a cloud left of it down.
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

    /// What the cut of the branch does to the influence of a sample, from central moments `s`, `t`, `σ_s²`, `κ` about the
    /// grid's centre, in units of half widths of the grid; `mean` is the circular mean in the same.
    fn cut(&self, rolled: &[Rolled], [s, t, var, cov]: [f64; 4], mean: f64, resultant: f64, frame: &Frame) -> Cut {
        /// Sectors beside the cut, on each side, that tell the density there.
        const BESIDE: f64 = 2.5;
        let (n, width) = (self.samples as f64, TAU / SECTORS as f64);
        let (p, q) = (frame.half_phi, frame.half_e);
        let from_mean = |part: &Rolled| (part.middle - mean) * p;
        let mut near = [0.0; 2];
        for part in rolled.iter().filter(|part| PI - from_mean(part).abs() <= BESIDE * width) {
            near[0] += part.samples;
            near[1] += part.sums[4];
        }
        if near[0] == 0.0 {
            return Cut::default();
        }
        // g to second order about the middle of each part.
        let mut sums = [0.0; 4];
        for part in rolled {
            let (sin, cos) = from_mean(part).sin_cos();
            let [s1, s2, s3, .., st, s2t, _, _] = part.sums;
            let t1 = part.sums[4];
            let m = part.samples;
            // Sums of (s - s̄)^j (t - t̄)^k and of the same times the offset from the middle.
            let about = |first: [f64; 3], at: f64| first[1] - at * first[0];
            let offset = |first: [f64; 3]| about(first, part.middle) * p;
            let term = |first: [f64; 3]| sin * first[0] + cos * offset(first);
            let deviation = [s1 - s * m, s2 - s * s1, s3 - s * s2];
            let square = [
                s2 - 2.0 * s * s1 + (s * s - var) * m,
                s3 - 2.0 * s * s2 + (s * s - var) * s1,
                part.sums[3] - 2.0 * s * s3 + (s * s - var) * s2,
            ];
            let product = [st - s * t1 - t * s1 + (s * t - cov) * m, s2t - s * st - t * s2 + (s * t - cov) * s1, 0.0];
            sums[0] += term(deviation);
            sums[1] += term(square);
            sums[2] += term(product);
            sums[3] += m * sin * sin + 2.0 * sin * cos * (s1 - part.middle * m) * p;
        }
        let density = near[0] / (2.0 * BESIDE * width * n);
        let [with_phi, with_square, with_product, square] = sums.map(|sum| sum / n);
        Cut {
            density,
            mean_from_circular: (s - mean) * p,
            e_beside: (near[1] / near[0] - t) * q,
            with_phi: with_phi * p / resultant,
            with_square: with_square * p * p / resultant,
            with_product: with_product * p * q / resultant,
            square: square / (resultant * resultant),
        }
    }
}

/// Samples of a sector, or of a part of the one that is cut, on the branch of the circular mean.
#[derive(Debug, Clone, Copy)]
struct Rolled {
    samples: f64,
    /// Middle of the sector, in half widths of the grid from its centre.
    middle: f64,
    sums: [f64; SECTOR_SUMS],
}

/// Sums over all.
fn total(rolled: &[Rolled]) -> [f64; SECTOR_SUMS] {
    rolled.iter().fold([0.0; SECTOR_SUMS], |mut total, part| {
        total.iter_mut().zip(part.sums).for_each(|(total, sum)| *total += sum);
        total
    })
}

impl Sector {
    fn add(&mut self, other: &Self) {
        self.samples += other.samples;
        self.sums.iter_mut().zip(&other.sums).for_each(|(sum, term)| *sum += term);
    }

    /// The sector about `middle`, of which the share `moved`, about `centre`, moves by `k`: as one part or as two.
    fn rolled(&self, middle: f64, moved: f64, centre: f64, k: f64) -> impl Iterator<Item = Rolled> {
        let all = self.sums.map(|sum| sum as f64 * UNIT);
        let n = self.samples as f64;
        let [_, _, _, _, t, t2, ..] = all;
        // Of an evenly filled part about `centre`, in which t does not depend on s.
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

/// The sector of an angle in `[-π, π)` from the grid's centre.
fn sector_of(offset: f64) -> usize {
    (((offset + PI) / TAU * SECTORS as f64) as usize).min(SECTORS - 1)
}

/// The estimate of independent, equally weighted samples, reduced and finished; in a wider frame if some lie far away. Not
/// a number if they are not finite.
///
/// # Panics
/// If `phi` and `e` differ in length.
pub fn estimate(phi: &[f64], e: &[f64], grid: Grid, critical_e: f64) -> Estimate {
    let mut frame = Frame::of(&grid);
    while frame.half_e.is_finite() {
        match Partial::reduce_in(frame, phi, e, &grid, critical_e) {
            Ok(partial) => return partial.finish_in(frame, grid),
            Err(TooFar { .. }) => (frame.half_phi, frame.half_e) = (frame.half_phi * REACH, frame.half_e * REACH),
        }
    }
    Partial::empty(grid.len()).finish(grid)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::weighted_moments;
    use crate::flow::Flow;
    use crate::grid::comparison_grids;
    use crate::orbits::Orbits;
    use crate::problem::paper::scenario;
    use crate::sampling::draw;

    /// Samples of a paper's scenario at its snapshots, with the grids.
    fn clouds(number: u32, samples: usize) -> Vec<(Vec<f64>, Vec<f64>, Grid)> {
        let problem = scenario(number as _);
        let flow = Flow::new(problem.model);
        let grids = comparison_grids(&problem, &flow, 100, 100).unwrap();
        let (x1, x2) = draw(&problem.initial, 3, samples);
        let mut orbits = Orbits::new(flow, x1, x2);
        let at = |(&time, grid): (&f64, Grid)| {
            orbits.advance_to(time).unwrap();
            let (mut phi, mut e) = (vec![0.0; samples], vec![0.0; samples]);
            orbits.read_out(&mut phi, &mut e);
            (phi, e, grid)
        };
        problem.times.iter().zip(grids).map(at).collect()
    }

    /// Central moments `m_20, m_40, m_02, m_04, m_11, m_22` in two passes.
    fn central(phi: &[f64], e: &[f64], moments: &Moments, centre: f64) -> [f64; 6] {
        let mut sums = [0.0; 6];
        for (&phi, &e) in phi.iter().zip(e) {
            let (a, b) = (nearest(phi, centre) - moments.mean_phi, e - moments.mean_e);
            let terms = [a * a, a.powi(4), b * b, b.powi(4), a * b, a * a * b * b];
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        sums.map(|sum| sum / phi.len() as f64)
    }

    #[test]
    fn moments_and_their_errors_are_those_of_two_passes() {
        let mut beside_the_cut = 0;
        for number in 1..=3 {
            for (k, (phi, e, grid)) in clouds(number, 20_000).iter().enumerate() {
                let estimate = estimate(phi, e, *grid, 0.6);
                let (moments, circular) = weighted_moments(phi, e, None, 0.6);
                let expected_errors = standard_errors::of_independent(
                    phi.len() as f64,
                    central(phi, e, &moments, circular.mean),
                    Cut::default(),
                    moments.prob_above_critical_e,
                );
                let deviations = [moments.std_phi, moments.std_phi, moments.std_e, moments.std_e];
                let scales = deviations.into_iter().chain([moments.std_phi * moments.std_e, 1.0]);
                // What lies beside the cut of the branch is the business of other tests.
                let from_cut = |&phi: &f64| PI - nearest(phi - circular.mean, 0.0).abs();
                if phi.iter().map(from_cut).fold(f64::INFINITY, f64::min) < 4.0 * TAU / SECTORS as f64 {
                    beside_the_cut += 1;
                    continue;
                }
                let pairs = estimate.moments.to_array().into_iter().zip(moments.to_array()).zip(scales);
                for (quantity, ((found, expected), scale)) in pairs.enumerate() {
                    let error = (found - expected).abs() / scale;
                    assert!(error < 1e-12, "scenario {number}, snapshot {k}, quantity {quantity}: {error:e}");
                }
                let pairs = estimate.standard_errors.to_array().into_iter().zip(expected_errors.to_array());
                for (quantity, (found, expected)) in pairs.enumerate() {
                    let error = (found - expected).abs() / expected.max(1e-300);
                    assert!(
                        expected == found || error < 1e-12,
                        "scenario {number}, snapshot {k}, error {quantity}: {found} {expected}"
                    );
                }
                assert!((estimate.circular.mean - circular.mean).abs() < 1e-13);
                assert!((estimate.circular.resultant - circular.resultant).abs() < 1e-13);
            }
        }
        assert!(beside_the_cut < 3, "{beside_the_cut}");
    }

    #[test]
    fn a_cloud_that_reaches_round_the_circle_is_cut_at_the_antipode_to_a_part_of_a_sector() {
        let problem = scenario(1);
        let (u, v) = draw(&problem.initial, 9, 20_000);
        // Its centre a standard deviation from the origin.
        let (a, b) = (u.iter().sum::<f64>() / 2e4, v.iter().sum::<f64>() / 2e4);
        let polar = |(u, v): (&f64, &f64)| {
            let (x1, x2) = (u - a + 0.01, v - b + 0.03);
            (x1.atan2(x2).rem_euclid(TAU), x1.hypot(x2))
        };
        let (phi, e): (Vec<f64>, Vec<f64>) = u.iter().zip(&v).map(polar).unzip();
        for centre in [0.0, 0.4, 1.7, 3.0, 5.0] {
            let grid = Grid {
                phi: Axis { low: centre - PI, high: centre + PI, bins: 20 },
                e: Axis { low: 0.0, high: 0.2, bins: 20 },
            };
            let found = estimate(&phi, &e, grid, 0.6).moments;
            let (moments, circular) = weighted_moments(&phi, &e, None, 0.6);
            // A turn times by how much the samples of a sector are not spread evenly over it: a few of some twenty.
            let beside = |phi: f64| PI - nearest(phi - circular.mean, 0.0).abs() < TAU / SECTORS as f64;
            let near = phi.iter().filter(|&&phi| beside(phi)).count() as f64;
            let tolerance = TAU * near.sqrt() / 2e4;
            assert!(near > 10.0, "{near}");
            assert!((found.mean_phi - moments.mean_phi).abs() < tolerance, "{centre}: {found:?} {moments:?}");
            assert!((found.std_phi - moments.std_phi).abs() < 2.0 * tolerance, "{centre}: {found:?} {moments:?}");
        }
    }

    #[test]
    fn standard_errors_are_the_spread_over_seeds_also_where_the_cloud_reaches_round_the_circle() {
        use rand::SeedableRng;
        use rand_chacha::ChaCha8Rng;
        use rand_distr::{Distribution, StandardNormal};
        const SEEDS: u64 = 400;
        let grid = Grid { phi: Axis { low: 0.0, high: TAU, bins: 10 }, e: Axis { low: 0.0, high: 0.6, bins: 10 } };
        for (sigma, skew, samples) in [(0.3, 0.0, 1000), (1.2, 0.2, 2000), (1.9, 0.3, 4000), (2.1, -0.2, 8000)] {
            let one = |seed: u64| {
                let mut random = ChaCha8Rng::seed_from_u64(seed);
                let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
                let (phi, e): (Vec<f64>, Vec<f64>) = (0..samples)
                    .map(|_| {
                        let z = normal();
                        let phi = 1.0 + sigma * (z + skew * z * z);
                        (phi.rem_euclid(TAU), 0.3 + 0.05 * (phi + 0.5).cos() + 0.01 * normal())
                    })
                    .unzip();
                let found = estimate(&phi, &e, grid, 0.32);
                (found.moments.to_array(), found.standard_errors.to_array())
            };
            let all: Vec<_> = (0..SEEDS).into_par_iter().map(one).collect();
            let centre = all[0].0[0];
            for k in 0..6 {
                let value = |moments: &[f64; 6]| if k == 0 { nearest(moments[0], centre) } else { moments[k] };
                let mean = all.iter().map(|(moments, _)| value(moments)).sum::<f64>() / SEEDS as f64;
                let spread = (all.iter().map(|(moments, _)| (value(moments) - mean).powi(2)).sum::<f64>()
                    / (SEEDS - 1) as f64)
                    .sqrt();
                let claimed = all.iter().map(|(_, errors)| errors[k]).sum::<f64>() / SEEDS as f64;
                assert!(
                    (claimed / spread - 1.0).abs() < 0.15,
                    "sigma {sigma}, quantity {k}: standard error {claimed}, spread over seeds {spread}"
                );
            }
        }
    }

    #[test]
    fn any_parts_in_any_order_give_the_same_bytes() {
        for (phi, e, grid) in clouds(1, 5_000) {
            let whole = estimate(&phi, &e, grid, 0.6);
            for parts in [2, 3, 7] {
                let mut sum = Partial::empty(grid.len());
                for k in (0..parts).rev() {
                    let range = 5_000 * k / parts..5_000 * (k + 1) / parts;
                    sum.add(&Partial::reduce(&phi[range.clone()], &e[range], &grid, 0.6).unwrap());
                }
                let bits = |estimate: &Estimate| {
                    let moments = estimate.moments.to_array().into_iter().chain(estimate.standard_errors.to_array());
                    let circular = [estimate.circular.mean, estimate.circular.resultant];
                    let numbers = moments.chain(circular).chain(estimate.joint.iter().copied());
                    numbers.map(f64::to_bits).collect::<Vec<_>>()
                };
                assert_eq!(bits(&sum.finish(grid)), bits(&whole));
            }
        }
    }

    #[test]
    fn the_branch_is_that_of_the_circular_mean_wherever_the_grid_lies() {
        // A cloud of 2 rad; the grid's centre is up to half a turn away, so that its branch cuts the cloud.
        let phi: Vec<f64> = (0..2001).map(|i| (5.5 + 0.001 * f64::from(i)).rem_euclid(TAU)).collect();
        let e: Vec<f64> = (0..2001).map(|i| 0.2 + 1e-5 * f64::from(i)).collect();
        for low in [-3.0, -1.0, 0.0, 1.5, 3.0, 5.6] {
            let grid = Grid { phi: Axis { low, high: low + 1.0, bins: 5 }, e: Axis { low: 0.1, high: 0.3, bins: 5 } };
            let found = estimate(&phi, &e, grid, 0.6);
            let (moments, circular) = weighted_moments(&phi, &e, None, 0.6);
            for (found, expected) in found.moments.to_array().into_iter().zip(moments.to_array()) {
                assert!((found - expected).abs() < 1e-12, "{low}: {found} {expected}");
            }
            assert!((nearest(found.moments.mean_phi - circular.mean, 0.0)).abs() < 1.0);
        }
    }

    #[test]
    fn samples_far_from_the_grid_are_named_or_summed_in_a_wider_frame() {
        let grid = Grid { phi: Axis { low: 1.0, high: 1.01, bins: 2 }, e: Axis { low: 0.1, high: 0.11, bins: 2 } };
        let (phi, e) = ([1.0, 1.005, 2.5], [0.1, 0.105, 0.9]);
        let error = Partial::reduce(&phi, &e, &grid, 0.6).unwrap_err();
        assert_eq!((error.phi, error.e), (2.5, 0.9));
        let (moments, _) = weighted_moments(&phi, &e, None, 0.6);
        for (found, expected) in estimate(&phi, &e, grid, 0.6).moments.to_array().into_iter().zip(moments.to_array()) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        assert!(estimate(&[f64::NAN], &[0.1], grid, 0.6).moments.mean_phi.is_nan());
    }
}

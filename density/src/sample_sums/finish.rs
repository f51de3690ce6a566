//! Computes density, moments and standard errors from the sums of all samples.
//!
//! The cut of the branch follows the sample's circular mean `c`, which has an error of its own. Moving the cut by `δ`
//! moves the probability `p δ` beside it by a turn, where `p` is the density of `phi` there, and so moves the mean by
//! `2π p δ`. With resultant length `R`, a sample at `phi` moves `c` by `g/n`, `g = sin(phi - c)/R`. So the influence
//! functions of the moments become
//!
//! ```text
//! mean of phi   (phi - μ) + 2π p g
//! variance      (phi - μ)² - σ² + 4π p (c - μ) g
//! covariance    (phi - μ)(e - ν) - κ + 2π p (e_cut - ν) g       e_cut the mean of e beside the cut
//! ```
//!
//! whose variances over `n` are the squares of the standard errors.

use std::f64::consts::{PI, TAU};

use super::branch::{Rolled, total};
use super::{Frame, REACH, SECTORS, SampleSums, TooFar, UNIT};
use crate::angle::{Circular, nearest};
use crate::estimate::{Estimate, Moments};
use crate::grid::Grid;
use crate::standard_errors::{self, Cut};

impl SampleSums {
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

    /// The effect of the cut of the branch on the influence of a sample, from the moments `s`, `t`, `σ_s²`, `κ` about
    /// the grid's centre, in units of half widths of the grid; `mean` is the circular mean in the same units.
    fn cut(&self, rolled: &[Rolled], [s, t, var, cov]: [f64; 4], mean: f64, resultant: f64, frame: &Frame) -> Cut {
        /// Number of sectors beside the cut, on each side, from which the density there is computed.
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
            // Sums of (s - s̄)^j (t - t̄)^k, and of the same terms times the offset from the middle.
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

/// The estimate of independent, equally weighted samples, reduced and finished. If some samples lie far from the grid,
/// a wider frame is taken. The moments are NaN if samples are not finite.
///
/// # Panics
/// If `phi` and `e` differ in length.
pub fn estimate(phi: &[f64], e: &[f64], grid: Grid, critical_e: f64) -> Estimate {
    let mut frame = Frame::of(&grid);
    while frame.half_e.is_finite() {
        match SampleSums::reduce_in(frame, phi, e, &grid, critical_e) {
            Ok(sums) => return sums.finish_in(frame, grid),
            Err(TooFar { .. }) => (frame.half_phi, frame.half_e) = (frame.half_phi * REACH, frame.half_e * REACH),
        }
    }
    SampleSums::empty(grid.len()).finish(grid)
}

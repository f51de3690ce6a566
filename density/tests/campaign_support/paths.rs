//! The oracle's own integrator: Taylor series of order [`ORDER`] for [`LANES`] neighbouring orbits with a common step.
//!
//! With `s = sqrt(1 - e²)`, `p = s⁻⁴` and the time unit `1/n_sun`,
//!
//! ```text
//! x1' = C s + W x2 p - x2,   x2' = x1 - W x1 p,   s' = -C x1,   s p' = 4 C x1 p
//! ```
//!
//! Within a step the series is a dense output. The eccentricity peaks where `x1` changes from positive to negative, so
//! the largest eccentricity on the way is found at the zeros of a polynomial.

use std::f64::consts::TAU;

use density::model::planar::SrpJ2;
use multiversion::multiversion;
use rayon::prelude::*;

const LANES: usize = 8;
const ORDER: usize = 20;
/// Size of the last terms of a series.
const LAST_TERM: f64 = 1e-16;
/// Number of steps after which the progress is checked, so that hopeless orbits cost little.
const FIRST_LOOK: u64 = 200;

type Lanes = [f64; LANES];

/// States of orbits at several times; NaN where an orbit was given up.
#[derive(Debug, Clone)]
pub struct Paths {
    /// `e sin(phi)` at each time, of each orbit.
    pub x1: Vec<Vec<f64>>,
    /// `e cos(phi)`, likewise.
    pub x2: Vec<Vec<f64>>,
    /// The largest `e²` until that time, likewise.
    pub peak: Vec<Vec<f64>>,
    /// Number of steps of all bundles of orbits.
    pub steps: u64,
}

/// The force on the orbits, and a limit for the integrator.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    /// The force.
    pub force: SrpJ2,
    /// Number of steps after which an orbit is given up. An orbit that is very close to `e = 1` turns thousands of
    /// times a year.
    pub most_steps: u64,
}

/// Follows the orbits that start at `(phi, e)` through the ascending `times` \[yr\].
pub fn follow(motion: Motion, starts: &[[f64; 2]], times: &[f64]) -> Paths {
    let bundles: Vec<(Vec<[Lanes; 3]>, u64)> =
        starts.par_chunks(LANES).map(|starts| follow_bundle(motion, starts, times)).collect();
    let column = |k: usize, value: usize| -> Vec<f64> {
        let lanes = bundles.iter().flat_map(|(records, _)| records[k][value]);
        lanes.take(starts.len()).collect()
    };
    let columns = |value: usize| (0..times.len()).map(|k| column(k, value)).collect();
    Paths { x1: columns(0), x2: columns(1), peak: columns(2), steps: bundles.iter().map(|bundle| bundle.1).sum() }
}

/// Taylor coefficients of all lanes.
struct Series {
    x1: [Lanes; ORDER + 1],
    x2: [Lanes; ORDER + 1],
    s: [Lanes; ORDER + 1],
    p: [Lanes; ORDER + 1],
    /// `k p_k`.
    slope: [Lanes; ORDER + 1],
}

fn follow_bundle(motion: Motion, starts: &[[f64; 2]], times: &[f64]) -> (Vec<[Lanes; 3]>, u64) {
    let Motion { force, most_steps } = motion;
    let zeros = [[0.0; LANES]; ORDER + 1];
    let mut series = Series { x1: zeros, x2: zeros, s: zeros, p: zeros, slope: zeros };
    let mut peak = [0.0; LANES];
    for lane in 0..LANES {
        let [phi, e] = starts[lane.min(starts.len() - 1)];
        (series.x1[0][lane], series.x2[0][lane]) = (e * phi.sin(), e * phi.cos());
        series.s[0][lane] = ((1.0 - e) * (1.0 + e)).sqrt();
        peak[lane] = e * e;
    }
    let last = times.last().copied().unwrap_or(0.0) * TAU;
    let (mut now, mut steps) = (0.0, 0);
    let mut records = Vec::with_capacity(times.len());
    for &time in times {
        let end = time * TAU;
        while now < end {
            series.expand(force.radiation, force.oblateness);
            let reach = series.reach();
            let step = if now + 1.000_001 * reach < end { reach } else { end - now };
            steps += 1;
            let hopeless = steps == FIRST_LOOK && now * (most_steps as f64) < last * (FIRST_LOOK as f64) / 5.0;
            if reach.is_nan() || reach <= 0.0 || steps > most_steps || hopeless {
                records.resize(times.len(), [[f64::NAN; LANES]; 3]);
                return (records, steps);
            }
            series.note_peaks(step, &mut peak);
            series.move_on(step);
            now = if step < reach || now + step >= end { end } else { now + step };
        }
        for (lane, peak) in peak.iter_mut().enumerate() {
            *peak = peak.max(series.x1[0][lane].powi(2) + series.x2[0][lane].powi(2));
        }
        records.push([series.x1[0], series.x2[0], peak]);
    }
    (records, steps)
}

impl Series {
    fn expand(&mut self, c: f64, w: f64) {
        expand(self, c, w);
    }

    /// The largest time for which the series of every lane is accurate.
    fn reach(&self) -> f64 {
        let mut reach = f64::INFINITY;
        for lane in 0..LANES {
            let s = self.s[0][lane];
            for k in [ORDER - 1, ORDER] {
                let size = self.x1[k][lane].abs().max(self.x2[k][lane].abs()).max(self.s[k][lane].abs() / s);
                let own = (LAST_TERM / size).powf(1.0 / k as f64);
                // A NaN must end the search; `min` would ignore it.
                reach = if own < reach {
                    own
                } else if own >= reach {
                    reach
                } else {
                    return f64::NAN;
                };
            }
        }
        // All higher coefficients vanish only if nothing moves.
        reach.min(0.5)
    }

    fn at(coefficients: &[Lanes; ORDER + 1], lane: usize, time: f64) -> f64 {
        coefficients.iter().rev().fold(0.0, |sum, c| sum * time + c[lane])
    }

    fn note_peaks(&self, step: f64, peak: &mut Lanes) {
        for (lane, peak) in peak.iter_mut().enumerate() {
            let x1 = |time: f64| Self::at(&self.x1, lane, time);
            let ends = [0.0, 0.5 * step, step].map(|time| (time, x1(time)));
            for pair in ends.windows(2) {
                if pair[0].1 > 0.0 && pair[1].1 <= 0.0 {
                    let time = zero(x1, pair[0], pair[1]);
                    let e2 = x1(time).powi(2) + Self::at(&self.x2, lane, time).powi(2);
                    *peak = peak.max(e2);
                }
            }
        }
    }

    fn move_on(&mut self, step: f64) {
        for coefficients in [&mut self.x1, &mut self.x2, &mut self.s] {
            let mut sum = [0.0; LANES];
            for c in coefficients.iter().rev() {
                for lane in 0..LANES {
                    sum[lane] = sum[lane] * step + c[lane];
                }
            }
            coefficients[0] = sum;
        }
    }
}

/// The zero of `f` between two points of opposite sign, by false position with the Illinois correction.
fn zero(f: impl Fn(f64) -> f64, mut a: (f64, f64), mut b: (f64, f64)) -> f64 {
    let mut side = 0;
    for _ in 0..20 {
        let time = (a.0 * b.1 - b.0 * a.1) / (b.1 - a.1);
        let value = f(time);
        if value.abs() < 1e-15 {
            return time;
        }
        if (value > 0.0) == (a.1 > 0.0) {
            a = (time, value);
            if side == 1 {
                b.1 *= 0.5;
            }
            side = 1;
        } else {
            b = (time, value);
            if side == 2 {
                a.1 *= 0.5;
            }
            side = 2;
        }
    }
    0.5 * (a.0 + b.0)
}

#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
fn expand(series: &mut Series, c: f64, w: f64) {
    let Series { x1, x2, s, p, slope } = series;
    let mut inverse = [0.0; LANES];
    for lane in 0..LANES {
        inverse[lane] = 1.0 / s[0][lane];
        p[0][lane] = inverse[lane].powi(4);
    }
    for k in 0..ORDER {
        let (mut x1p, mut x2p, mut sp) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for j in 0..=k {
            for lane in 0..LANES {
                x1p[lane] += x1[j][lane] * p[k - j][lane];
                x2p[lane] += x2[j][lane] * p[k - j][lane];
            }
        }
        for j in 1..=k {
            for lane in 0..LANES {
                sp[lane] += s[k + 1 - j][lane] * slope[j][lane];
            }
        }
        let share = 1.0 / (k + 1) as f64;
        for lane in 0..LANES {
            let x1_next = share * (c * s[k][lane] + w * x2p[lane] - x2[k][lane]);
            x2[k + 1][lane] = share * (x1[k][lane] - w * x1p[lane]);
            s[k + 1][lane] = -share * c * x1[k][lane];
            x1[k + 1][lane] = x1_next;
            slope[k + 1][lane] = (4.0 * c * x1p[lane] - sp[lane]) * inverse[lane];
            p[k + 1][lane] = share * slope[k + 1][lane];
        }
    }
}

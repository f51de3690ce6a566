//! The Taylor recurrence of the planar model, written out for speed.
//!
//! With `s = sqrt(1 - e²)` as a third variable and `p = s⁻⁴`, in the time unit `1/n_sun` the equations of motion are
//!
//! ```text
//! x1' = C s + W x2 p - x2,   x2' = x1 - W x1 p,   s' = -C x1,   s p' = 4 C x1 p
//! ```
//!
//! so the Taylor coefficients of all four follow from three Cauchy products per order (`x1 p`, `x2 p`, `s p`), without
//! a square root and with one division per step. The conserved `H` would remove a variable, but no product: with `s`
//! alone, `s'' = (H - h(s)) h'(s) - C² s` needs three products as well, and `x2 = (H - h(s))/C` loses digits where `C`
//! is small.
//!
//! The coefficients are aligned to cache lines: loads that straddle two cost a quarter of the speed.

use std::fmt::Debug;

use super::plane::State;
use super::{LANES, Lanes};

/// The radiation parameter of the orbit in each lane: one number for all, or a number for each.
pub trait Radiation: Copy + Debug {
    /// The radiation parameter of a lane.
    fn of(&self, lane: usize) -> f64;
}

/// All orbits have the same.
impl Radiation for f64 {
    #[inline(always)]
    fn of(&self, _: usize) -> f64 {
        *self
    }
}

/// Every orbit has its own.
impl Radiation for Lanes {
    #[inline(always)]
    fn of(&self, lane: usize) -> f64 {
        self[lane]
    }
}

/// Taylor coefficients of [`LANES`] orbits; those of order 0 are the states.
#[derive(Debug)]
#[repr(C, align(64))]
pub struct Recurrence<const P: usize, R> {
    pub(super) x1: [Lanes; P],
    pub(super) x2: [Lanes; P],
    pub(super) s: [Lanes; P],
    p: [Lanes; P],
    pub(super) radiation: R,
    oblateness: f64,
}

impl<const P: usize, R: Radiation> Recurrence<P, R> {
    const ORDER: usize = P - 1;

    /// Puts orbits that have reached `e = 1` within a step outside the range of the equations. Without oblateness the
    /// equations turn `(x1, x2, s)` about `(0, C, 1)` and lead on beyond `e = 1`, where `s` is negative and the orbit
    /// is no longer one of a satellite; nothing else in the series shows this. An orbit is put outside if it has passed
    /// its most eccentric point within the step, where `x1` changes its sign, and had `s < 0` there.
    fn end_where_e_was_one(&mut self, before: &Lanes, step: &Lanes) {
        for l in 0..LANES {
            let radiation = self.radiation.of(l);
            let (x1, x2, s) = (self.x1[0][l], self.x2[0][l], self.s[0][l]);
            let has_passed = before[l] * step[l] > 0.0 && x1 * step[l] <= 0.0;
            // The axis has the length N, and the state lies at the distance d along it. So the least s is
            // (d - C sqrt(1 - d²))/N.
            let along = (s + radiation * x2) / (1.0 + radiation * radiation).sqrt();
            if has_passed && along < radiation * (1.0 - along * along).max(0.0).sqrt() {
                self.s[0][l] = f64::NAN;
            }
        }
    }

    #[inline(always)]
    pub(super) fn new(radiation: R, oblateness: f64) -> Self {
        let zeros = [[0.0; LANES]; P];
        Self { x1: zeros, x2: zeros, s: [[1.0; LANES]; P], p: zeros, radiation, oblateness }
    }

    #[inline(always)]
    pub(super) fn start(&mut self, lane: usize, state: State) {
        (self.x1[0][lane], self.x2[0][lane], self.s[0][lane]) = (state.x1, state.x2, state.s());
    }

    #[inline(always)]
    pub(super) fn expand(&mut self) {
        let Self { x1, x2, s, p, radiation, oblateness } = self;
        let (radiation, oblateness) = (*radiation, *oblateness);
        let mut inverse_s = [0.0; LANES];
        for l in 0..LANES {
            inverse_s[l] = 1.0 / s[0][l];
            let square = inverse_s[l] * inverse_s[l];
            p[0][l] = square * square;
        }
        for n in 0..Self::ORDER {
            let (mut x1p, mut x2p, mut sp) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
            for l in 0..LANES {
                x1p[l] = x1[n][l] * p[0][l];
                x2p[l] = x2[n][l] * p[0][l];
            }
            for j in 0..n {
                for l in 0..LANES {
                    x1p[l] = x1[j][l].mul_add(p[n - j][l], x1p[l]);
                    x2p[l] = x2[j][l].mul_add(p[n - j][l], x2p[l]);
                    sp[l] = s[j + 1][l].mul_add(p[n - j][l], sp[l]);
                }
            }
            let next = 1.0 / (n + 1) as f64;
            for l in 0..LANES {
                let radiation = radiation.of(l);
                let drift = radiation.mul_add(s[n][l], -x2[n][l]);
                s[n + 1][l] = -radiation * next * x1[n][l];
                x1[n + 1][l] = next * oblateness.mul_add(x2p[l], drift);
                x2[n + 1][l] = next * (-oblateness).mul_add(x1p[l], x1[n][l]);
                sp[l] = s[n + 1][l].mul_add(p[0][l], sp[l]);
                p[n + 1][l] = inverse_s[l] * (3.0 * radiation * next).mul_add(x1p[l], -sp[l]);
            }
        }
    }

    #[inline(always)]
    pub(super) fn move_on(&mut self, step: &Lanes) {
        let (mut x1, mut x2, mut s) = (self.x1[Self::ORDER], self.x2[Self::ORDER], self.s[Self::ORDER]);
        for n in (0..Self::ORDER).rev() {
            for l in 0..LANES {
                x1[l] = x1[l].mul_add(step[l], self.x1[n][l]);
                x2[l] = x2[l].mul_add(step[l], self.x2[n][l]);
                s[l] = s[l].mul_add(step[l], self.s[n][l]);
            }
        }
        let before = self.x1[0];
        (self.x1[0], self.x2[0], self.s[0]) = (x1, x2, s);
        if self.oblateness == 0.0 {
            self.end_where_e_was_one(&before, step);
        }
    }

    #[inline(always)]
    pub(super) fn is_inside(&self, lane: usize) -> bool {
        let (x1, x2) = (self.x1[0][lane], self.x2[0][lane]);
        self.s[0][lane] > 0.0 && x1 * x1 + x2 * x2 < 1.0
    }
}

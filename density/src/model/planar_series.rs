//! The Taylor recurrence of the paper's model, written out for speed.
//!
//! With `s = sqrt(1 - e²)` as a third variable and `p = s⁻⁴`, in the time unit `1/n_sun` the equations of motion are
//!
//! ```text
//! x1' = C s + W x2 p - x2,   x2' = x1 - W x1 p,   s' = -C x1,   s p' = 4 C x1 p
//! ```
//!
//! so the Taylor coefficients of all four follow from three Cauchy products an order (`x1 p`, `x2 p`, `s p`), without a
//! square root and with one division a step. The conserved `H` would remove a variable, but no product: with `s` alone,
//! `s'' = (H - h(s)) h'(s) - C² s` needs three as well, and `x2 = (H - h(s))/C` loses digits where `C` is small.
//!
//! The coefficients are aligned to cache lines: loads that straddle two cost a quarter of the speed.

use super::planar::Force;
use super::plane::State;
use crate::flow::{LANES, Lanes, Series};

/// Taylor coefficients of [`LANES`] orbits; those of order 0 are the states.
#[derive(Debug)]
#[repr(C, align(64))]
pub struct PlanarSeries<const P: usize> {
    x1: [Lanes; P],
    x2: [Lanes; P],
    s: [Lanes; P],
    p: [Lanes; P],
    force: Force,
}

impl<const P: usize> PlanarSeries<P> {
    const ORDER: usize = P - 1;
}

impl<const P: usize> Series<P> for PlanarSeries<P> {
    type Model = Force;

    #[inline(always)]
    fn new(force: &Force) -> Self {
        let zeros = [[0.0; LANES]; P];
        Self { x1: zeros, x2: zeros, s: [[1.0; LANES]; P], p: zeros, force: *force }
    }

    #[inline(always)]
    fn start(&mut self, lane: usize, state: State, _: f64) {
        (self.x1[0][lane], self.x2[0][lane], self.s[0][lane]) = (state.x1, state.x2, state.s());
    }

    #[inline(always)]
    fn expand(&mut self, _: bool) {
        let Self { x1, x2, s, p, force: Force { radiation, oblateness } } = self;
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
    fn move_on(&mut self, step: &Lanes) {
        let (mut x1, mut x2, mut s) = (self.x1[Self::ORDER], self.x2[Self::ORDER], self.s[Self::ORDER]);
        for n in (0..Self::ORDER).rev() {
            for l in 0..LANES {
                x1[l] = x1[l].mul_add(step[l], self.x1[n][l]);
                x2[l] = x2[l].mul_add(step[l], self.x2[n][l]);
                s[l] = s[l].mul_add(step[l], self.s[n][l]);
            }
        }
        (self.x1[0], self.x2[0], self.s[0]) = (x1, x2, s);
    }

    #[inline(always)]
    fn is_inside(&self, lane: usize) -> bool {
        let (x1, x2) = (self.x1[0][lane], self.x2[0][lane]);
        self.s[0][lane] > 0.0 && x1 * x1 + x2 * x2 < 1.0
    }

    #[inline(always)]
    fn coordinate(&self, k: usize) -> &[Lanes; P] {
        if k == 0 { &self.x1 } else { &self.x2 }
    }

    /// `s` itself.
    #[inline(always)]
    fn clearance(&self) -> &[Lanes; P] {
        &self.s
    }
}

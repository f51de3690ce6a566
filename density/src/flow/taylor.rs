//! A batched Taylor-series integrator.
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
//! The step of each orbit follows from its own last two coefficients (Jorba & Zou, Exp. Math. 14, 2005, Sect. 3.2) and is
//! cut at the end of the interval.
//!
//! [`LANES`] orbits are processed at a time, one a SIMD lane. A lane whose orbit has arrived takes the next one, so that no
//! lane waits for the orbit with the most steps. A lane never looks at its neighbours, and every operation is a correctly
//! rounded IEEE one, so an orbit's result is the same bytes in whatever company, thread or instruction set it ran.
//! The coefficients are aligned to cache lines: loads that straddle two cost a quarter of the speed.

use multiversion::multiversion;

use crate::dynamics::{Force, SUN_MEAN_MOTION, State};

/// Orbits side by side: three sums in as many vector registers as AVX2 has to spare.
pub(super) const LANES: usize = 16;
/// Steps that an orbit may take in any interval, and more for each year of it. At the default accuracy a year takes about
/// fifteen, and next to `e = 1`, where oblateness turns orbits by `W/s⁴` a time unit, in proportion more: at `e = 0.99` and
/// `W = 10` there are 1e5.
const MOST_STEPS: f64 = 10_000.0;
const MOST_STEPS_A_YEAR: f64 = 1e6;
/// An orbit is given up where the steps that it may still take would have to be so many times as long as the one just taken.
const HASTE: f64 = 4.0;

pub(super) type Lanes = [f64; LANES];

/// Moves the orbits `(x1[i], x2[i])` by `years[i]`, or by the last of `years` where there are fewer, with Taylor series of
/// `P` coefficients; `tolerance` is the size at which the last terms are cut. Returns the orbits that were lost, in no
/// order, and why; their states stay as they were. `watch` sees every step.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
pub(super) fn advance<const P: usize, W: Watch>(
    force: Force,
    x1: &mut [f64],
    x2: &mut [f64],
    years: &[f64],
    tolerance: f64,
    watch: &mut W,
) -> Vec<(usize, Loss)> {
    let reach = libm::pow(tolerance, 1.0 / (P - 1) as f64);
    let mut series = Series::<P>::AT_REST;
    let mut crew = Crew::new();
    let mut next = 0;
    for lane in 0..LANES {
        next += crew.board(lane, next, &mut series, x1, x2, years);
    }
    let mut lost = Vec::new();
    while crew.at_work > 0 {
        series.expand(force);
        let steps = crew.take_steps(&series.radii(), reach);
        watch.see(&series, &steps, &crew);
        series.move_on(&steps);
        for (lane, &step) in steps.iter().enumerate() {
            let is_inside = series.is_inside(lane);
            if crew.left[lane] > 0.0 && is_inside && !crew.is_stuck(lane, step) {
                continue;
            }
            let Some(orbit) = crew.orbit[lane] else { continue };
            if !is_inside {
                lost.push((orbit, Loss::LeftTheDomain));
            } else if crew.left[lane] > 0.0 {
                lost.push((orbit, Loss::Stuck));
            } else {
                x1[orbit] = crew.sign[lane] * series.x1[0][lane];
                x2[orbit] = series.x2[0][lane];
            }
            next += crew.board(lane, next, &mut series, x1, x2, years);
        }
    }
    lost
}

/// Something that looks at the orbits on their way.
pub(super) trait Watch {
    /// Sees the series of all lanes and the steps that are about to be taken along them.
    fn see<const P: usize>(&mut self, series: &Series<P>, steps: &Lanes, crew: &Crew);
}

/// Looks at nothing.
impl Watch for () {
    #[inline(always)]
    fn see<const P: usize>(&mut self, _: &Series<P>, _: &Lanes, _: &Crew) {}
}

/// Which orbit is in which lane, and how far it has to go.
pub(super) struct Crew {
    pub(super) orbit: [Option<usize>; LANES],
    /// -1 for an orbit that runs backwards.
    sign: Lanes,
    /// Time left after the step under way \[1/n_sun\].
    pub(super) left: Lanes,
    /// Steps that it may still take.
    steps: Lanes,
    at_work: usize,
}

/// Why an orbit could not be followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, thiserror::Error)]
pub enum Loss {
    /// It reached `e = 1`, or turned non-finite.
    #[error("left the domain e < 1 of the equations of motion")]
    LeftTheDomain,
    /// Its steps became too short to get on: it turns too fast, as orbits next to `e = 1` do.
    #[error("turns too fast to be followed (the integrator would need more than 1e6 steps a year)")]
    Stuck,
}

impl Crew {
    fn new() -> Self {
        Self { orbit: [None; LANES], sign: [1.0; LANES], left: [0.0; LANES], steps: [0.0; LANES], at_work: LANES }
    }

    /// Puts the orbit `next` into a lane if there is one; the lane rests otherwise. Returns how many were put in. The flow
    /// run backwards is the flow of the mirrored states (`-x1`).
    #[inline(always)]
    fn board<const P: usize>(
        &mut self,
        lane: usize,
        next: usize,
        series: &mut Series<P>,
        x1: &[f64],
        x2: &[f64],
        years: &[f64],
    ) -> usize {
        let (Some(&x1), Some(&x2), Some(&years)) = (x1.get(next), x2.get(next), years.get(next).or(years.last()))
        else {
            (self.orbit[lane], self.left[lane]) = (None, 0.0);
            self.at_work -= 1;
            series.start(lane, State { x1: 0.0, x2: 0.0 });
            return 0;
        };
        (self.orbit[lane], self.steps[lane]) = (Some(next), MOST_STEPS + MOST_STEPS_A_YEAR * years.abs());
        (self.sign[lane], self.left[lane]) = (years.signum(), SUN_MEAN_MOTION * years.abs());
        series.start(lane, State { x1: self.sign[lane] * x1, x2 });
        1
    }

    /// Each lane's step, from its radius and what is left of its way.
    #[inline(always)]
    fn take_steps(&mut self, radii: &Lanes, reach: f64) -> Lanes {
        let mut step = [0.0; LANES];
        for l in 0..LANES {
            step[l] = (reach * radii[l]).min(self.left[l]);
            self.left[l] -= step[l];
            self.steps[l] -= 1.0;
        }
        step
    }

    /// Whether a lane's orbit does not get on: no step is left to it, or the one taken is so short that those which are left
    /// would not take it to the end. That an orbit turns a thousand times too fast is seen at its first step, not after minutes.
    #[inline(always)]
    fn is_stuck(&self, lane: usize, step: f64) -> bool {
        self.left[lane] > HASTE * step * self.steps[lane]
    }
}

/// Taylor coefficients of [`LANES`] orbits; those of order 0 are the states. Loops over lanes are written for the vectoriser.
#[repr(align(64))]
pub(super) struct Series<const P: usize> {
    x1: [Lanes; P],
    x2: [Lanes; P],
    pub(super) s: [Lanes; P],
    p: [Lanes; P],
}

impl<const P: usize> Series<P> {
    const ORDER: usize = P - 1;
    const AT_REST: Self =
        Self { x1: [[0.0; LANES]; P], x2: [[0.0; LANES]; P], s: [[1.0; LANES]; P], p: [[0.0; LANES]; P] };

    #[inline(always)]
    fn start(&mut self, lane: usize, state: State) {
        (self.x1[0][lane], self.x2[0][lane], self.s[0][lane]) = (state.x1, state.x2, state.s());
    }

    /// The coefficients of `(x1, x2)` of one lane, zeros after the last.
    pub(super) fn coefficients<const N: usize>(&self, lane: usize) -> ([f64; N], [f64; N]) {
        let (mut x1, mut x2) = ([0.0; N], [0.0; N]);
        for n in 0..P.min(N) {
            (x1[n], x2[n]) = (self.x1[n][lane], self.x2[n][lane]);
        }
        (x1, x2)
    }

    #[inline(always)]
    fn is_inside(&self, lane: usize) -> bool {
        let (x1, x2) = (self.x1[0][lane], self.x2[0][lane]);
        self.s[0][lane] > 0.0 && x1 * x1 + x2 * x2 < 1.0
    }

    /// All coefficients from those of order 0.
    #[inline(always)]
    fn expand(&mut self, Force { radiation, oblateness }: Force) {
        let Self { x1, x2, s, p } = self;
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

    /// How far each series reaches, judged by its last two coefficients.
    #[inline(always)]
    #[allow(clippy::needless_range_loop, reason = "a loop over lanes like all others")]
    fn radii(&self) -> Lanes {
        let (last, before) = (Self::ORDER, Self::ORDER - 1);
        let (inverse_last, inverse_before) = (1.0 / last as f64, 1.0 / before as f64);
        let mut radii = [0.0; LANES];
        for l in 0..LANES {
            let size = |n: usize| self.x1[n][l].abs().max(self.x2[n][l].abs());
            radii[l] = power(size(last), -inverse_last).min(power(size(before), -inverse_before));
        }
        radii
    }

    /// Moves each lane by its step.
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
}

/// `a^exponent` for `-1 <= exponent < 0` to within 0.8 %, from the bits of `a` and two parabolas: good enough for a step
/// size, and the same on every machine. `a = 0` gives a huge but finite number.
#[inline(always)]
fn power(a: f64, exponent: f64) -> f64 {
    const UNIT: f64 = 1_048_576.0; // 2^20 steps of the upper half double a float
    let upper = (a.to_bits() >> 32) as i32;
    let fraction = f64::from(upper & 0xf_ffff) / UNIT;
    // log2(1 + f) = f + 0.343 f (1 - f), nearly.
    let logarithm = (f64::from(upper) / UNIT - 1023.0) + 0.343 * fraction * (1.0 - fraction);
    let exponent = exponent * logarithm;
    let whole = exponent.floor();
    let rest = exponent - whole;
    // 2^f = 1 + f - 0.337 f (1 - f), nearly.
    let mantissa = 1.0 + rest * (1.0 - 0.337 * (1.0 - rest));
    f64::from_bits(u64::from((whole as i32 + 1023) as u32) << 52) * mantissa
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_good_enough_for_a_step_size() {
        for k in -200..=20 {
            let a = 1.37 * 10f64.powi(k);
            for n in 2..20 {
                let exact = a.powf(-1.0 / f64::from(n));
                assert!((power(a, -1.0 / f64::from(n)) / exact - 1.0).abs() < 0.008, "{a:e} {n}");
            }
        }
        assert!(power(0.0, -1.0).is_finite());
    }
}

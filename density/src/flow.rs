//! The flow: many orbits moved forward or backward in time by one batched Taylor-series integrator.
//!
//! With `s = sqrt(1 - e²)` as a third variable and `p = s⁻⁴`, in the time unit `1/n_sun` the equations of motion are
//!
//! ```text
//! x1' = C s + W x2 p - x2,   x2' = x1 - W x1 p,   s' = -C x1,   s p' = 4 C x1 p
//! ```
//!
//! so the Taylor coefficients of all four follow from three Cauchy products an order (`x1 p`, `x2 p`, `s p`), without a
//! square root and with one division a step. The step of each orbit follows from its own last two coefficients (Jorba &
//! Zou, Exp. Math. 14, 2005, Sect. 3.2) and is cut at the end of the interval.
//!
//! Orbits are processed in blocks of [`LANES`], one orbit a SIMD lane. A lane never looks at its neighbours, and every
//! operation is a correctly rounded IEEE one, so an orbit's result is the same bytes whatever block, thread or instruction
//! set it ran on.

use multiversion::multiversion;
use rayon::prelude::*;

use crate::dynamics::{Force, SUN_MEAN_MOTION, State};

/// Orbits in a block.
const LANES: usize = 16;
/// Orbits a thread takes at a time.
const CHUNK: usize = 1024;
/// Steps that no regular orbit needs in an interval; an orbit that does is about to leave the domain. At the default
/// accuracy a year takes about ten.
const MOST_STEPS: usize = 10_000;

/// How accurately orbits are propagated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Accuracy {
    /// States good to about 1e-6 after two years: enough for pictures.
    Coarse,
    /// States good to about 1e-9.
    Medium,
    /// States good to about 1e-12; the Hamiltonian is kept to 1e-12 or better.
    #[default]
    Fine,
}

/// The flow of a force: moves orbits in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flow {
    /// The force that drives it.
    pub force: Force,
    /// How accurately.
    pub accuracy: Accuracy,
}

/// An orbit left the domain `e < 1` of the equations of motion, or turned non-finite.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("orbit {index} left the domain e < 1 within {years} yr of the state phi = {phi} rad, e = {e}")]
pub struct Escaped {
    /// Which of the orbits given.
    pub index: usize,
    /// Length of the interval \[yr\].
    pub years: f64,
    /// Solar angle at the start of the interval \[rad\].
    pub phi: f64,
    /// Eccentricity at the start of the interval.
    pub e: f64,
}

impl Flow {
    /// The flow of `force` at the default accuracy.
    pub fn new(force: Force) -> Self {
        Self { force, accuracy: Accuracy::default() }
    }

    /// Moves the orbits `(x1[i], x2[i])` by `years`, backwards if negative, on all threads of the current rayon pool.
    ///
    /// # Errors
    /// [`Escaped`] names the first orbit that cannot be continued; the slices then hold no meaningful states.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn advance(&self, x1: &mut [f64], x2: &mut [f64], years: f64) -> Result<(), Escaped> {
        assert_eq!(x1.len(), x2.len(), "one x1 for every x2");
        x1.par_chunks_mut(CHUNK)
            .zip(x2.par_chunks_mut(CHUNK))
            .enumerate()
            .map(|(chunk, (x1, x2))| {
                self.advance_chunk(x1, x2, |_| years, |escaped, _, _| Err(escaped))
                    .map_err(|escaped| Escaped { index: chunk * CHUNK + escaped.index, ..escaped })
            })
            .reduce(|| Ok(()), Result::and)
    }

    /// Moves the orbits `(x1[i], x2[i])` by `years[i]` each.
    ///
    /// # Errors
    /// [`Escaped`] names the first orbit that cannot be continued; the slices then hold no meaningful states.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn advance_each(&self, x1: &mut [f64], x2: &mut [f64], years: &[f64]) -> Result<(), Escaped> {
        assert!(x1.len() == x2.len() && x1.len() == years.len(), "one x1 and one interval for every x2");
        self.advance_chunk(x1, x2, |i| years[i], |escaped, _, _| Err(escaped))
    }

    /// As [`Flow::advance`], but an orbit that cannot be continued ends as NaN instead of stopping the others. Backward
    /// orbits from outside a cloud may have come from nowhere (`e >= 1`), where the density is zero.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn advance_where_possible(&self, x1: &mut [f64], x2: &mut [f64], years: f64) {
        assert_eq!(x1.len(), x2.len(), "one x1 for every x2");
        x1.par_chunks_mut(CHUNK).zip(x2.par_chunks_mut(CHUNK)).for_each(|(x1, x2)| {
            let nowhere = |_, x1: &mut f64, x2: &mut f64| {
                (*x1, *x2) = (f64::NAN, f64::NAN);
                Ok(())
            };
            // `nowhere` never refuses, so there is no error to pass on.
            let _ = self.advance_chunk(x1, x2, |_| years, nowhere);
        });
    }

    /// Moves one orbit by `years`.
    ///
    /// # Errors
    /// [`Escaped`] if it leaves the domain.
    pub fn advance_one(&self, state: State, years: f64) -> Result<State, Escaped> {
        let (mut x1, mut x2) = ([state.x1], [state.x2]);
        self.advance_chunk(&mut x1, &mut x2, |_| years, |escaped, _, _| Err(escaped))?;
        Ok(State { x1: x1[0], x2: x2[0] })
    }

    fn advance_chunk(
        &self,
        x1: &mut [f64],
        x2: &mut [f64],
        years: impl Fn(usize) -> f64,
        mut on_escape: impl FnMut(Escaped, &mut f64, &mut f64) -> Result<(), Escaped>,
    ) -> Result<(), Escaped> {
        for (block, (x1, x2)) in x1.chunks_mut(LANES).zip(x2.chunks_mut(LANES)).enumerate() {
            let mut interval = [0.0; LANES];
            for (lane, interval) in interval.iter_mut().enumerate().take(x1.len()) {
                *interval = years(block * LANES + lane);
            }
            let start = Block::load(x1, x2, &interval);
            let duration = interval.map(|years: f64| SUN_MEAN_MOTION * years.abs());
            let end = match self.accuracy {
                Accuracy::Coarse => advance_block::<11>(self.force, start, duration, 1e-7),
                Accuracy::Medium => advance_block::<13>(self.force, start, duration, 1e-10),
                Accuracy::Fine => advance_block::<18>(self.force, start, duration, 3e-14),
            };
            let before: [State; LANES] = std::array::from_fn(|lane| State {
                x1: x1.get(lane).copied().unwrap_or(0.0),
                x2: x2.get(lane).copied().unwrap_or(0.0),
            });
            end.store(x1, x2, &interval);
            for lane in (0..x1.len()).filter(|&lane| end.escaped(lane)) {
                let (index, years) = (block * LANES + lane, interval[lane]);
                let (phi, e) = (before[lane].solar_angle(), before[lane].eccentricity());
                on_escape(Escaped { index, years, phi, e }, &mut x1[lane], &mut x2[lane])?;
            }
        }
        Ok(())
    }
}

type Lanes = [f64; LANES];

/// [`LANES`] orbits side by side; `s` turns negative or NaN where one escapes.
#[derive(Clone, Copy)]
struct Block {
    x1: Lanes,
    x2: Lanes,
    s: Lanes,
}

impl Block {
    /// Lanes without an orbit hold the circular one. The flow run backwards is the flow of the mirrored states (`-x1`).
    fn load(x1: &[f64], x2: &[f64], years: &Lanes) -> Self {
        let mut block = Self { x1: [0.0; LANES], x2: [0.0; LANES], s: [0.0; LANES] };
        for ((to, &from), years) in block.x1.iter_mut().zip(x1).zip(years) {
            *to = from * years.signum();
        }
        block.x2[..x2.len()].copy_from_slice(x2);
        for lane in 0..LANES {
            block.s[lane] = State { x1: block.x1[lane], x2: block.x2[lane] }.s();
        }
        block
    }

    fn store(&self, x1: &mut [f64], x2: &mut [f64], years: &Lanes) {
        for ((to, &from), years) in x1.iter_mut().zip(&self.x1).zip(years) {
            *to = from * years.signum();
        }
        x2.copy_from_slice(&self.x2[..x2.len()]);
    }

    fn escaped(&self, lane: usize) -> bool {
        let e_squared = self.x1[lane] * self.x1[lane] + self.x2[lane] * self.x2[lane];
        !(self.s[lane] > 0.0 && e_squared < 1.0)
    }
}

/// Moves the orbits of a block by `duration` \[1/n_sun\] each, with Taylor series of order `P - 1`, `P` coefficients a variable; `tolerance` is
/// the size at which the last terms are cut. Loops over lanes are written for the vectoriser.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
fn advance_block<const P: usize>(force: Force, start: Block, duration: Lanes, tolerance: f64) -> Block {
    let Force { radiation, oblateness } = force;
    let order = P - 1;
    let reach = tolerance.powf(1.0 / order as f64);
    let (mut x1, mut x2, mut s, mut p) = ([[0.0; LANES]; P], [[0.0; LANES]; P], [[0.0; LANES]; P], [[0.0; LANES]; P]);
    let mut now = start;
    let mut left = duration;

    for _ in 0..MOST_STEPS {
        (x1[0], x2[0], s[0]) = (now.x1, now.x2, now.s);
        let mut inverse_s = [0.0; LANES];
        for l in 0..LANES {
            inverse_s[l] = 1.0 / s[0][l];
            let square = inverse_s[l] * inverse_s[l];
            p[0][l] = square * square;
        }
        for n in 0..order {
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

        let mut unfinished = 0;
        let mut step = [0.0; LANES];
        for l in 0..LANES {
            let last = x1[order][l].abs().max(x2[order][l].abs());
            let before = x1[order - 1][l].abs().max(x2[order - 1][l].abs());
            let radius = inverse_root(last, order).min(inverse_root(before, order - 1));
            step[l] = (reach * radius).min(left[l]);
            left[l] -= step[l];
            unfinished += usize::from(left[l] > 0.0);
        }
        (now.x1, now.x2, now.s) = (x1[order], x2[order], s[order]);
        for n in (0..order).rev() {
            for l in 0..LANES {
                now.x1[l] = now.x1[l].mul_add(step[l], x1[n][l]);
                now.x2[l] = now.x2[l].mul_add(step[l], x2[n][l]);
                now.s[l] = now.s[l].mul_add(step[l], s[n][l]);
            }
        }
        if unfinished == 0 {
            return now;
        }
    }
    Block { s: std::array::from_fn(|l| if left[l] > 0.0 { f64::NAN } else { now.s[l] }), ..now }
}

/// `a^(-1/n)` to within 7 %, from the bits of `a`: the upper half of a positive float is a piecewise linear logarithm.
/// Good enough for a step size, and the same on every machine. `a = 0` gives a huge but finite number.
#[inline(always)]
fn inverse_root(a: f64, n: usize) -> f64 {
    const UNIT: f64 = 1_048_576.0; // 2^20 upper-half steps double a float
    const ONE: f64 = 1023.0 * UNIT; // upper half of 1.0
    let logarithm = f64::from((a.to_bits() >> 32) as i32) - ONE;
    let upper = (ONE - logarithm / n as f64) as i32;
    f64::from_bits(u64::from(upper as u32) << 32)
}

//! The Taylor recurrence of the averaged model in space, written out for speed.
//!
//! In the time unit `1/n_sun`, with `u = h + e`, `v = h - e`, the direction to the Sun `s` by `c = cos l` and `d = sin
//! l`, and the pole of the ecliptic `k`,
//!
//! ```text
//! u' = u × (f + g - G e)      f = W z η⁻⁵ p - 2A (h·s) s + B (h·k) k
//! v' = v × (f - g + G e)      g = (C + 10A (e·s)) s - 5B (e·k) k
//! G  = (W/2) (η⁻⁵ - 5 z² η⁻⁷) + 4A - 2B      z = h·p      η² = h·h
//! ```
//!
//! This takes 31 Cauchy products per order: 12 for the two vector products, 3 each for `G e` and `η²`, 8 for the Sun's
//! direction, and 5 for `η⁻⁵`, `η⁻⁷` and their products with `z`. The powers follow from each other without a root:
//! `w = η⁻⁷` and `y = η² w` have `n y_n = -(5/2) Σ_{k=1..n} k (η²)_k w_{n-k}`.
//!
//! Half of the lanes are expanded at a time, so that their coefficients stay in the first cache.

use super::{State, Vectorial, vectors};
use crate::model::earth::SUN_MEAN_MOTION;
use crate::model::part::{Coefficients, Part, WIDTH, add_product, each, subtract_product};
use crate::model::sun_moon::SunMoon;
use crate::model::vector::{dot, plus, times};
use crate::model::{LANES, Lanes, Series};

/// Taylor coefficients of [`LANES`] orbits.
#[derive(Debug)]
pub struct VectorialSeries<const P: usize> {
    model: Vectorial,
    blocks: [Block<P>; LANES / WIDTH],
    /// Time of each lane \[yr\].
    time: Lanes,
    /// The state: the components of `e`, then those of `h`.
    state: [Aligned<P>; 6],
    clearance: Aligned<P>,
}

#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Aligned<const P: usize>([Lanes; P]);

/// Everything that is expanded of some lanes, in the notation of the head of this file.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Block<const P: usize> {
    u: [Coefficients<P>; 3],
    v: [Coefficients<P>; 3],
    /// `f + g - G e` and `f - g + G e`, about which `u` and `v` turn.
    about: [[Coefficients<P>; 3]; 2],
    e: [Coefficients<P>; 3],
    h: [Coefficients<P>; 3],
    /// The components of `e` and `h` in the ecliptic, across the vernal equinox.
    in_ecliptic: [Coefficients<P>; 2],
    cos: Coefficients<P>,
    sin: Coefficients<P>,
    /// How strongly `f + g` and `f - g` point to the Sun.
    to_sun: [Coefficients<P>; 2],
    eta2: Coefficients<P>,
    /// `η⁻⁵` and `η⁻⁷`.
    eta_5: Coefficients<P>,
    eta_7: Coefficients<P>,
    /// `z η⁻⁷`.
    z_eta_7: Coefficients<P>,
    /// `G`.
    turning: Coefficients<P>,
    /// `C` of each lane.
    radiation: Part,
}

/// The parameters of a model and the sine and cosine of its obliquity.
#[derive(Debug, Clone, Copy)]
struct Constants {
    forces: SunMoon,
    sin_obliquity: f64,
    cos_obliquity: f64,
}

impl<const P: usize> Block<P> {
    const ZERO: Coefficients<P> = [[0.0; WIDTH]; P];
    const AT_REST: Self = Self {
        u: [Self::ZERO; 3],
        v: [Self::ZERO; 3],
        about: [[Self::ZERO; 3]; 2],
        e: [Self::ZERO; 3],
        h: [Self::ZERO; 3],
        in_ecliptic: [Self::ZERO; 2],
        cos: Self::ZERO,
        sin: Self::ZERO,
        to_sun: [Self::ZERO; 2],
        eta2: Self::ZERO,
        eta_5: Self::ZERO,
        eta_7: Self::ZERO,
        z_eta_7: Self::ZERO,
        turning: Self::ZERO,
        radiation: [0.0; WIDTH],
    };

    /// Computes all coefficients from those of order 0 of `u`, `v`, `cos` and `sin`.
    #[inline(always)]
    fn expand(&mut self, constants: &Constants) {
        for n in 0..P - 1 {
            self.split(n, constants);
            self.expand_sun_and_size(n, constants);
            self.expand_powers(n);
            let turning = self.expand_oblateness(n, constants);
            self.expand_axes(n, constants, &turning);
            self.turn(n);
        }
        self.split(P - 1, constants);
    }

    /// `e` and `h` of order `n` from `u` and `v`.
    #[inline(always)]
    fn split(&mut self, n: usize, constants: &Constants) {
        let Self { u, v, e, h, in_ecliptic, .. } = self;
        for k in 0..3 {
            e[k][n] = each(|l| 0.5 * (u[k][n][l] - v[k][n][l]));
            h[k][n] = each(|l| 0.5 * (u[k][n][l] + v[k][n][l]));
        }
        for (own, vector) in in_ecliptic.iter_mut().zip([e, h]) {
            own[n] = each(|l| constants.cos_obliquity * vector[1][n][l] + constants.sin_obliquity * vector[2][n][l]);
        }
    }

    /// `η²` and how strongly the forces point to the Sun, of order `n`.
    #[inline(always)]
    fn expand_sun_and_size(&mut self, n: usize, constants: &Constants) {
        let Self { e, h, in_ecliptic, cos, sin, to_sun, eta2, radiation, .. } = self;
        let (mut size, mut by_e, mut by_h) = ([0.0; WIDTH], [0.0; WIDTH], [0.0; WIDTH]);
        for j in 0..=n {
            for component in h.iter() {
                add_product(&mut size, &component[j], &component[n - j]);
            }
            add_product(&mut by_e, &e[0][j], &cos[n - j]);
            add_product(&mut by_e, &in_ecliptic[0][j], &sin[n - j]);
            add_product(&mut by_h, &h[0][j], &cos[n - j]);
            add_product(&mut by_h, &in_ecliptic[1][j], &sin[n - j]);
        }
        eta2[n] = size;
        let sun = constants.forces.sun;
        let radiation = if n == 0 { *radiation } else { [0.0; WIDTH] };
        to_sun[0][n] = each(|l| radiation[l] + sun * (10.0 * by_e[l] - 2.0 * by_h[l]));
        to_sun[1][n] = each(|l| -radiation[l] - sun * (10.0 * by_e[l] + 2.0 * by_h[l]));
    }

    /// `η⁻⁵` and `η⁻⁷` of order `n`.
    #[inline(always)]
    fn expand_powers(&mut self, n: usize) {
        let Self { eta2, eta_5, eta_7, .. } = self;
        if n == 0 {
            let inverse = each(|l| 1.0 / eta2[0][l]);
            eta_5[0] = each(|l| inverse[l] * inverse[l] * inverse[l].sqrt());
            eta_7[0] = each(|l| eta_5[0][l] * inverse[l]);
            return;
        }
        let (mut weighted, mut rest) = ([0.0; WIDTH], [0.0; WIDTH]);
        for k in 1..=n {
            let weight = k as f64;
            add_product(&mut rest, &eta2[k], &eta_7[n - k]);
            add_product(&mut weighted, &each(|l| weight * eta2[k][l]), &eta_7[n - k]);
        }
        let factor = -2.5 / n as f64;
        eta_5[n] = each(|l| factor * weighted[l]);
        eta_7[n] = each(|l| (eta_5[n][l] - rest[l]) / eta2[0][l]);
    }

    /// `G`, and returns `W z η⁻⁵`, of order `n`.
    #[inline(always)]
    fn expand_oblateness(&mut self, n: usize, constants: &Constants) -> Part {
        let Self { h: [_, _, z], eta_5, eta_7, z_eta_7, turning, .. } = self;
        let (mut with_5, mut with_7, mut twice) = ([0.0; WIDTH], [0.0; WIDTH], [0.0; WIDTH]);
        for j in 0..=n {
            add_product(&mut with_5, &z[j], &eta_5[n - j]);
            add_product(&mut with_7, &z[j], &eta_7[n - j]);
        }
        z_eta_7[n] = with_7;
        for j in 0..=n {
            add_product(&mut twice, &z[j], &z_eta_7[n - j]);
        }
        let SunMoon { force, sun, moon } = constants.forces;
        let others = if n == 0 { 4.0 * sun - 2.0 * moon } else { 0.0 };
        turning[n] = each(|l| 0.5 * force.oblateness * (eta_5[n][l] - 5.0 * twice[l]) + others);
        each(|l| force.oblateness * with_5[l])
    }

    /// The axes about which `u` and `v` turn, of order `n`; `node` is `W z η⁻⁵`.
    #[inline(always)]
    fn expand_axes(&mut self, n: usize, constants: &Constants, node: &Part) {
        let Self { about, e, h, cos, sin, to_sun, turning, .. } = self;
        let (mut toward, mut across) = ([[0.0; WIDTH]; 2], [[0.0; WIDTH]; 2]);
        let mut in_plane = [[0.0; WIDTH]; 3];
        for j in 0..=n {
            for k in 0..2 {
                add_product(&mut toward[k], &to_sun[k][j], &cos[n - j]);
                add_product(&mut across[k], &to_sun[k][j], &sin[n - j]);
            }
            for k in 0..3 {
                add_product(&mut in_plane[k], &turning[j], &e[k][n - j]);
            }
        }
        let Constants { forces, sin_obliquity, cos_obliquity } = *constants;
        let along_pole = |vector: &[Coefficients<P>; 3], l: usize| {
            forces.moon * (cos_obliquity * vector[2][n][l] - sin_obliquity * vector[1][n][l])
        };
        for (k, sign) in [(0, 1.0), (1, -1.0)] {
            let pole = each(|l| along_pole(h, l) - sign * 5.0 * along_pole(e, l));
            about[k][0][n] = each(|l| toward[k][l] - sign * in_plane[0][l]);
            about[k][1][n] = each(|l| cos_obliquity * across[k][l] - sin_obliquity * pole[l] - sign * in_plane[1][l]);
            about[k][2][n] =
                each(|l| sin_obliquity * across[k][l] + cos_obliquity * pole[l] - sign * in_plane[2][l] + node[l]);
        }
    }

    /// `u`, `v`, `cos` and `sin` of order `n + 1`.
    #[inline(always)]
    fn turn(&mut self, n: usize) {
        let Self { u, v, about, cos, sin, .. } = self;
        let next = 1.0 / (n + 1) as f64;
        for (vector, axis) in [u, v].into_iter().zip(about) {
            let mut rate = [[0.0; WIDTH]; 3];
            for j in 0..=n {
                for k in 0..3 {
                    let (a, b) = ((k + 1) % 3, (k + 2) % 3);
                    add_product(&mut rate[k], &vector[a][j], &axis[b][n - j]);
                    subtract_product(&mut rate[k], &vector[b][j], &axis[a][n - j]);
                }
            }
            for k in 0..3 {
                vector[k][n + 1] = each(|l| next * rate[k][l]);
            }
        }
        cos[n + 1] = each(|l| -next * sin[n][l]);
        sin[n + 1] = each(|l| next * cos[n][l]);
    }
}

impl<const P: usize> VectorialSeries<P> {
    /// Puts the Sun where it is at a lane's time.
    #[inline(always)]
    fn place_sun(&mut self, lane: usize) {
        let longitude = self.model.longitude(self.time[lane]);
        let block = &mut self.blocks[lane / WIDTH];
        block.cos[0][lane % WIDTH] = libm::cos(longitude);
        block.sin[0][lane % WIDTH] = libm::sin(longitude);
    }

    /// Gives a lane a radiation parameter of its own.
    #[inline(always)]
    pub(crate) fn irradiate(&mut self, lane: usize, radiation: f64) {
        self.blocks[lane / WIDTH].radiation[lane % WIDTH] = radiation;
    }

    /// Coefficient 0 of the state of a lane.
    #[inline(always)]
    fn start_of(&self, lane: usize) -> State {
        std::array::from_fn(|k| self.state[k].0[0][lane])
    }
}

impl<const P: usize> Series<P> for VectorialSeries<P> {
    type Model = Vectorial;

    #[inline(always)]
    fn new(model: &Vectorial) -> Self {
        let zero = Aligned([[0.0; LANES]; P]);
        let radiation = [model.forces.force.radiation; WIDTH];
        let blocks = [Block { radiation, ..Block::AT_REST }; LANES / WIDTH];
        Self { model: *model, blocks, time: [0.0; LANES], state: [zero; 6], clearance: zero }
    }

    #[inline(always)]
    fn start(&mut self, lane: usize, state: State, time: f64) {
        let (e, h) = vectors(state);
        let (u, v) = (plus(h, e), plus(h, times(e, -1.0)));
        let block = &mut self.blocks[lane / WIDTH];
        for k in 0..3 {
            (block.u[k][0][lane % WIDTH], block.v[k][0][lane % WIDTH]) = (u[k], v[k]);
        }
        for (coordinate, value) in self.state.iter_mut().zip(state) {
            coordinate.0[0][lane] = value;
        }
        self.time[lane] = time;
        self.place_sun(lane);
    }

    #[inline(always)]
    fn expand(&mut self, with_clearance: bool) {
        let (sin_obliquity, cos_obliquity) = self.model.obliquity.sin_cos();
        let constants = Constants { forces: self.model.forces, sin_obliquity, cos_obliquity };
        for (b, block) in self.blocks.iter_mut().enumerate() {
            block.expand(&constants);
            let lanes = b * WIDTH..(b + 1) * WIDTH;
            if with_clearance {
                block.expand_sun_and_size(P - 1, &constants);
                (0..P).for_each(|n| self.clearance.0[n][lanes.clone()].copy_from_slice(&block.eta2[n]));
            }
            for (own, coordinate) in block.e.iter().chain(&block.h).zip(&mut self.state) {
                (0..P).for_each(|n| coordinate.0[n][lanes.clone()].copy_from_slice(&own[n]));
            }
        }
    }

    #[inline(always)]
    fn move_on(&mut self, steps: &Lanes) {
        for (block, steps) in self.blocks.iter_mut().zip(steps.chunks_exact(WIDTH)) {
            for x in block.u.iter_mut().chain(&mut block.v) {
                let mut sum = x[P - 1];
                for n in (0..P - 1).rev() {
                    for l in 0..WIDTH {
                        sum[l] = sum[l].mul_add(steps[l], x[n][l]);
                    }
                }
                x[0] = sum;
            }
        }
        for lane in 0..LANES {
            let block = &self.blocks[lane / WIDTH];
            for k in 0..3 {
                let (u, v) = (block.u[k][0][lane % WIDTH], block.v[k][0][lane % WIDTH]);
                (self.state[k].0[0][lane], self.state[3 + k].0[0][lane]) = (0.5 * (u - v), 0.5 * (u + v));
            }
            if steps[lane] != 0.0 {
                self.time[lane] += steps[lane] / SUN_MEAN_MOTION;
                self.place_sun(lane);
            }
        }
    }

    #[inline(always)]
    fn is_inside(&self, lane: usize) -> bool {
        let (e, h) = vectors(self.start_of(lane));
        dot(e, e) < 1.0 && dot(h, h) > 0.0
    }

    #[inline(always)]
    fn coordinate(&self, k: usize) -> &[Lanes; P] {
        &self.state[k].0
    }

    #[inline(always)]
    fn clearance(&self) -> &[Lanes; P] {
        &self.clearance.0
    }
}

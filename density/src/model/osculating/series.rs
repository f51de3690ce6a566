//! The Taylor recurrence of the unaveraged model, written out for speed.
//!
//! In the time unit `1/n_sun`, with `g = r²`, `m = |b - r/D|²` for the Sun and the Moon, and `c`, `d` the cosine and sine of their
//! longitudes,
//!
//! ```text
//! r' = N v      v' = N [-r S - 2 (W/N) z g^(-5/2) p - σ s + Σ q D b (m^(-3/2) - 1)]
//! S  = g^(-3/2) + (W/N) (g^(-5/2) - 5 z² g^(-7/2)) + Σ q m^(-3/2)
//! ```
//!
//! This takes 11 Cauchy products per order, and 5 more for each body. The powers follow without a root: `y = g^(-3/2)` and `w = y/g` have
//! `n y_n = -(3/2) Σ_{k=1..n} k g_k w_{n-k}`. Half of the lanes are expanded at a time, so that their coefficients stay in the first cache.

use super::{Body, Osculating, State, halves};
use crate::model::earth::SUN_MEAN_MOTION;
use crate::model::part::{Coefficients, Part, WIDTH, add_product, each};
use crate::model::{LANES, Lanes, Model, Series};

/// Taylor coefficients of [`LANES`] orbits.
#[derive(Debug)]
pub struct OsculatingSeries<const P: usize> {
    model: Osculating,
    constants: Constants,
    blocks: [Block<P>; LANES / WIDTH],
    /// Time of each lane \[yr\].
    time: Lanes,
    state: [Aligned<P>; 6],
    clearance: Aligned<P>,
    /// See [`Self::watch_height`].
    reentry_radius: Option<f64>,
}

#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Aligned<const P: usize>([Lanes; P]);

/// Everything that is expanded of some lanes, in the notation of the head of this file.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Block<const P: usize> {
    position: [Coefficients<P>; 3],
    velocity: [Coefficients<P>; 3],
    /// The component of the position in the ecliptic across the vernal equinox.
    in_ecliptic: Coefficients<P>,
    /// `g`, `g^(-3/2)` and `g^(-5/2)`.
    r2: Coefficients<P>,
    r_3: Coefficients<P>,
    r_5: Coefficients<P>,
    /// `z g^(-5/2)`, `z² g^(-5/2)` and `z² g^(-7/2)`.
    z_r_5: Coefficients<P>,
    zz_r_5: Coefficients<P>,
    zz_r_7: Coefficients<P>,
    /// `S`.
    toward_earth: Coefficients<P>,
    bodies: [OfBody<P>; 2],
    /// `σ` of each lane.
    pressure: Part,
}

/// What is expanded of the Sun or the Moon.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct OfBody<const P: usize> {
    cos: Coefficients<P>,
    sin: Coefficients<P>,
    /// `m` and `m^(-3/2)`, the latter less 1.
    apart2: Coefficients<P>,
    excess: Coefficients<P>,
}

/// The parameters of a model as the recurrence needs them.
#[derive(Debug, Clone, Copy)]
struct Constants {
    pace: f64,
    oblateness: f64,
    bodies: [Body; 2],
    sin_obliquity: f64,
    cos_obliquity: f64,
}

impl<const P: usize> Block<P> {
    const ZERO: Coefficients<P> = [[0.0; WIDTH]; P];
    const NO_BODY: OfBody<P> = OfBody { cos: Self::ZERO, sin: Self::ZERO, apart2: Self::ZERO, excess: Self::ZERO };
    const AT_REST: Self = Self {
        position: [Self::ZERO; 3],
        velocity: [Self::ZERO; 3],
        in_ecliptic: Self::ZERO,
        r2: Self::ZERO,
        r_3: Self::ZERO,
        r_5: Self::ZERO,
        z_r_5: Self::ZERO,
        zz_r_5: Self::ZERO,
        zz_r_7: Self::ZERO,
        toward_earth: Self::ZERO,
        bodies: [Self::NO_BODY; 2],
        pressure: [0.0; WIDTH],
    };

    /// Computes all coefficients from those of order 0 of position, velocity, `cos` and `sin`.
    #[inline(always)]
    fn expand(&mut self, constants: &Constants) {
        for n in 0..P - 1 {
            self.expand_distances(n, constants);
            self.expand_powers(n);
            self.expand_oblateness(n);
            for (own, body) in self.bodies.iter_mut().zip(&constants.bodies) {
                if body.strength != 0.0 {
                    own.expand_power(n);
                }
            }
            self.accelerate(n, constants);
        }
    }

    /// `r²` and `m` of order `n`.
    #[inline(always)]
    fn expand_distances(&mut self, n: usize, constants: &Constants) {
        let Self { position, in_ecliptic, r2, bodies, .. } = self;
        let Constants { sin_obliquity, cos_obliquity, .. } = *constants;
        in_ecliptic[n] = each(|l| cos_obliquity * position[1][n][l] + sin_obliquity * position[2][n][l]);
        let mut square = [0.0; WIDTH];
        for j in 0..=n {
            for component in position.iter() {
                add_product(&mut square, &component[j], &component[n - j]);
            }
        }
        r2[n] = square;
        for (own, body) in bodies.iter_mut().zip(&constants.bodies) {
            if body.strength == 0.0 {
                continue;
            }
            let mut along = [0.0; WIDTH];
            for j in 0..=n {
                add_product(&mut along, &position[0][j], &own.cos[n - j]);
                add_product(&mut along, &in_ecliptic[j], &own.sin[n - j]);
            }
            let one = if n == 0 { 1.0 } else { 0.0 };
            let inverse = 1.0 / body.distance;
            own.apart2[n] = each(|l| one + inverse * (inverse * square[l] - 2.0 * along[l]));
        }
    }

    /// `r⁻³` and `r⁻⁵` of order `n`.
    #[inline(always)]
    fn expand_powers(&mut self, n: usize) {
        let Self { r2, r_3, r_5, .. } = self;
        if n == 0 {
            let inverse = each(|l| 1.0 / r2[0][l]);
            r_3[0] = each(|l| inverse[l] * inverse[l].sqrt());
            r_5[0] = each(|l| r_3[0][l] * inverse[l]);
            return;
        }
        let (mut weighted, mut rest) = ([0.0; WIDTH], [0.0; WIDTH]);
        for k in 1..=n {
            let weight = k as f64;
            add_product(&mut rest, &r2[k], &r_5[n - k]);
            add_product(&mut weighted, &each(|l| weight * r2[k][l]), &r_5[n - k]);
        }
        let factor = -1.5 / n as f64;
        r_3[n] = each(|l| factor * weighted[l]);
        r_5[n] = each(|l| (r_3[n][l] - rest[l]) / r2[0][l]);
    }

    /// The products of powers of `z` and `r` of order `n`.
    #[inline(always)]
    fn expand_oblateness(&mut self, n: usize) {
        let Self { position: [_, _, z], r2, r_5, z_r_5, zz_r_5, zz_r_7, .. } = self;
        let (mut once, mut twice, mut rest) = ([0.0; WIDTH], [0.0; WIDTH], [0.0; WIDTH]);
        for j in 0..=n {
            add_product(&mut once, &z[j], &r_5[n - j]);
        }
        z_r_5[n] = once;
        for j in 0..=n {
            add_product(&mut twice, &z[j], &z_r_5[n - j]);
        }
        zz_r_5[n] = twice;
        for k in 1..=n {
            add_product(&mut rest, &r2[k], &zz_r_7[n - k]);
        }
        zz_r_7[n] = each(|l| (twice[l] - rest[l]) / r2[0][l]);
    }

    /// Position, velocity, `cos` and `sin` of order `n + 1`.
    #[inline(always)]
    fn accelerate(&mut self, n: usize, constants: &Constants) {
        let Self { position, velocity, r_3, r_5, z_r_5, zz_r_7, toward_earth, bodies, pressure, .. } = self;
        let Constants { pace, oblateness, sin_obliquity, cos_obliquity, .. } = *constants;
        let one = if n == 0 { 1.0 } else { 0.0 };
        let mut along_earth = each(|l| r_3[n][l] + oblateness * (r_5[n][l] - 5.0 * zz_r_7[n][l]));
        // Towards the vernal equinox, and across it in the ecliptic.
        let sun = &bodies[0];
        let (mut toward, mut across) = (each(|l| -pressure[l] * sun.cos[n][l]), each(|l| -pressure[l] * sun.sin[n][l]));
        for (own, body) in bodies.iter().zip(&constants.bodies) {
            if body.strength == 0.0 {
                continue;
            }
            let (mut by_cos, mut by_sin) = ([0.0; WIDTH], [0.0; WIDTH]);
            for j in 0..=n {
                add_product(&mut by_cos, &own.excess[j], &own.cos[n - j]);
                add_product(&mut by_sin, &own.excess[j], &own.sin[n - j]);
            }
            let factor = body.strength * body.distance;
            for l in 0..WIDTH {
                along_earth[l] += body.strength * (own.excess[n][l] + one);
                toward[l] += factor * by_cos[l];
                across[l] += factor * by_sin[l];
            }
        }
        toward_earth[n] = along_earth;
        let mut attraction = [[0.0; WIDTH]; 3];
        for j in 0..=n {
            for k in 0..3 {
                add_product(&mut attraction[k], &position[k][j], &toward_earth[n - j]);
            }
        }
        let next = 1.0 / (n + 1) as f64;
        for k in 0..3 {
            position[k][n + 1] = each(|l| next * pace * velocity[k][n][l]);
        }
        let rate = next * pace;
        velocity[0][n + 1] = each(|l| rate * (toward[l] - attraction[0][l]));
        velocity[1][n + 1] = each(|l| rate * (cos_obliquity * across[l] - attraction[1][l]));
        velocity[2][n + 1] =
            each(|l| rate * (sin_obliquity * across[l] - attraction[2][l] - 2.0 * oblateness * z_r_5[n][l]));
        for (own, body) in bodies.iter_mut().zip(&constants.bodies) {
            let pace = next * body.pace;
            own.cos[n + 1] = each(|l| -pace * own.sin[n][l]);
            own.sin[n + 1] = each(|l| pace * own.cos[n][l]);
        }
    }
}

impl<const P: usize> OfBody<P> {
    /// `m^(-3/2) - 1` of order `n`.
    #[inline(always)]
    fn expand_power(&mut self, n: usize) {
        let Self { apart2, excess, .. } = self;
        if n == 0 {
            excess[0] = each(|l| 1.0 / (apart2[0][l] * apart2[0][l].sqrt()) - 1.0);
            return;
        }
        let mut sum = each(|l| -1.5 * n as f64 * apart2[n][l] * (excess[0][l] + 1.0));
        for k in 1..n {
            let weight = -0.5 * k as f64 - n as f64;
            add_product(&mut sum, &each(|l| weight * apart2[k][l]), &excess[n - k]);
        }
        let inverse = 1.0 / n as f64;
        excess[n] = each(|l| inverse * sum[l] / apart2[0][l]);
    }
}

impl<const P: usize> OsculatingSeries<P> {
    /// Puts the Sun and the Moon where they are at a lane's time.
    #[inline(always)]
    fn place_bodies(&mut self, lane: usize) {
        let block = &mut self.blocks[lane / WIDTH];
        for (own, body) in block.bodies.iter_mut().zip(&self.constants.bodies) {
            let longitude = body.longitude(self.time[lane]);
            own.cos[0][lane % WIDTH] = libm::cos(longitude);
            own.sin[0][lane % WIDTH] = libm::sin(longitude);
        }
    }

    /// Gives a lane a radiation parameter of its own.
    #[inline(always)]
    pub(crate) fn irradiate(&mut self, lane: usize, radiation: f64) {
        self.blocks[lane / WIDTH].pressure[lane % WIDTH] = self.model.pressure_of(radiation);
    }

    /// Lets the clearance be that of the pericentre's height ([`super::above_pericentre`]).
    pub(in crate::model) fn watch_height(&mut self, reentry_radius: Option<f64>) {
        self.reentry_radius = reentry_radius;
    }

    #[inline(always)]
    fn state_of(&self, lane: usize) -> State {
        std::array::from_fn(|k| self.state[k].0[0][lane])
    }
}

impl<const P: usize> Series<P> for OsculatingSeries<P> {
    type Model = Osculating;

    #[inline(always)]
    fn new(model: &Osculating) -> Self {
        let (sin_obliquity, cos_obliquity) = model.obliquity.sin_cos();
        let constants = Constants {
            pace: model.pace(),
            oblateness: model.oblateness(),
            bodies: model.bodies(),
            sin_obliquity,
            cos_obliquity,
        };
        let zero = Aligned([[0.0; LANES]; P]);
        let blocks = [Block { pressure: [model.pressure(); WIDTH], ..Block::AT_REST }; LANES / WIDTH];
        let (time, state, clearance) = ([0.0; LANES], [zero; 6], zero);
        Self { model: *model, constants, blocks, time, state, clearance, reentry_radius: None }
    }

    #[inline(always)]
    fn start(&mut self, lane: usize, state: State, time: f64) {
        let (position, velocity) = halves(state);
        let block = &mut self.blocks[lane / WIDTH];
        for k in 0..3 {
            block.position[k][0][lane % WIDTH] = position[k];
            block.velocity[k][0][lane % WIDTH] = velocity[k];
        }
        for (coordinate, value) in self.state.iter_mut().zip(state) {
            coordinate.0[0][lane] = value;
        }
        self.time[lane] = time;
        self.place_bodies(lane);
    }

    #[inline(always)]
    fn expand(&mut self, with_clearance: bool) {
        for (b, block) in self.blocks.iter_mut().enumerate() {
            block.expand(&self.constants);
            let first = b * WIDTH;
            for (own, coordinate) in block.position.iter().chain(&block.velocity).zip(&mut self.state) {
                (0..P).for_each(|n| coordinate.0[n][first..first + WIDTH].copy_from_slice(&own[n]));
            }
            if with_clearance {
                let clearance = clearance(block, self.reentry_radius);
                (0..P).for_each(|n| self.clearance.0[n][first..first + WIDTH].copy_from_slice(&clearance[n]));
            }
        }
    }

    #[inline(always)]
    fn move_on(&mut self, steps: &Lanes) {
        for (b, (block, steps)) in self.blocks.iter_mut().zip(steps.chunks_exact(WIDTH)).enumerate() {
            let both = block.position.iter_mut().chain(&mut block.velocity);
            for (x, coordinate) in both.zip(&mut self.state) {
                let mut sum = x[P - 1];
                for n in (0..P - 1).rev() {
                    for l in 0..WIDTH {
                        sum[l] = sum[l].mul_add(steps[l], x[n][l]);
                    }
                }
                x[0] = sum;
                coordinate.0[0][b * WIDTH..(b + 1) * WIDTH].copy_from_slice(&sum);
            }
        }
        for lane in 0..LANES {
            if steps[lane] != 0.0 {
                self.time[lane] += steps[lane] / SUN_MEAN_MOTION;
                self.place_bodies(lane);
            }
        }
    }

    #[inline(always)]
    fn is_inside(&self, lane: usize) -> bool {
        self.model.is_inside(self.state_of(lane))
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

/// `1 - e² = |r × v|² (2/r - v²)` of some lanes, or what [`super::above_pericentre`] says of a height.
#[inline(always)]
fn clearance<const P: usize>(block: &Block<P>, reentry_radius: Option<f64>) -> Coefficients<P> {
    let Block { position, velocity, r2, r_3, .. } = block;
    let product = |a: &Coefficients<P>, b: &Coefficients<P>, n: usize| {
        let mut sum: Part = [0.0; WIDTH];
        (0..=n).for_each(|j| add_product(&mut sum, &a[j], &b[n - j]));
        sum
    };
    let mut momentum = [Block::<P>::ZERO; 3];
    let (mut square, mut energy, mut clearance) = (Block::<P>::ZERO, Block::<P>::ZERO, Block::<P>::ZERO);
    for n in 0..P {
        for k in 0..3 {
            let (a, b) = ((k + 1) % 3, (k + 2) % 3);
            let (plus, minus) = (product(&position[a], &velocity[b], n), product(&position[b], &velocity[a], n));
            momentum[k][n] = each(|l| plus[l] - minus[l]);
        }
        let inverse = product(r2, r_3, n);
        let speed = [0, 1, 2].map(|k| product(&velocity[k], &velocity[k], n));
        energy[n] = each(|l| 2.0 * inverse[l] - speed[0][l] - speed[1][l] - speed[2][l]);
        let squares = [0, 1, 2].map(|k| product(&momentum[k], &momentum[k], n));
        square[n] = each(|l| squares[0][l] + squares[1][l] + squares[2][l]);
        clearance[n] = match reentry_radius {
            None => product(&square, &energy, n),
            Some(radius) => {
                each(|l| radius * radius * energy[n][l] + square[n][l] - if n == 0 { 2.0 * radius } else { 0.0 })
            }
        };
    }
    clearance
}

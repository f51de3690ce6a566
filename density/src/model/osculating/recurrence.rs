//! The Taylor recurrence of the unaveraged model, written out for speed.
//!
//! In the time unit `1/n_sun`, with `g = r²`, `m = |b - r/D|²` for the Sun and the Moon, and `c`, `d` the cosine and
//! sine of their longitudes,
//!
//! ```text
//! r' = N v      v' = N [-r S - 2 (W/N) z g^(-5/2) p - σ s + Σ q D b (m^(-3/2) - 1)]
//! S  = g^(-3/2) + (W/N) (g^(-5/2) - 5 z² g^(-7/2)) + Σ q m^(-3/2)
//! ```
//!
//! This takes 11 Cauchy products per order, and 5 more for each body. The powers follow without a root: `y = g^(-3/2)`
//! and `w = y/g` have `n y_n = -(3/2) Σ_{k=1..n} k g_k w_{n-k}`.

use super::Body;
use crate::model::part::{Coefficients, Part, WIDTH, add_product, each};

/// Everything that is expanded of some lanes, in the notation of the head of this file.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Block<const P: usize> {
    pub position: [Coefficients<P>; 3],
    pub velocity: [Coefficients<P>; 3],
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
    pub bodies: [OfBody<P>; 2],
    /// `σ` of each lane.
    pub pressure: Part,
}

/// What is expanded of the Sun or the Moon.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct OfBody<const P: usize> {
    pub cos: Coefficients<P>,
    pub sin: Coefficients<P>,
    /// `m` and `m^(-3/2)`, the latter less 1.
    apart2: Coefficients<P>,
    excess: Coefficients<P>,
}

/// The parameters of a model as the recurrence needs them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Constants {
    pub pace: f64,
    pub oblateness: f64,
    pub bodies: [Body; 2],
    pub sin_obliquity: f64,
    pub cos_obliquity: f64,
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

    /// Lanes without a start, all under the same pressure `σ`.
    #[inline(always)]
    pub fn under_pressure(pressure: f64) -> Self {
        Self { pressure: [pressure; WIDTH], ..Self::AT_REST }
    }

    /// Computes all coefficients from those of order 0 of position, velocity, `cos` and `sin`.
    #[inline(always)]
    pub fn expand(&mut self, constants: &Constants) {
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

/// `1 - e² = |r × v|² (2/r - v²)` of some lanes, or what [`super::above_pericentre`] says of a height.
#[inline(always)]
pub(super) fn clearance<const P: usize>(block: &Block<P>, reentry_radius: Option<f64>) -> Coefficients<P> {
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

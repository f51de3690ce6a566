//! Functions of many angles side by side.
//!
//! Every lane is computed by correctly rounded operations alone, the same ones whatever its neighbours, so a result is
//! the same bytes in any lane and on any machine. They differ from those of the platform's library in the last bit.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, PI, TAU};

use multiversion::multiversion;

/// Number of orbits that the integrator moves side by side: three sums in as many vector registers as AVX2 has to
/// spare.
pub const LANES: usize = 16;

/// One number per lane.
pub type Lanes = [f64; LANES];

/// π/2 is `FRAC_PI_2 + PI_2_REST`.
const PI_2_REST: f64 = 6.123_233_995_736_766e-17;
/// Angles up to this size are reduced to a quadrant by [`FRAC_PI_2`] and [`PI_2_REST`].
pub const LARGEST_ANGLE: f64 = 1e4;

/// Coefficients of `sin(r) = r + r z (S0 + S1 z + ...)`, `z = r²`, on `[-π/4, π/4]` (Sun Microsystems' fdlibm,
/// `k_sin.c`).
#[allow(clippy::excessive_precision)]
const SINE: [f64; 6] = [
    -1.66666666666666324348e-01,
    8.33333333332248946124e-03,
    -1.98412698298579493134e-04,
    2.75573137070700676789e-06,
    -2.50507602534068634195e-08,
    1.58969099521155010221e-10,
];

/// Coefficients of `cos(r) = 1 - z/2 + z² (C0 + C1 z + ...)` (`k_cos.c`).
#[allow(clippy::excessive_precision)]
const COSINE: [f64; 6] = [
    4.16666666666666019037e-02,
    -1.38888888888741095749e-03,
    2.48015872894767294178e-05,
    -2.75573143513906633035e-07,
    2.08757232129817482790e-09,
    -1.13596475577881948265e-11,
];

/// Numerator and denominator of `atan(t) = t + t z P(z)/Q(z)`, `z = t²`, on `[-0.66, 0.66]` (Moshier's Cephes,
/// `atan.c`), from the constant on.
#[allow(clippy::excessive_precision)]
const ARC_NUMERATOR: [f64; 5] = [
    -6.485021904942025371773e1,
    -1.228866684490136173410e2,
    -7.500855792314704667340e1,
    -1.615753718733365076637e1,
    -8.750608600031904122785e-1,
];
#[allow(clippy::excessive_precision)]
const ARC_DENOMINATOR: [f64; 6] = [
    1.945506571482613964425e2,
    4.853903996359136964868e2,
    4.328810604912902668951e2,
    1.650270098316988542046e2,
    2.485846490142306297962e1,
    1.0,
];
/// tan(π/8): beyond it an angle is measured from π/4.
const TAN_PI_8: f64 = 0.414_213_562_373_095_05;

#[inline(always)]
fn polynomial<const P: usize>(coefficients: &[f64; P], z: f64) -> f64 {
    let mut sum = coefficients[P - 1];
    for k in (0..P - 1).rev() {
        sum = sum.mul_add(z, coefficients[k]);
    }
    sum
}

/// Number of samples in a batch: enough for a loop over them to be worth its beginning.
pub const BATCH: usize = 64;

/// One number of each sample of a batch.
pub type Batch = [f64; BATCH];

/// A whole number of less than 2^51 as an integer: next to 1.5 2^52 the last bits of a floating-point number count
/// units. A conversion by `as` would not be done for many numbers at once.
#[inline(always)]
pub fn whole_number(value: f64) -> i64 {
    const MAGIC: f64 = 1.5 * (1u64 << 52) as f64;
    ((value + MAGIC).to_bits() as i64).wrapping_sub(MAGIC.to_bits() as i64)
}

/// Sine and cosine of an angle up to [`LARGEST_ANGLE`] \[rad\], to about 2e-16.
#[inline(always)]
pub fn sin_cos(angle: f64) -> (f64, f64) {
    let turns = (angle * FRAC_2_PI).round_ties_even();
    let rest = (-turns).mul_add(PI_2_REST, (-turns).mul_add(FRAC_PI_2, angle));
    let z = rest * rest;
    let sine = (rest * z).mul_add(polynomial(&SINE, z), rest);
    let cosine = (z * z).mul_add(polynomial(&COSINE, z), 1.0 - 0.5 * z);
    let quadrant = turns - 4.0 * (0.25 * turns).floor();
    let is_odd = quadrant == 1.0 || quadrant == 3.0;
    let (s, c) = if is_odd { (cosine, sine) } else { (sine, cosine) };
    (if quadrant >= 2.0 { -s } else { s }, if quadrant == 1.0 || quadrant == 2.0 { -c } else { c })
}

/// Solar angles in `[0, 2π)` \[rad\] and eccentricities of the states `(x1, x2)`, to about 1e-15.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
pub fn polar(x1: &Lanes, x2: &Lanes, angles: &mut Lanes, lengths: &mut Lanes) {
    for l in 0..LANES {
        let (a, b) = (x1[l].abs(), x2[l].abs());
        let (low, high) = (a.min(b), a.max(b));
        let is_steep = low > TAN_PI_8 * high;
        let (top, bottom) = if is_steep { (low - high, low + high) } else { (low, high) };
        let t = if bottom > 0.0 { top / bottom } else { 0.0 };
        let z = t * t;
        let arc = (t * z).mul_add(polynomial(&ARC_NUMERATOR, z) / polynomial(&ARC_DENOMINATOR, z), t);
        let arc = if is_steep { arc + FRAC_PI_4 } else { arc };
        // The angle is measured from the x2 axis.
        let arc = if a > b { FRAC_PI_2 - arc } else { arc };
        let arc = if x2[l] < 0.0 { PI - arc } else { arc };
        let arc = if x1[l] < 0.0 { TAU - arc } else { arc };
        angles[l] = if arc >= TAU { TAU.next_down() } else { arc };
        lengths[l] = x1[l].mul_add(x1[l], x2[l] * x2[l]).sqrt();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::plane::State;

    #[test]
    fn whole_numbers_are_converted_exactly() {
        for k in 0..50 {
            for near in [-1, 0, 1] {
                let number = (1i64 << k) + near;
                assert_eq!((whole_number(number as f64), whole_number(-number as f64)), (number, -number));
            }
        }
    }

    #[test]
    fn sines_and_cosines_are_those_of_the_library() {
        for k in -20_000..20_000 {
            let angle = f64::from(k) * 0.0137;
            let ((sine, cosine), (sin, cos)) = (sin_cos(angle), angle.sin_cos());
            assert!((sine - sin).abs() < 3e-16 && (cosine - cos).abs() < 3e-16, "{angle}");
        }
    }

    #[test]
    fn polar_coordinates_are_those_of_a_single_state() {
        let (mut angles, mut lengths) = ([1.0; LANES], [1.0; LANES]);
        polar(&[0.0; LANES], &[0.0; LANES], &mut angles, &mut lengths);
        assert_eq!((angles[0], lengths[0]), (0.0, 0.0));
        for k in 0..40_000 {
            let (phi, e) = (f64::from(k) * 0.000_157_1, 0.9 * f64::from(k % 97 + 1) / 97.0);
            let state = State::from_polar(phi, e);
            polar(&[state.x1; LANES], &[state.x2; LANES], &mut angles, &mut lengths);
            assert!((angles[0] - state.solar_angle()).abs() < 1e-15, "{phi}: {} {}", angles[0], state.solar_angle());
            assert!((lengths[0] - state.eccentricity()).abs() < 3e-16);
            assert!((0.0..TAU).contains(&angles[0]));
        }
    }
}

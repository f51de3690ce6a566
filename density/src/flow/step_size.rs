//! How far a Taylor series reaches.

use crate::model::{Coordinates, LANES, Lanes, Model, Series};

/// How far each lane's series reaches, judged by its last two coefficients.
#[inline(always)]
#[allow(clippy::needless_range_loop, reason = "a loop over lanes like all others")]
pub(super) fn radii<const P: usize, S: Series<P>>(series: &S) -> Lanes {
    let (last, before) = (P - 1, P - 2);
    let (inverse_last, inverse_before) = (1.0 / last as f64, 1.0 / before as f64);
    let (mut size_last, mut size_before) = ([0.0; LANES], [0.0; LANES]);
    for k in 0..<S::Model as Model>::State::<f64>::COUNT {
        let coefficients = series.coordinate(k);
        for l in 0..LANES {
            size_last[l] = coefficients[last][l].abs().max(size_last[l]);
            size_before[l] = coefficients[before][l].abs().max(size_before[l]);
        }
    }
    let mut radii = [0.0; LANES];
    for l in 0..LANES {
        radii[l] = power(size_last[l], -inverse_last).min(power(size_before[l], -inverse_before));
    }
    radii
}

/// `a^exponent` for `-1 <= exponent < 0` to within 0.8 %, from the bits of `a` and two parabolas: good enough for a
/// step size, and the same on every machine. `a = 0` gives a huge but finite number.
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

//! Adds samples to the sums, [`LANES`] at a time.
//!
//! A term is cut to whole units and added exactly, as everywhere here, but in two numbers of 64 bits: its upper part in
//! units of 2^32, and the rest. Neither sum can overflow before [`MOST`] samples, and both together are the same whole number as
//! the sum of the whole terms.

use std::f64::consts::{PI, TAU};

use multiversion::multiversion;

use super::{COMMON_SUMS, Frame, REACH, SECTOR_SUMS, SECTORS, SampleSums, UNIT, sector_of};
use crate::lanes::{LARGEST_ANGLE, sin_cos};
use crate::model::{LANES, Lanes};

/// Number of terms of a sample.
const TERMS: usize = COMMON_SUMS + SECTOR_SUMS;
/// An upper part is a whole number of so many units.
const UPPER: f64 = (1u64 << 32) as f64;
/// A term is at most 2^76 units, so 2^44 upper units, of which a sum of 64 bits holds 2^19.
const MOST: usize = 1 << 18;

/// The terms of [`LANES`] samples in two parts.
struct Terms {
    upper: [[i64; LANES]; TERMS],
    lower: [[i64; LANES]; TERMS],
    /// Where each lies from the grid's centre in solar angle \[rad\].
    offsets: Lanes,
    /// How many are above the critical eccentricity.
    above: u64,
}

/// The sums of a sector in two parts.
#[derive(Clone, Copy)]
struct Parts {
    samples: u64,
    upper: [i64; SECTOR_SUMS],
    lower: [i64; SECTOR_SUMS],
}

/// Sums under way.
pub(super) struct Accumulator {
    samples: usize,
    above: u64,
    /// The terms of the last block.
    terms: Terms,
    common: ([[i64; LANES]; COMMON_SUMS], [[i64; LANES]; COMMON_SUMS]),
    sectors: Vec<Parts>,
}

/// What [`nearest`](crate::angle::nearest) to 0 is, bit by bit, of an angle less than one and a half turns from it.
#[inline(always)]
fn nearest_to_zero(offset: f64) -> f64 {
    let from_low = offset + PI;
    let folded = if from_low >= TAU { from_low - TAU } else { from_low + TAU } - PI;
    let folded = if folded >= TAU - PI { -PI } else { folded };
    if (-PI..PI).contains(&offset) { offset } else { folded }
}

/// A whole number of less than 2^51 as an integer: next to 1.5 2^52 the last bits of a floating-point number count units. A
/// conversion by `as` would not be done for many numbers at once.
#[inline(always)]
fn whole_number(value: f64) -> i64 {
    const MAGIC: f64 = 1.5 * (1u64 << 52) as f64;
    ((value + MAGIC).to_bits() as i64).wrapping_sub(MAGIC.to_bits() as i64)
}

#[inline(always)]
fn product(a: &Lanes, b: &Lanes) -> Lanes {
    let mut product = [0.0; LANES];
    for l in 0..LANES {
        product[l] = a[l] * b[l];
    }
    product
}

/// The terms of a block of samples; false if one of them needs closer attention.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2+fma", "x86_64+avx2+fma", "aarch64+neon"))]
fn terms_of(frame: &Frame, phi: &Lanes, e: &Lanes, critical_e: f64, terms: &mut Terms) -> bool {
    let (mut s, mut t, mut is_plain) = ([0.0; LANES], [0.0; LANES], true);
    for l in 0..LANES {
        let offset = phi[l] - frame.phi;
        let from_low = offset + PI;
        terms.offsets[l] = nearest_to_zero(offset);
        s[l] = terms.offsets[l] / frame.half_phi;
        t[l] = (e[l] - frame.e) / frame.half_e;
        let is_near = s[l].abs() <= REACH && t[l].abs() <= REACH && phi[l].abs() <= LARGEST_ANGLE;
        is_plain &= is_near && (-TAU..2.0 * TAU).contains(&from_low);
    }
    if !is_plain {
        return false;
    }
    let (sin, cos) = sin_cos(phi);
    let (s2, t2) = (product(&s, &s), product(&t, &t));
    let values: [Lanes; TERMS] = [
        sin,
        cos,
        product(&t2, &t),
        product(&t2, &t2),
        s,
        s2,
        product(&s2, &s),
        product(&s2, &s2),
        t,
        t2,
        product(&s, &t),
        product(&s2, &t),
        product(&s, &t2),
        product(&s2, &t2),
    ];
    // One loop over all of them, which the compiler turns into vectors.
    let parts = terms.upper.as_flattened_mut().iter_mut().zip(terms.lower.as_flattened_mut());
    for ((upper, lower), value) in parts.zip(values.as_flattened()) {
        let units = value / UNIT;
        let whole = (units / UPPER).trunc();
        *upper = whole_number(whole);
        *lower = whole_number((-whole).mul_add(UPPER, units).trunc());
    }
    terms.above = e.iter().map(|&e| u64::from(e > critical_e)).sum();
    true
}

impl Accumulator {
    pub fn new() -> Self {
        let none = Parts { samples: 0, upper: [0; SECTOR_SUMS], lower: [0; SECTOR_SUMS] };
        let zeros = [[0; LANES]; COMMON_SUMS];
        let of_block = [[0; LANES]; TERMS];
        let terms = Terms { upper: of_block, lower: of_block, offsets: [0.0; LANES], above: 0 };
        Self { samples: 0, above: 0, terms, common: (zeros, zeros), sectors: vec![none; SECTORS] }
    }

    /// Adds a block of samples to the sums; false, and nothing is added, if one of them needs closer attention.
    pub fn take(&mut self, frame: &Frame, phi: &Lanes, e: &Lanes, critical_e: f64) -> bool {
        debug_assert!(self.samples < MOST);
        if !terms_of(frame, phi, e, critical_e, &mut self.terms) {
            return false;
        }
        let terms = &self.terms;
        self.samples += LANES;
        self.above += terms.above;
        for k in 0..COMMON_SUMS {
            for l in 0..LANES {
                self.common.0[k][l] += terms.upper[k][l];
                self.common.1[k][l] += terms.lower[k][l];
            }
        }
        for l in 0..LANES {
            let sector = &mut self.sectors[sector_of(terms.offsets[l])];
            sector.samples += 1;
            for k in 0..SECTOR_SUMS {
                sector.upper[k] += terms.upper[COMMON_SUMS + k][l];
                sector.lower[k] += terms.lower[COMMON_SUMS + k][l];
            }
        }
        true
    }

    /// Adds the sums to others.
    pub fn add_to(&self, sums: &mut SampleSums) {
        let whole = |upper: i64, lower: i64| i128::from(upper) * (UPPER as i128) + i128::from(lower);
        sums.samples += self.samples as u64;
        sums.above += self.above;
        for (k, sum) in sums.common.iter_mut().enumerate() {
            *sum += (0..LANES).map(|l| whole(self.common.0[k][l], self.common.1[k][l])).sum::<i128>();
        }
        for (sector, parts) in sums.sectors.iter_mut().zip(&self.sectors).filter(|(_, parts)| parts.samples > 0) {
            sector.samples += parts.samples;
            for k in 0..SECTOR_SUMS {
                sector.sums[k] += whole(parts.upper[k], parts.lower[k]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::angle::nearest;

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
    fn an_angle_is_brought_next_to_zero_as_everywhere_else() {
        for k in -9400..9400 {
            for offset in [f64::from(k) * 1e-3, f64::from(k / 3000) * PI, (f64::from(k / 3000) * PI).next_up()] {
                if (-TAU..2.0 * TAU).contains(&(offset + PI)) {
                    let nearest = if (-PI..PI).contains(&offset) { offset } else { nearest(offset, 0.0) };
                    assert_eq!(nearest_to_zero(offset).to_bits(), nearest.to_bits(), "{offset}");
                }
            }
        }
    }
}

//! Whole numbers of units in two halves of 64 bits.
//!
//! A term is rounded to whole units and added exactly, as everywhere here, but in two numbers: its upper half in units
//! of 2^32, and the rest. Both together are the same whole number as the sum of the whole terms.
//!
//! A floating-point number is rounded to whole units by adding [`UPPER`] or [`LOWER`], next to which neighbours are one
//! unit apart; the bits of the sum, read as an integer, then count units from the bits of that constant. So bits are
//! added as they are, and the constant's bits are taken off once, for all terms.

/// Next to it floating-point numbers are 2^32 units, which is 2^-28, apart.
const UPPER: f64 = 1.5 * (1u64 << 24) as f64;
/// Next to it they are a unit, which is 2^-60, apart.
const LOWER: f64 = 1.5 / (1u64 << 8) as f64;
/// A term is at most 2^76 units, so 2^44 units of an upper half, of which a sum of 64 bits holds 2^19.
const MOST: usize = 1 << 18;

/// Sums of the bits of both halves of terms.
#[derive(Debug, Clone, Copy)]
pub(super) struct Halves {
    upper: i64,
    lower: i64,
}

impl Halves {
    pub const NONE: Self = Self { upper: 0, lower: 0 };

    /// Adds a term.
    #[inline(always)]
    pub fn add(&mut self, term: f64) {
        let near = term + UPPER;
        let rest = term - (near - UPPER);
        self.upper = self.upper.wrapping_add(near.to_bits() as i64);
        self.lower = self.lower.wrapping_add((rest + LOWER).to_bits() as i64);
    }

    /// The sum of so many terms, at most [`MOST`].
    pub fn total(&self, terms: usize) -> i128 {
        debug_assert!(terms <= MOST);
        let sum = |bits: i64, constant: f64| {
            i128::from(bits.wrapping_sub((terms as i64).wrapping_mul(constant.to_bits() as i64)))
        };
        (sum(self.upper, UPPER) << 32) + sum(self.lower, LOWER)
    }
}

#[cfg(test)]
mod tests {
    use super::super::units;
    use super::*;

    #[test]
    fn a_sum_in_halves_is_the_sum_of_whole_terms() {
        let mut sum = Halves::NONE;
        let mut expected = 0;
        let mut count = 0;
        for k in -70..=15 {
            for mantissa in [1.0, 1.5, 1.25, 1.0 + f64::EPSILON, 1.999_999, 1.000_123_4, 1.875] {
                let term = mantissa * 2f64.powi(k);
                for term in [term, -term, term / 3.0, 0.0] {
                    sum.add(term);
                    expected += units(term);
                    count += 1;
                    assert_eq!(sum.total(count), expected, "{term:e}");
                }
            }
        }
    }

    #[test]
    fn the_largest_terms_do_not_overflow() {
        let mut sum = Halves::NONE;
        (0..MOST).for_each(|_| sum.add(65_536.0));
        assert_eq!(sum.total(MOST), units(65_536.0) * MOST as i128);
    }
}

//! Arithmetic on the Taylor coefficients of a few lanes at a time, for recurrences that are written out by hand.

/// Number of lanes that are expanded at a time: few enough for the coefficients of a model to stay in the first cache.
pub const WIDTH: usize = 8;

/// One number for each of the lanes that are expanded at a time.
pub type Part = [f64; WIDTH];

/// Taylor coefficients of [`WIDTH`] lanes.
pub type Coefficients<const P: usize> = [Part; P];

/// Adds a product to a sum.
#[inline(always)]
pub fn add_product(sum: &mut Part, a: &Part, b: &Part) {
    for l in 0..WIDTH {
        sum[l] = a[l].mul_add(b[l], sum[l]);
    }
}

/// Subtracts a product from a sum.
#[inline(always)]
pub fn subtract_product(sum: &mut Part, a: &Part, b: &Part) {
    for l in 0..WIDTH {
        sum[l] = (-a[l]).mul_add(b[l], sum[l]);
    }
}

/// A function of the numbers of every lane.
#[inline(always)]
pub fn each(value: impl Fn(usize) -> f64) -> Part {
    let mut values = [0.0; WIDTH];
    for (l, lane) in values.iter_mut().enumerate() {
        *lane = value(l);
    }
    values
}

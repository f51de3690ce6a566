//! How the starts of orbits are drawn.

use std::ops::Range;

/// The starts of orbits as a function of the range of their numbers: the variables, on the branch of the initial Gaussian's mean. A start depends on
/// its number alone.
pub type Draw<const N: usize> = Box<dyn Fn(Range<usize>) -> Vec<[f64; N]> + Send + Sync>;

/// Draws that are made one at a time.
pub fn one_by_one<const N: usize>(draw: impl Fn(usize) -> [f64; N] + Send + Sync + 'static) -> Draw<N> {
    Box::new(move |numbers| numbers.map(&draw).collect())
}

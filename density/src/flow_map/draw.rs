//! How the starts of orbits are drawn.

use std::ops::Range;

/// The starts of orbits as a function of the range of their numbers: the variables, on the branch of the initial
/// Gaussian's mean. A start depends on its number alone.
pub type Draw<const N: usize> = Box<dyn Fn(Range<usize>) -> Vec<[f64; N]> + Send + Sync>;

/// The numbers of a chunk of orbits, of chunks of `length`.
pub(super) fn numbers_of(numbers: &Range<usize>, length: usize, chunk: usize) -> Range<usize> {
    let first = numbers.start + chunk * length;
    first..numbers.end.min(first + length)
}

/// Draws that are made one at a time.
pub fn one_by_one<const N: usize>(draw: impl Fn(usize) -> [f64; N] + Send + Sync + 'static) -> Draw<N> {
    Box::new(move |numbers| numbers.map(&draw).collect())
}

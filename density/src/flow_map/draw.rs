//! How the starts of orbits are drawn.

/// The start of an orbit as a function of its number: the variables, on the branch of the initial Gaussian's mean.
pub type Draw<const N: usize> = Box<dyn Fn(usize) -> [f64; N] + Send + Sync>;

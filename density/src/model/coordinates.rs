//! A fixed number of coordinates, whatever they are called.

/// Some coordinates: an array, or a structure whose fields have names.
pub trait Coordinates<T>: Copy {
    /// Number of coordinates.
    const COUNT: usize;

    /// The coordinates whose number `k` is `component(k)`.
    fn from_fn(component: impl FnMut(usize) -> T) -> Self;

    /// Coordinate number `k`.
    ///
    /// # Panics
    /// If there is no coordinate number `k`.
    fn component(&self, k: usize) -> T;
}

impl<T: Copy, const N: usize> Coordinates<T> for [T; N] {
    const COUNT: usize = N;

    #[inline(always)]
    fn from_fn(component: impl FnMut(usize) -> T) -> Self {
        std::array::from_fn(component)
    }

    #[inline(always)]
    fn component(&self, k: usize) -> T {
        self[k]
    }
}

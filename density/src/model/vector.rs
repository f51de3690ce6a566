//! Vectors in space, over any quantity.

use super::quantity::Quantity;

/// A vector by its components in equatorial axes: the first towards the vernal equinox, the third towards the Earth's
/// north pole.
pub type Vector<T> = [T; 3];

/// Sum.
pub fn plus<T: Quantity>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// A vector times a number.
pub fn times<T: Quantity>(a: Vector<T>, factor: T) -> Vector<T> {
    a.map(|component| component * factor)
}

/// Scalar product.
pub fn dot<T: Quantity>(a: Vector<T>, b: Vector<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
pub fn cross<T: Quantity>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Length.
pub fn length(a: Vector<f64>) -> f64 {
    dot(a, a).sqrt()
}

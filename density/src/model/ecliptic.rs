//! Directions in the ecliptic, in equatorial axes.

use super::quantity::Quantity;
use super::vector::Vector;

/// Obliquity of the ecliptic at J2000 \[deg\] (IAU 1976: 23° 26′ 21.448″, to four digits).
pub const OBLIQUITY_DEGREES: f64 = 23.4393;

/// The unit vector in the ecliptic at a longitude, given by its sine and cosine; `obliquity` is in radians.
pub fn direction<T: Quantity>((sin, cos): (T, T), obliquity: f64) -> Vector<T> {
    let (sin_obliquity, cos_obliquity) = obliquity.sin_cos();
    [cos, sin * cos_obliquity, sin * sin_obliquity]
}

/// The pole of the ecliptic; `obliquity` is in radians.
pub fn pole(obliquity: f64) -> Vector<f64> {
    let (sin, cos) = obliquity.sin_cos();
    [0.0, -sin, cos]
}

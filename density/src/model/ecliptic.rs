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

/// Mean longitudes of the Sun and of the Moon in the ecliptic \[deg\], from the mean equinox of the date, `centuries`
/// Julian centuries after J2000.0 (2000-01-01 12:00 in terrestrial time); not reduced to one turn.
///
/// J. Meeus, *Astronomical Algorithms*, 2nd edition, 1998, Eqs. 25.2 and 47.1, without the terms beyond the square.
/// They are the longitudes of circular orbits, as the models take them: the true Sun is up to 1.9° away, the true Moon
/// up to 7.6°.
pub fn mean_longitudes(centuries: f64) -> [f64; 2] {
    let t = centuries;
    let sun = 280.46646 + (36_000.769_83 + 0.000_303_2 * t) * t;
    let moon = 218.316_447_7 + (481_267.881_234_21 - 0.001_578_6 * t) * t;
    [sun, moon]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Meeus (1998), examples 25.a and 47.a.
    #[test]
    fn the_mean_longitudes_are_those_of_the_worked_examples() {
        let [sun, _] = mean_longitudes(-0.072_183_436);
        assert!((sun.rem_euclid(360.0) - 201.807_20).abs() < 1e-5, "{sun}");
        let [_, moon] = mean_longitudes(-0.077_221_081_451);
        assert!((moon.rem_euclid(360.0) - 134.290_182).abs() < 1e-5, "{moon}");
    }
}

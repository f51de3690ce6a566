//! Constants of the Earth and the Sun, SI units, and the unit of time.

use std::f64::consts::TAU;

/// Mean motion of the Sun \[rad/yr\].
pub const SUN_MEAN_MOTION: f64 = TAU;

/// Equatorial radius \[m\] (WGS 84).
pub const RADIUS: f64 = 6_378_137.0;
/// Gravitational parameter \[m³/s²\] (WGS 84).
pub const MU: f64 = 3.986_004_418e14;
/// Second zonal harmonic (EGM 96).
pub const J2: f64 = 1.082_626_68e-3;
/// Distance of the Sun, 1 AU \[m\] (IAU 2012).
pub const SUN_DISTANCE: f64 = 1.495_978_707e11;
/// Solar flux at 1 AU \[W/m²\] (IAU 2015 nominal total irradiance).
pub const SOLAR_FLUX: f64 = 1361.0;
/// Speed of light \[m/s\].
pub const LIGHT_SPEED: f64 = 299_792_458.0;
/// Sidereal year \[s\] (IERS).
pub const YEAR: f64 = 365.256_363 * 86_400.0;

/// Mean motion of a satellite \[rad/s\], from its semi-major axis in Earth radii.
pub fn mean_motion(semi_major_axis: f64) -> f64 {
    (MU / (semi_major_axis * RADIUS).powi(3)).sqrt()
}

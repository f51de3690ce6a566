//! Position and velocity on an ellipse from its elements, and back. Units are such that the Earth's gravitational
//! parameter is 1.

use crate::model::elements::{Elements, Vectors};
use crate::model::vector::{Vector, cross, dot, length, plus, times};

/// An ellipse and the place on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Semi-major axis.
    pub axis: f64,
    /// Eccentricity vector, and angular momentum vector in units of the square root of the semi-major axis.
    pub vectors: Vectors,
    /// Mean anomaly \[rad\].
    pub mean_anomaly: f64,
}

impl Motion {
    /// The ellipse on which a satellite at this position moves with this velocity, which must be less than that of
    /// escape.
    pub fn of(position: Vector<f64>, velocity: Vector<f64>) -> Self {
        let r = length(position);
        let axis = 1.0 / (2.0 / r - dot(velocity, velocity));
        let momentum = cross(position, velocity);
        let e = plus(cross(velocity, momentum), times(position, -1.0 / r));
        let h = times(momentum, 1.0 / axis.sqrt());
        let (e_sin, e_cos) = (dot(position, velocity) / axis.sqrt(), 1.0 - r / axis);
        Self { axis, vectors: Vectors { e, h }, mean_anomaly: e_sin.atan2(e_cos) - e_sin }
    }

    /// Position and velocity. The pericentre of a circular orbit is taken towards the vernal equinox or, if the orbit
    /// is perpendicular to that, towards the equator.
    pub fn position_and_velocity(&self) -> (Vector<f64>, Vector<f64>) {
        let Self { axis, vectors: Vectors { e, h }, mean_anomaly } = *self;
        let eccentricity = length(e);
        let normal = times(h, 1.0 / length(h));
        let along = if eccentricity > 0.0 { times(e, 1.0 / eccentricity) } else { any_perpendicular(normal) };
        on_ellipse((axis, eccentricity), (along, normal), mean_anomaly)
    }
}

/// Position and velocity on the ellipse with these elements and this semi-major axis. The place on a circular orbit is
/// at the longitude of pericentre plus the mean anomaly.
pub fn place(elements: &Elements, axis: f64, mean_anomaly: f64) -> (Vector<f64>, Vector<f64>) {
    on_ellipse((axis, elements.eccentricity), elements.axes(), mean_anomaly)
}

/// Position and velocity on an ellipse of this semi-major axis and eccentricity, whose pericentre lies `along`.
fn on_ellipse(
    (axis, eccentricity): (f64, f64),
    (along, normal): (Vector<f64>, Vector<f64>),
    mean_anomaly: f64,
) -> (Vector<f64>, Vector<f64>) {
    let across = cross(normal, along);
    let eta = ((1.0 - eccentricity) * (1.0 + eccentricity)).sqrt();
    let (sin, cos) = eccentric_anomaly(mean_anomaly, eccentricity).sin_cos();
    let in_plane = |x: f64, y: f64| plus(times(along, x), times(across, y));
    let pace = 1.0 / (axis.sqrt() * (1.0 - eccentricity * cos));
    (in_plane(axis * (cos - eccentricity), axis * eta * sin), in_plane(-pace * sin, pace * eta * cos))
}

/// A unit vector perpendicular to a given one.
fn any_perpendicular(normal: Vector<f64>) -> Vector<f64> {
    let candidates = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let across = candidates.map(|axis| plus(axis, times(normal, -dot(axis, normal))));
    let chosen = if length(across[0]) > 1e-3 { across[0] } else { across[1] };
    times(chosen, 1.0 / length(chosen))
}

/// The eccentric anomaly `E` with `E - e sin(E) = M`, by Newton's method from Danby's start (Fundamentals of Celestial
/// Mechanics, 1988, Sect. 6.6), from which it converges for every `e < 1`.
pub fn eccentric_anomaly(mean_anomaly: f64, eccentricity: f64) -> f64 {
    const MOST_STEPS: u32 = 50;
    let mut anomaly = mean_anomaly + 0.85 * eccentricity * mean_anomaly.sin().signum();
    for _ in 0..MOST_STEPS {
        let (sin, cos) = anomaly.sin_cos();
        let step = (anomaly - eccentricity * sin - mean_anomaly) / (1.0 - eccentricity * cos);
        anomaly -= step;
        if step.abs() < 1e-15 * (1.0 + anomaly.abs()) {
            break;
        }
    }
    anomaly
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_eccentric_anomaly_solves_keplers_equation() {
        for eccentricity in [0.0, 0.1, 0.9, 0.999] {
            for k in 0..100 {
                let mean = f64::from(k) * 0.1 - 4.0;
                let found = eccentric_anomaly(mean, eccentricity);
                assert!((found - eccentricity * found.sin() - mean).abs() < 1e-14, "{eccentricity} {mean}");
            }
        }
    }

    #[test]
    fn position_and_velocity_give_the_ellipse_back() {
        for eccentricity in [0.05, 0.7] {
            for mean_anomaly in [-3.0, -0.5, 1.0, 2.9] {
                let elements = Elements { eccentricity, inclination: 1.1, node: 2.0, longitude_of_pericentre: 5.0 };
                let given = Motion { axis: 1.3, vectors: elements.vectors(), mean_anomaly };
                let (position, velocity) = given.position_and_velocity();
                let found = Motion::of(position, velocity);
                assert!((found.axis - 1.3).abs() < 1e-14 && (found.mean_anomaly - mean_anomaly).abs() < 1e-13);
                let apart = |a: Vector<f64>, b: Vector<f64>| length(plus(a, times(b, -1.0)));
                assert!(apart(found.vectors.e, given.vectors.e) < 1e-14);
                assert!(apart(found.vectors.h, given.vectors.h) < 1e-14);
            }
        }
    }

    #[test]
    fn a_circular_orbit_has_a_place_wherever_its_plane_lies() {
        for (inclination, node) in [(0.0, 0.0), (std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2)] {
            let elements = Elements { eccentricity: 0.0, inclination, node, longitude_of_pericentre: 0.0 };
            let motion = Motion { axis: 1.0, vectors: elements.vectors(), mean_anomaly: 1.0 };
            let (position, velocity) = motion.position_and_velocity();
            assert!((length(position) - 1.0).abs() < 1e-14 && (length(velocity) - 1.0).abs() < 1e-14);
            assert!(dot(position, velocity).abs() < 1e-14);
        }
    }

    /// The limit of small eccentricities, which the vectors of a circular orbit do not know.
    #[test]
    fn a_circular_orbit_is_where_its_angles_say() {
        for (inclination, node, longitude_of_pericentre) in [(0.9, 6.2, 4.1), (0.0, 0.0, 2.0), (2.5, 1.0, 0.3)] {
            let at = |eccentricity: f64| {
                place(&Elements { eccentricity, inclination, node, longitude_of_pericentre }, 1.2, 1.3)
            };
            let ((position, velocity), (near, moving)) = (at(0.0), at(1e-13));
            assert!(length(plus(position, times(near, -1.0))) < 1e-12);
            assert!(length(plus(velocity, times(moving, -1.0))) < 1e-12);
        }
    }
}

//! The shape and the orientation of an orbit in space: its elements, and the vectors that stand for them.
//!
//! The vectors are the eccentricity vector `e`, which points to the pericentre, and the angular momentum vector `h`,
//! which is perpendicular to the orbit and has the length `sqrt(1 - e²)` (in units of `sqrt(mu a)`). Both are regular
//! for circular orbits and for orbits in the equator. The longitude of pericentre `node + argument of pericentre` is so
//! for orbits in the equator, where neither of its two parts is determined alone. All of this is singular where the
//! inclination is π alone.

use std::f64::consts::TAU;

use super::quantity::Quantity;
use super::vector::{Vector, cross, dot, length, plus, times};

/// Shape and orientation of an orbit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Elements {
    /// Eccentricity.
    pub eccentricity: f64,
    /// Inclination to the equator \[rad\].
    pub inclination: f64,
    /// Right ascension of the ascending node \[rad\].
    pub node: f64,
    /// Longitude of pericentre, node plus argument of pericentre \[rad\].
    pub longitude_of_pericentre: f64,
}

/// The eccentricity vector and the angular momentum vector of an orbit, in equatorial axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vectors {
    /// Eccentricity vector.
    pub e: Vector<f64>,
    /// Angular momentum vector, in units of `sqrt(mu a)`.
    pub h: Vector<f64>,
}

impl Elements {
    /// Unit vectors to the pericentre, which the angles say also for a circular orbit, and perpendicular to the orbit.
    pub fn axes(&self) -> (Vector<f64>, Vector<f64>) {
        let (to_node, across, normal) = frame(self.inclination, self.node);
        let (sin, cos) = (self.longitude_of_pericentre - self.node).sin_cos();
        (plus(times(to_node, cos), times(across, sin)), normal)
    }

    /// The vectors of an orbit with these elements.
    pub fn vectors(&self) -> Vectors {
        let (to_pericentre, normal) = self.axes();
        let eta = ((1.0 - self.eccentricity) * (1.0 + self.eccentricity)).sqrt();
        Vectors { e: times(to_pericentre, self.eccentricity), h: times(normal, eta) }
    }
}

impl Vectors {
    /// The elements of the orbit; angles are in `[0, 2π)`. The node of an orbit in the equator is 0.
    pub fn elements(&self) -> Elements {
        let Self { e, h } = *self;
        let [x, y, z] = h;
        let (first, second) = equinoctial_axes(h);
        Elements {
            eccentricity: length(e),
            inclination: x.hypot(y).atan2(z),
            node: if x == 0.0 && y == 0.0 { 0.0 } else { turn(x.atan2(-y)) },
            longitude_of_pericentre: turn(dot(e, second).atan2(dot(e, first))),
        }
    }
}

/// Unit vectors to the ascending node, across it in the orbit's plane in the direction of motion, and perpendicular to
/// the orbit.
fn frame(inclination: f64, node: f64) -> (Vector<f64>, Vector<f64>, Vector<f64>) {
    let (sin_node, cos_node) = node.sin_cos();
    let (sin, cos) = inclination.sin_cos();
    let to_node = [cos_node, sin_node, 0.0];
    let normal = [sin_node * sin, -cos_node * sin, cos];
    (to_node, cross(normal, to_node), normal)
}

/// Axes in the orbit's plane from which the longitude of pericentre counts: those of the equator, turned into the plane
/// about the line of nodes (the equinoctial axes; Broucke & Cefola, Celest. Mech. 5, 1972).
pub(super) fn equinoctial_axes<T: Quantity>(h: Vector<T>) -> (Vector<T>, Vector<T>) {
    let [x, y, z] = times(h, T::from(1.0) / dot(h, h).sqrt());
    let share = T::from(1.0) / (z + 1.0);
    let xy = -(x * y * share);
    ([-(x * x * share) + 1.0, xy, -x], [xy, -(y * y * share) + 1.0, -y])
}

/// An angle in `[0, 2π)`.
pub(super) fn turn(angle: f64) -> f64 {
    let angle = angle.rem_euclid(TAU);
    if angle < TAU { angle } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_vectors_of_an_orbit_give_its_elements_back() {
        for (eccentricity, inclination) in [(0.1, 0.3), (0.7, 1.5), (1e-6, 1e-6), (0.3, 3.0)] {
            for (node, longitude_of_pericentre) in [(0.2, 5.0), (4.0, 1.0)] {
                let given = Elements { eccentricity, inclination, node, longitude_of_pericentre };
                let found = given.vectors().elements();
                assert!((found.eccentricity - eccentricity).abs() < 1e-15);
                assert!((found.inclination - inclination).abs() < 1e-15);
                assert!((found.node - node).abs() < 1e-9);
                assert!((found.longitude_of_pericentre - longitude_of_pericentre).abs() < 1e-9, "{found:?}");
            }
        }
    }

    #[test]
    fn an_orbit_in_the_equator_has_a_longitude_of_pericentre_whatever_its_node() {
        let given = |node| Elements { eccentricity: 0.2, inclination: 0.0, node, longitude_of_pericentre: 1.25 };
        for node in [0.0, 1.0, 4.0] {
            let vectors = given(node).vectors();
            let expected = [0.2 * 1.25f64.cos(), 0.2 * 1.25f64.sin(), 0.0];
            assert!(vectors.e.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-16), "{vectors:?}");
            assert!((vectors.elements().longitude_of_pericentre - 1.25).abs() < 1e-15);
        }
    }

    #[test]
    fn the_vectors_are_perpendicular_and_the_sum_of_their_squares_is_one() {
        let given = Elements { eccentricity: 0.6, inclination: 1.1, node: 2.0, longitude_of_pericentre: 4.5 };
        let Vectors { e, h } = given.vectors();
        assert!(dot(e, h).abs() < 1e-16);
        assert!((dot(e, e) + dot(h, h) - 1.0).abs() < 1e-15);
    }
}

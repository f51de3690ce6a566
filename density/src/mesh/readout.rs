//! A carried triangle in the `(phi, e)` plane.
//!
//! Triangles are carried in `(x1, x2)`, which is regular at `e = 0`, and read out in `(phi, e)`, which is not. A
//! triangle that subtends a small angle at the origin becomes one triangle in `(phi, e)`, with straight edges there:
//! clouds are stretched along arcs of nearly constant `e`, which straight edges in `(phi, e)` follow and chords in
//! `(x1, x2)` cut. A triangle near or around the origin is halved in `(x1, x2)` until its parts are narrow or too small
//! to matter.

use std::f64::consts::PI;

use super::polygon::{Corner, Polygon, twice_area};
use crate::angle::nearest;
use crate::model::plane::State;

/// Triangles wider than this \[rad\] are halved.
const WIDE: f64 = 0.3;
/// Number of halvings after which a wide part, a thousandth of its triangle, counts as a point.
const DEEPEST: u32 = 10;

/// A node of a carried mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// `e sin(phi)`.
    pub x1: f64,
    /// `e cos(phi)`.
    pub x2: f64,
    /// Solar angle \[rad\].
    pub phi: f64,
    /// Eccentricity.
    pub e: f64,
    /// Density per unit of the invariant measure `e/s dphi de`, which a characteristic keeps.
    pub invariant_density: f64,
    /// Density per unit `phi`-`e` area \[1/rad\].
    pub density: f64,
}

impl Node {
    /// From the state and the invariant density.
    pub fn new(x1: f64, x2: f64, invariant_density: f64) -> Self {
        let e = State { x1, x2 }.eccentricity();
        Self { x1, x2, phi: x1.atan2(x2), e, invariant_density, density: invariant_density * e / s_of(e) }
    }

    fn midpoint(&self, other: &Self) -> Self {
        Self::new(
            self.x1.midpoint(other.x1),
            self.x2.midpoint(other.x2),
            self.invariant_density.midpoint(other.invariant_density),
        )
    }
}

/// `sqrt(1 - e²)`; interpolation between lattice points may overshoot the disc `e < 1` where it resolves nothing.
fn s_of(e: f64) -> f64 {
    (1.0 - e * e).max(1e-12).sqrt()
}

/// A part of a carried triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Part {
    /// A triangle in `(phi, e)`, with densities per unit area there. Its angles lie near each other, on any branch.
    Triangle([Corner; 3]),
    /// A part too small and too near the origin to be distinguished from a point, with its integral of the density.
    Point {
        /// Solar angle \[rad\].
        phi: f64,
        /// Eccentricity.
        e: f64,
        /// Area times density.
        integral: f64,
    },
}

impl Part {
    /// Integral of the density over the part, regardless of its sense of rotation.
    pub fn integral(&self) -> f64 {
        match self {
            Self::Triangle(corners) => Polygon::new(corners).integral().abs(),
            Self::Point { integral, .. } => *integral,
        }
    }
}

/// A triangle's corners in `(phi, e)`, with the angles on the branch nearest to the first; `None` if the triangle is
/// wide.
pub fn polar(triangle: &[Node; 3]) -> Option<[Corner; 3]> {
    let first = triangle[0].phi;
    // Most triangles lie off the cut of the circle.
    let near = |phi: f64| if (phi - first).abs() <= PI { phi } else { nearest(phi, first) };
    let corners = triangle.map(|node| [near(node.phi), node.e, node.density]);
    let (low, high) = corners.iter().fold((first, first), |(low, high), c| (low.min(c[0]), high.max(c[0])));
    (high - low < WIDE).then_some(corners)
}

fn twice_area_of_states([a, b, c]: &[Node; 3]) -> f64 {
    twice_area(&[a, b, c].map(|node| [node.x1, node.x2, 0.0]))
}

/// Calls `visit` with each part of a carried triangle.
pub fn for_each_part(triangle: &[Node; 3], visit: &mut impl FnMut(&Part)) {
    match polar(triangle) {
        Some(corners) => visit(&Part::Triangle(corners)),
        None => halve(triangle, 0, visit),
    }
}

fn halve(triangle: &[Node; 3], depth: u32, visit: &mut impl FnMut(&Part)) {
    if let Some(corners) = polar(triangle) {
        return visit(&Part::Triangle(corners));
    }
    if depth == DEEPEST {
        let [a, b, c] = triangle;
        let mean = |f: fn(&Node) -> f64| (f(a) + f(b) + f(c)) / 3.0;
        let middle = Node::new(mean(|n| n.x1), mean(|n| n.x2), mean(|n| n.invariant_density));
        let integral = 0.5 * twice_area_of_states(triangle).abs() * middle.invariant_density / s_of(middle.e);
        return visit(&Part::Point { phi: middle.phi, e: middle.e, integral });
    }
    let length = |k: usize| {
        let (from, to) = (&triangle[k], &triangle[(k + 1) % 3]);
        (to.x1 - from.x1).hypot(to.x2 - from.x2)
    };
    let longest = (0..3).max_by(|&i, &j| length(i).total_cmp(&length(j))).unwrap_or(0);
    let [a, b, c] = [0, 1, 2].map(|k| triangle[(longest + k) % 3]);
    let middle = a.midpoint(&b);
    halve(&[a, middle, c], depth + 1, visit);
    halve(&[middle, b, c], depth + 1, visit);
}

/// The invariant measure `∫ e/s dphi de` of a triangle, straight in `(phi, e)` or, if wide, in `(x1, x2)`; negative if
/// it is turned over. The midpoints of the edges integrate it to third order.
pub fn invariant_measure(triangle: &[Node; 3]) -> f64 {
    match polar(triangle) {
        Some(corners) => polar_measure(&corners),
        None => {
            let inverse_s = |a: usize, b: usize| 1.0 / s_of(triangle[a].midpoint(&triangle[b]).e);
            0.5 * twice_area_of_states(triangle) * (inverse_s(0, 1) + inverse_s(1, 2) + inverse_s(2, 0)) / 3.0
        }
    }
}

/// Like [`invariant_measure`], for a triangle in `(phi, e)`.
pub fn polar_measure(corners: &[Corner; 3]) -> f64 {
    let weight = |a: usize, b: usize| {
        let e = corners[a][1].midpoint(corners[b][1]);
        e / s_of(e)
    };
    0.5 * twice_area(corners) * (weight(0, 1) + weight(1, 2) + weight(2, 0)) / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(x1: f64, x2: f64) -> Node {
        Node::new(x1, x2, 1.0)
    }

    /// Integral of the invariant measure's density over the parts.
    fn total(triangle: &[Node; 3]) -> f64 {
        let mut total = 0.0;
        for_each_part(triangle, &mut |part| {
            total += part.integral();
        });
        total
    }

    #[test]
    fn a_triangle_around_the_origin_keeps_its_measure_in_parts() {
        let triangle = [node(-0.02, -0.01), node(0.03, -0.01), node(0.0, 0.025)];
        let exact = invariant_measure(&triangle);
        assert!((exact / (0.5 * 0.05 * 0.035) - 1.0).abs() < 1e-3);
        assert!((total(&triangle) / exact - 1.0).abs() < 0.02, "{} {exact}", total(&triangle));
    }

    #[test]
    fn a_narrow_triangle_is_one_part_whose_angles_are_not_torn_apart_at_pi() {
        let triangle = [node(0.01, -0.5), node(-0.01, -0.5), node(0.0, -0.52)];
        let mut parts = Vec::new();
        for_each_part(&triangle, &mut |part| parts.push(*part));
        let [Part::Triangle(corners)] = parts[..] else { panic!("{parts:?}") };
        assert!(corners.iter().all(|corner| (corner[0] - corners[0][0]).abs() < 0.05));
    }

    #[test]
    fn a_triangle_turned_over_has_negative_measure() {
        let [a, b, c] = [node(0.1, 0.3), node(0.12, 0.3), node(0.1, 0.33)];
        assert!(invariant_measure(&[a, b, c]) * invariant_measure(&[a, c, b]) < 0.0);
    }
}

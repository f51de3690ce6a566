//! Contours of the Hamiltonian in the `(phi, e)` plane, and its stationary points.
//!
//! On a contour `H = h` the solar angle follows from the eccentricity in closed form,
//!
//! ```text
//! cos(phi) = (h - s - (W/3)/s³) / (C e)      s = sqrt(1 - e²)
//! ```
//!
//! so contours are drawn in pieces between the eccentricities where the right side passes ±1. The points of a piece lie
//! close together where the curve turns.

use std::f64::consts::PI;

use density::dynamics::{Force, State};
use density::model::PlanarHamiltonian;

use crate::elements::Point;

/// Number of eccentricities at which pieces of a contour are looked for.
const NODES: usize = 480;
/// Number of points of a piece.
const POINTS: usize = 40;
/// Largest eccentricity drawn.
const HIGHEST: f64 = 0.995;

/// Radiation parameter below which the eccentricity counts as constant.
pub const STILL: f64 = 1e-9;

/// The Hamiltonian at `(phi, e)`.
pub fn at(force: Force, phi: f64, e: f64) -> f64 {
    force.hamiltonian(State::from_polar(phi, e))
}

/// The pieces of the contour `H = level` with `phi` in `[0, π]`; their mirror images in `phi` belong to the contour too.
pub fn contour(force: Force, level: f64) -> Vec<Vec<Point>> {
    if force.radiation < STILL {
        return level_circles(force, level);
    }
    let cosine = |e: f64| {
        let s = (1.0 - e * e).sqrt();
        (level - s - force.oblateness / (3.0 * s.powi(3))) / (force.radiation * e)
    };
    let is_on = |e: f64| cosine(e).abs() <= 1.0;
    let mut nodes: Vec<f64> = (0..=NODES).map(|i| 1e-6 + (HIGHEST - 1e-6) * i as f64 / NODES as f64).collect();
    // Contours turn sharply at a saddle, so a piece ends there.
    let stationary = stationary_points(force);
    let corners: Vec<f64> = stationary.iter().filter(|p| (p.level - level).abs() < 1e-9).map(|p| p.e).collect();
    nodes.retain(|e| corners.iter().all(|corner| (e - corner).abs() > 1e-5));
    nodes.extend(corners.iter().flat_map(|corner| [corner - 1e-6, *corner, corner + 1e-6]));
    nodes.sort_by(f64::total_cmp);
    let is_on = |e: f64| is_on(e) && !corners.contains(&e);
    let mut pieces = Vec::new();
    let mut begin = nodes.first().copied().filter(|e| is_on(*e));
    for pair in nodes.windows(2) {
        let &[low, high] = pair else { continue };
        match (is_on(low), is_on(high), begin) {
            (false, true, _) => begin = Some(border(is_on, low, high)),
            (true, false, Some(start)) => {
                pieces.push(start..border(is_on, high, low));
                begin = None;
            }
            _ => {}
        }
    }
    pieces.extend(begin.map(|start| start..HIGHEST));
    let points = |piece: std::ops::Range<f64>| {
        let point = |k: usize| {
            let e = 0.5 * (piece.start + piece.end)
                - 0.5 * (piece.end - piece.start) * (PI * k as f64 / POINTS as f64).cos();
            (cosine(e).clamp(-1.0, 1.0).acos(), e)
        };
        (0..=POINTS).map(point).collect()
    };
    pieces.into_iter().map(points).collect()
}

/// The last place on the way from `inside`, where `is_on` holds, to `outside` at which it still holds.
pub(crate) fn border(is_on: impl Fn(f64) -> bool, outside: f64, inside: f64) -> f64 {
    let (mut outside, mut inside) = (outside, inside);
    for _ in 0..48 {
        let middle = outside.midpoint(inside);
        if is_on(middle) { inside = middle } else { outside = middle }
    }
    inside
}

/// Without radiation pressure contours are circles of constant eccentricity.
fn level_circles(force: Force, level: f64) -> Vec<Vec<Point>> {
    let excess = |e: f64| at(force, 0.0, e) - level;
    let node = |i: usize| HIGHEST * i as f64 / NODES as f64;
    let crossings = (0..NODES).filter(|&i| excess(node(i)) * excess(node(i + 1)) <= 0.0);
    crossings.map(|i| 0.5 * (node(i) + node(i + 1))).map(|e| vec![(0.0, e), (PI, e)]).collect()
}

/// A stationary point of the flow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stationary {
    /// Solar angle: 0 or π \[rad\].
    pub phi: f64,
    /// Eccentricity.
    pub e: f64,
    /// Whether contours around it are closed (a centre); otherwise they cross in it (a saddle).
    pub is_centre: bool,
    /// Its Hamiltonian.
    pub level: f64,
}

/// Without radiation pressure: the eccentricity of the circle on which every point stands still, if there is one.
pub fn still_circle(force: Force) -> Option<f64> {
    let s = force.oblateness.sqrt().sqrt();
    let e = (1.0 - s * s).sqrt();
    (force.radiation < STILL && e > 0.0 && e < HIGHEST).then_some(e)
}

/// The isolated stationary points of the flow; without radiation pressure this is only `e = 0`.
pub fn stationary_points(force: Force) -> Vec<Stationary> {
    let is_single = |state: &State| force.radiation >= STILL || state.eccentricity() < 1e-6;
    let point = |state: State| {
        let curvature = |x1: f64, x2: f64| {
            let h = 1e-4;
            let moved = |sign: f64| {
                let moved = State { x1: state.x1 + sign * h * x1, x2: state.x2 + sign * h * x2 };
                force.hamiltonian(moved)
            };
            (moved(1.0) - 2.0 * moved(0.0) + moved(-1.0)) / (h * h)
        };
        Stationary {
            phi: state.solar_angle(),
            e: state.eccentricity(),
            // The Hamiltonian is even in x1, so its second derivatives do not mix.
            is_centre: curvature(1.0, 0.0) * curvature(0.0, 1.0) > 0.0,
            level: force.hamiltonian(state),
        }
    };
    let states = force.stationary_points().into_iter().filter(is_single);
    states.filter(|state| state.eccentricity() < HIGHEST).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAPER: Force = Force { radiation: 0.15, oblateness: 0.40921 };

    #[test]
    fn every_point_of_a_contour_has_its_level() {
        for level in [0.98, 1.05, 1.1364, 1.151, 1.3] {
            let pieces = contour(PAPER, level);
            assert!(!pieces.is_empty(), "{level}");
            for &(phi, e) in pieces.iter().flatten() {
                assert!((at(PAPER, phi, e) - level).abs() < 1e-9, "{level} {phi} {e}");
            }
        }
    }

    #[test]
    fn the_papers_portrait_has_two_centres_and_a_saddle() {
        let points = stationary_points(PAPER);
        assert_eq!(points.iter().map(|p| p.is_centre).collect::<Vec<_>>(), [true, true, false]);
        assert!((points[2].level - 1.150996).abs() < 1e-6, "{points:?}");
    }

    #[test]
    fn without_radiation_pressure_a_circle_stands_still_and_e_0_is_the_only_single_point() {
        let force = Force { radiation: 0.0, oblateness: 0.40921 };
        let points = stationary_points(force);
        assert!(points.iter().all(|p| p.e < 1e-6 && p.is_centre) && points.len() == 1, "{points:?}");
        assert!((still_circle(force).unwrap() - (1.0 - 0.40921f64.sqrt()).sqrt()).abs() < 1e-12);
        assert_eq!(still_circle(Force { radiation: 0.0, oblateness: 2.0 }), None);
    }

    #[test]
    fn without_radiation_pressure_contours_have_constant_eccentricity() {
        let force = Force { radiation: 0.0, oblateness: 0.0 };
        let pieces = contour(force, 0.8);
        assert!(pieces.iter().flatten().all(|&(_, e)| (e - 0.6).abs() < 2e-3), "{pieces:?}");
    }
}

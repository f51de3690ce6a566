//! The figures, one file a kind.

use std::ops::Range;

use density::grid::Axis as Bins;

use crate::axis::Axis;
use crate::backend::Stroke;
use crate::elements::{Element, Point};
use crate::palette::{Ink, Marker};
use crate::scene::Scene;
use crate::text::subscript;

pub mod accuracy;
pub mod cloud_evolution;
pub mod difference;
pub mod effort;
pub mod first_passage;
pub mod joint_density;
pub mod marginals;
pub mod moment_errors;
pub mod phase_portrait;

/// A full turn.
const TURN: f64 = std::f64::consts::TAU;

const CONTOUR: Stroke = Stroke { ink: Ink::Faint, width: 0.7, dashes: &[] };
const CRITICAL: Stroke = Stroke { ink: Ink::Series(1), width: 1.4, dashes: &[7.0, 4.0] };

fn phi_axis(range: Range<f64>, ticks: usize) -> Axis {
    Axis::linear("solar angle φ [rad]", range, ticks)
}

fn e_axis(range: Range<f64>, ticks: usize) -> Axis {
    Axis::linear("eccentricity e", range, ticks)
}

/// The line of the critical eccentricity and its name.
fn critical(scene: &Scene<'_>, phi: &Range<f64>) -> (Element, String) {
    let e = scene.problem.critical_e;
    (
        Element::curve(vec![(phi.start, e), (phi.end, e)], CRITICAL),
        format!("critical eccentricity {} = {e}", subscript("e", "cri")),
    )
}

/// A curve in `phi` with its mirror image, wherever it meets `range`.
fn mirrored(pieces: &[Vec<Point>], range: &Range<f64>, stroke: Stroke) -> Vec<Element> {
    let turns = ((range.start / TURN).floor() as i32 - 1)..=((range.end / TURN).ceil() as i32 + 1);
    let copies = turns.flat_map(|turn| [1.0, -1.0].map(|sign| (sign, f64::from(turn) * TURN)));
    let moved = |(sign, shift): (f64, f64)| {
        pieces.iter().map(move |piece| piece.iter().map(|&(phi, e)| (sign * phi + shift, e)).collect())
    };
    let is_seen = |points: &Vec<Point>| points.iter().any(|(phi, _)| range.contains(phi));
    copies.flat_map(moved).filter(is_seen).map(|points| Element::curve(points, stroke)).collect()
}

/// A density over bins as steps.
fn steps(bins: &Bins, values: &[f64]) -> Vec<Point> {
    values.iter().enumerate().flat_map(|(i, &v)| [(bins.edge(i), v), (bins.edge(i + 1), v)]).collect()
}

/// The marker of a snapshot in figures of several.
fn snapshot_marker(index: usize) -> (Marker, Stroke) {
    (Marker::of(index), Stroke { ink: Ink::Series(index), width: 0.9, dashes: &[] })
}

/// `t = 0.5 yr`.
fn at_time(t: f64) -> String {
    format!("t = {t} yr")
}

//! The figures, one file per kind.

use std::ops::Range;

use density::grid::Axis as Bins;

use plotters::style::text_anchor::{HPos, VPos};

use crate::axis::Axis;
use crate::backend::Area;
use crate::draw_error::DrawError;
use crate::elements::{Element, Point};
use crate::palette::{Ink, Marker, Stroke};
use crate::panel::{Panel, SMALL, text_style, units};
use crate::scene::Scene;
use crate::text::subscript;
use crate::words::{label, reentry};
use results::description::Variable;

pub mod accuracy;
pub mod cloud_evolution;
mod density_map;
pub mod difference;
pub mod effort;
pub mod first_passage;
pub mod joint_density;
pub mod marginals;
pub mod moment_errors;
pub mod phase_portrait;
pub mod probability_above;
mod probability_axis;
mod small_map;
mod time_bar;
mod zoom;

/// A full turn \[rad\].
const TURN: f64 = std::f64::consts::TAU;

const CONTOUR: Stroke = Stroke { ink: Ink::Faint, width: 0.7, dashes: &[] };
const CRITICAL: Stroke = Stroke { ink: Ink::Series(1), width: 1.4, dashes: &[7.0, 4.0] };

fn axis_of(variable: &Variable, range: Range<f64>, ticks: usize) -> Axis {
    Axis::linear(&label(variable), range, ticks)
}

/// The line of the critical value of the re-entry variable and its name, if one of the axes is of that variable.
fn critical(scene: &Scene<'_>, x: &Range<f64>, y: &Range<f64>) -> Option<(Element, String)> {
    let value = scene.description.critical;
    let line = match (scene.is_reentry(0), scene.is_reentry(1)) {
        (true, _) => vec![(value, y.start), (value, y.end)],
        (_, true) => vec![(x.start, value), (x.end, value)],
        _ => return None,
    };
    let (name, symbol) = reentry(scene.description);
    Some((Element::curve(line, CRITICAL), format!("critical {name} {} = {value}", subscript(symbol, "cri"))))
}

/// A curve in `phi` and its mirror image, on every turn on which they meet `range`.
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

/// Whether there are more snapshots than a key has room for; a bar then shows which colour is which time.
fn snapshots_of_many(count: usize) -> bool {
    count > 6
}

/// The marker of a snapshot in figures of `count`.
fn snapshot_marker(index: usize, count: usize) -> (Marker, Stroke) {
    (Marker::of(index), Stroke { ink: Ink::of_many(index, count), width: 0.9, dashes: &[] })
}

/// The representative of an angle near the middle of its cloud; on an axis of one turn, the representative that lies on
/// the axis.
fn on_axis(angle: f64, centre: f64, axis: &Range<f64>) -> f64 {
    let near = density::angle::nearest(angle, centre);
    if axis.contains(&near) {
        near
    } else {
        Some(density::angle::fold(angle, axis.start)).filter(|_| axis.end - axis.start < TURN + 1e-6).unwrap_or(near)
    }
}

/// Splits an area into room for a panel and room for its colour bar, `bar` pixels wide.
pub(crate) fn beside_bar<'b>(area: &Area<'b>, bar: f64) -> (Area<'b>, Area<'b>) {
    let (width, _) = area.dim_in_pixel();
    area.split_horizontally(width.saturating_sub(units(bar)) as i32)
}

/// Words in the middle of a panel in which nothing can be drawn.
fn write_absent(panel: &Panel<'_, '_>, words: &str) -> Result<(), DrawError> {
    let [left, top, right, bottom] = panel.frame();
    let style = text_style(SMALL, Ink::Faint, HPos::Center, VPos::Center);
    panel.write(words, panel.point(0.5 * (left + right), 0.5 * (top + bottom)), style)
}

/// `t = 0.5, 1 yr`.
fn at_times(times: &[f64]) -> String {
    format!("t = {} yr", times.iter().map(|&t| time_words(t)).collect::<Vec<_>>().join(", "))
}

/// The sentence of a caption about the densities that a case withholds; empty if there are none.
fn withheld_words(label: &str, times: &[f64]) -> String {
    if times.is_empty() {
        String::new()
    } else {
        format!(" {label} withholds its density at {}: not drawn.", at_times(times))
    }
}

/// `t = 0.5 yr`.
fn at_time(t: f64) -> String {
    format!("t = {} yr", time_words(t))
}

/// A time as it was given in the scenario: `1.2`, not the `1.2000000000000002` that a sum of steps gives.
fn time_words(t: f64) -> String {
    format!("{t:.11e}").parse().unwrap_or(t).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_written_as_they_were_meant() {
        let words = [0.0, 6.0 * 0.2, 1.0 / 3.0, 1000.0, 1e-6].map(time_words);
        assert_eq!(words, ["0", "1.2", "0.333333333333", "1000", "0.000001"]);
    }
}

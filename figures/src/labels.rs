//! Words beside clouds: each close to some part of its own cloud, clear of other words and as clear of other clouds as there
//! is room for.
//!
//! A cloud may be a ring or lie in parts, so what counts is where its points are, not the rectangle around them.

use std::collections::HashMap;

use plotters::style::text_anchor::{HPos, VPos};

use crate::backend::Stroke;
use crate::elements::{Element, Point};
use crate::figure::DrawError;
use crate::palette::Ink;
use crate::panel::{Panel, SMALL, text_style};
use crate::text::text_width;

/// A rectangle in pixels: left, top, right, bottom.
type Box4 = [f64; 4];
/// A point in pixels.
type Pixel = (f64, f64);

/// Side of the squares in which clouds are noted \[px\].
const CELL: f64 = 4.0;
const HEIGHT: f64 = 1.3 * SMALL;
/// Distances from a cloud at which places are tried \[px\].
const DISTANCES: [f64; 5] = [3.0, 8.0, 14.0, 24.0, 36.0];
/// From this distance on a line leads from the words to their cloud \[px\].
const FAR: f64 = 7.0;
/// Parts of a cloud beside which places are tried, at most.
const ANCHORS: usize = 60;

/// Words that are to stand beside a cloud.
#[derive(Debug, Clone)]
pub struct Label {
    /// The words; none for a cloud that others are to keep clear of.
    pub words: String,
    /// Points of the cloud, many where it is dense.
    pub points: Vec<Point>,
    /// Colour of the words.
    pub ink: Ink,
}

/// Where clouds are: which of them have points in a square.
type Cells = HashMap<(i32, i32), Vec<usize>>;

fn cell((x, y): Pixel) -> (i32, i32) {
    ((x / CELL).floor() as i32, (y / CELL).floor() as i32)
}

fn meet(a: &Box4, b: &Box4) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// Distance of a point from a box.
fn distance(b: &Box4, (x, y): Pixel) -> f64 {
    (b[0] - x).max(x - b[2]).max(0.0).hypot((b[1] - y).max(y - b[3]).max(0.0))
}

/// Writes the labels. One for which there is no place that is clear of the others is left out.
pub fn write(panel: &Panel<'_, '_>, labels: &[Label]) -> Result<(), DrawError> {
    let frame = panel.frame();
    let clouds: Vec<Vec<Pixel>> = labels.iter().map(|label| spread(panel, &label.points)).collect();
    let mut cells = Cells::new();
    for (owner, points) in clouds.iter().enumerate() {
        for &point in points {
            cells.entry(cell(point)).or_default().push(owner);
        }
    }
    let mut written: Vec<Box4> = Vec::new();
    for (owner, (label, cloud)) in labels.iter().zip(&clouds).enumerate().filter(|(_, (l, _))| !l.words.is_empty()) {
        let width = text_width(&label.words, SMALL) + 4.0;
        let is_free = |b: &Box4| {
            let inside =
                b[0] > frame[0] + 1.0 && b[2] < frame[2] - 1.0 && b[1] > frame[1] + 1.0 && b[3] < frame[3] - 1.0;
            inside && !written.iter().any(|other| meet(b, other))
        };
        let mut best: Option<(f64, Pixel, Box4)> = None;
        for (anchor, place, away) in places(cloud, width) {
            if best.is_some_and(|(least, ..)| least <= away) {
                // All that follow are as far away.
                break;
            }
            if is_free(&place) {
                let cost = cost(&place, away, owner, &cells);
                best = best.filter(|(least, ..)| *least <= cost).or(Some((cost, anchor, place)));
            }
        }
        let Some((_, anchor, place)) = best else { continue };
        let leader = [anchor, (anchor.0.clamp(place[0], place[2]), anchor.1.clamp(place[1], place[3]))];
        let mut elements = vec![block(panel, &place)];
        if distance(&place, anchor) > FAR {
            let stroke = Stroke { ink: label.ink, width: 0.8, dashes: &[] };
            elements.push(Element::curve(leader.map(|(x, y)| panel.point(x, y)).to_vec(), stroke));
        }
        panel.draw_over(&elements)?;
        let style = text_style(SMALL, label.ink, HPos::Left, VPos::Center);
        panel.write(&label.words, panel.point(place[0] + 2.0, 0.5 * (place[1] + place[3])), style)?;
        written.push(place);
    }
    Ok(())
}

fn block(panel: &Panel<'_, '_>, place: &Box4) -> Element {
    Element::block(panel.point(place[0], place[1]), panel.point(place[2], place[3]), Ink::Paper, 0.75)
}

/// The points of a cloud in pixels, one a square.
fn spread(panel: &Panel<'_, '_>, points: &[Point]) -> Vec<Pixel> {
    let mut known = std::collections::HashSet::new();
    let pixels = points.iter().map(|point| panel.pixels(*point));
    pixels.filter(|pixel| known.insert(cell(*pixel))).collect()
}

/// Places around the parts of a cloud, near ones first: the part, the place, and how far the place is from it.
fn places(cloud: &[Pixel], width: f64) -> impl Iterator<Item = (Pixel, Box4, f64)> + '_ {
    let stride = cloud.len() / ANCHORS + 1;
    let around = move |(x, y): Pixel, away: f64| {
        let slant = 0.7 * away;
        let corners = [
            (x - 0.5 * width, y - away - HEIGHT),
            (x - 0.5 * width, y + away),
            (x + away, y - 0.5 * HEIGHT),
            (x - away - width, y - 0.5 * HEIGHT),
            (x + slant, y - slant - HEIGHT),
            (x - slant - width, y - slant - HEIGHT),
            (x + slant, y + slant),
            (x - slant - width, y + slant),
        ];
        corners.map(|(left, top)| ((x, y), [left, top, left + width, top + HEIGHT], away))
    };
    DISTANCES.into_iter().flat_map(move |away| cloud.iter().step_by(stride).flat_map(move |&part| around(part, away)))
}

/// How bad a place is: what it covers, how far it is from its cloud, and whether another cloud is as close.
fn cost(place: &Box4, away: f64, owner: usize, cells: &Cells) -> f64 {
    const AROUND: f64 = 10.0;
    let (low, high) = (cell((place[0] - AROUND, place[1] - AROUND)), cell((place[2] + AROUND, place[3] + AROUND)));
    let (mut covered, mut strangers) = (0, 0);
    for x in low.0..=high.0 {
        for y in low.1..=high.1 {
            let Some(owners) = cells.get(&(x, y)) else { continue };
            let middle = ((f64::from(x) + 0.5) * CELL, (f64::from(y) + 0.5) * CELL);
            let reach = distance(place, middle);
            covered += usize::from(reach < 0.5 * CELL);
            let is_strange = reach < AROUND.min(away + CELL) && owners.iter().any(|other| *other != owner);
            strangers += usize::from(is_strange);
        }
    }
    4.0 * covered as f64 + 1.5 * f64::from(strangers as u32) + away
}

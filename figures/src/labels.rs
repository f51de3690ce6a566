//! Words beside clouds, clear of other words and of other clouds.
//!
//! Words stand at their own cloud, or a line in the cloud's colour leads from them to it. A cloud may be a ring or
//! consist of several parts, so the places of its points count, not the rectangle around them. If there are too many
//! clouds for words beside each, only the first, the last and as many as fit evenly between them have words.

use std::collections::{HashMap, HashSet, VecDeque};

use plotters::style::text_anchor::{HPos, VPos};

use crate::draw_error::DrawError;
use crate::elements::{Element, Point};
use crate::palette::{Ink, Marker, Stroke};
use crate::panel::{Panel, SMALL, text_style};
use crate::text::text_width;

/// A rectangle in pixels: left, top, right, bottom.
type Box4 = [f64; 4];
/// A point in pixels.
type Pixel = (f64, f64);

/// Side of the squares in which the places of clouds are recorded \[px\].
const CELL: f64 = 4.0;
const HEIGHT: f64 = 1.3 * SMALL;
/// Distances from a cloud at which places are tried \[px\].
const DISTANCES: [f64; 7] = [3.0, 8.0, 14.0, 24.0, 36.0, 52.0, 72.0];
/// Distance beyond which a line leads from the words to their cloud \[px\].
const FAR: f64 = 7.0;
/// Distance from the words within which another cloud might be taken for the one that they name \[px\].
const AROUND: f64 = 10.0;
/// Largest number of parts of a cloud beside which places are tried.
const ANCHORS: usize = 60;
/// Largest number of labels written: more would hide the clouds that they name.
const MOST: usize = 16;

/// Words to be placed beside a cloud.
#[derive(Debug, Clone)]
pub struct Label {
    /// The words; empty for a cloud that other words must keep clear of.
    pub words: String,
    /// Points of the cloud; there are many where it is dense.
    pub points: Vec<Point>,
    /// Colour of the words and of the line that leads to the cloud.
    pub ink: Ink,
}

/// A place for words.
#[derive(Debug, Clone, Copy)]
struct Spot {
    /// The part of the cloud beside which they stand.
    anchor: Pixel,
    place: Box4,
    /// Distance of the place from the part \[px\].
    away: f64,
}

impl Spot {
    /// The line from the cloud to the words; `None` if they are close.
    fn leader(&self) -> Option<[Pixel; 2]> {
        let (x, y) = self.anchor;
        let end = (x.clamp(self.place[0], self.place[2]), y.clamp(self.place[1], self.place[3]));
        (self.away > FAR).then_some([self.anchor, end])
    }
}

/// Where the clouds are and which words have been written.
struct Map {
    frame: Box4,
    /// The clouds that have points in each square.
    cells: HashMap<(i32, i32), Vec<usize>>,
    written: Vec<Spot>,
}

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

/// Points along a line, at distances of at most half a square.
fn along([(x0, y0), (x1, y1)]: [Pixel; 2]) -> impl Iterator<Item = Pixel> {
    let steps = ((x1 - x0).hypot(y1 - y0) / (0.5 * CELL)).ceil().max(1.0) as usize;
    let at = move |k: usize| k as f64 / steps as f64;
    (0..=steps).map(move |k| (x0 + at(k) * (x1 - x0), y0 + at(k) * (y1 - y0)))
}

/// Whether two lines cross.
fn cross(a: [Pixel; 2], b: [Pixel; 2]) -> bool {
    let side = |[p, q]: [Pixel; 2], r: Pixel| (q.0 - p.0) * (r.1 - p.1) - (q.1 - p.1) * (r.0 - p.0);
    side(a, b[0]) * side(a, b[1]) < 0.0 && side(b, a[0]) * side(b, a[1]) < 0.0
}

/// Writes the labels. Labels that would cover another cloud, or whose cloud overlaps with others everywhere, are left
/// out, except for the first and the last.
pub fn write(panel: &Panel<'_, '_>, labels: &[Label]) -> Result<(), DrawError> {
    let clouds: Vec<Vec<Pixel>> = labels.iter().map(|label| spread(panel, &label.points)).collect();
    let mut map = Map::new(panel.frame(), &clouds);
    let named: Vec<usize> =
        (0..labels.len()).filter(|&k| !labels[k].words.is_empty() && !clouds[k].is_empty()).collect();
    for (turn, owner) in evenly(named.len()).into_iter().map(|k| named[k]).enumerate() {
        let label = &labels[owner];
        let width = text_width(&label.words, SMALL) + 4.0;
        let may_cover = turn < 2;
        if let Some(spot) = map.best(owner, &clouds[owner], width, may_cover).filter(|_| map.written.len() < MOST) {
            draw(panel, label, &spot)?;
            map.written.push(spot);
        }
    }
    Ok(())
}

/// `0..count` in an order of which every beginning is spread evenly: the ends, then the middle, then the middles of the
/// halves.
fn evenly(count: usize) -> Vec<usize> {
    let last = count.saturating_sub(1);
    let mut order: Vec<usize> = (0..count).filter(|&k| k == 0 || k == last).collect();
    let mut gaps = VecDeque::from([(0, last)]);
    while let Some((low, high)) = gaps.pop_front() {
        if high - low > 1 {
            let middle = low.midpoint(high);
            order.push(middle);
            gaps.extend([(low, middle), (middle, high)]);
        }
    }
    order
}

/// Draws the words, and the line that leads to their cloud and ends there in a dot.
fn draw(panel: &Panel<'_, '_>, label: &Label, spot: &Spot) -> Result<(), DrawError> {
    let place = &spot.place;
    let at = |(x, y): Pixel| panel.point(x, y);
    let mut elements = vec![Element::block(at((place[0], place[1])), at((place[2], place[3])), Ink::Paper, 0.75)];
    if let Some(leader) = spot.leader() {
        let stroke = |ink: Ink| Stroke { ink, width: 0.8, dashes: &[] };
        let dot =
            |radius: f64, ink: Ink| Element::markers(vec![at(spot.anchor)], Marker::Circle, radius, stroke(ink), true);
        elements.push(Element::curve(leader.map(at).to_vec(), stroke(label.ink)));
        elements.extend([dot(2.6, Ink::Paper), dot(1.7, label.ink)]);
    }
    panel.draw_over(&elements)?;
    // The words are aligned to the side of their cloud, because their width is known only roughly.
    let (side, x) = match spot.anchor.0 {
        x if x <= place[0] => (HPos::Left, place[0] + 2.0),
        x if x >= place[2] => (HPos::Right, place[2] - 2.0),
        _ => (HPos::Center, 0.5 * (place[0] + place[2])),
    };
    panel.write(&label.words, at((x, 0.5 * (place[1] + place[3]))), text_style(SMALL, label.ink, side, VPos::Center))
}

/// The points of a cloud in pixels, one per square.
fn spread(panel: &Panel<'_, '_>, points: &[Point]) -> Vec<Pixel> {
    let mut known = HashSet::new();
    let pixels = points.iter().map(|point| panel.pixels(*point));
    pixels.filter(|pixel| known.insert(cell(*pixel))).collect()
}

/// Places around some parts of a cloud, the nearest first.
fn spots(parts: &[Pixel], width: f64) -> impl Iterator<Item = Spot> + '_ {
    let stride = parts.len() / ANCHORS + 1;
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
        let place = |(left, top): Pixel| [left, top, left + width, top + HEIGHT];
        corners.map(|corner| Spot { anchor: (x, y), place: place(corner), away })
    };
    DISTANCES.into_iter().flat_map(move |away| parts.iter().step_by(stride).flat_map(move |&part| around(part, away)))
}

impl Map {
    fn new(frame: Box4, clouds: &[Vec<Pixel>]) -> Self {
        let mut cells: HashMap<(i32, i32), Vec<usize>> = HashMap::new();
        for (owner, points) in clouds.iter().enumerate() {
            for &point in points {
                cells.entry(cell(point)).or_default().push(owner);
            }
        }
        Self { frame, cells, written: Vec::new() }
    }

    /// The best place for words beside a cloud, if there is one. Words that `may_cover` other clouds do so only if they
    /// must.
    fn best(&self, owner: usize, cloud: &[Pixel], width: f64, may_cover: bool) -> Option<Spot> {
        // Words beside a part where clouds meet could name any of them.
        let alone = |reach: i32| cloud.iter().copied().filter(|part| self.is_alone(*part, owner, reach)).collect();
        let tries: [Vec<Pixel>; 2] = [alone(1), alone(0)];
        let all = may_cover.then_some(cloud);
        let parts = tries.iter().map(Vec::as_slice).find(|parts| !parts.is_empty()).or(all)?;
        let mut best: Option<(f64, Spot)> = None;
        for spot in spots(parts, width) {
            if best.is_some_and(|(least, _)| least <= spot.away) {
                // All places that follow are at least as far away.
                break;
            }
            let cost = self.cost(&spot, owner, may_cover).filter(|_| self.is_free(&spot));
            if let Some(cost) = cost.filter(|cost| best.is_none_or(|(least, _)| *cost < least)) {
                best = Some((cost, spot));
            }
        }
        best.map(|(_, spot)| spot)
    }

    /// Whether there is no other cloud in the square of a part of this cloud, nor in the squares around it up to
    /// `reach` squares away.
    fn is_alone(&self, part: Pixel, owner: usize, reach: i32) -> bool {
        let (column, row) = cell(part);
        let mut around = (-reach..=reach).flat_map(|x| (-reach..=reach).map(move |y| (column + x, row + y)));
        around.all(|square| self.cells.get(&square).is_none_or(|owners| owners.iter().all(|other| *other == owner)))
    }

    /// Whether a place is in the frame, and neither it nor its leader meets the words and leaders already there.
    fn is_free(&self, spot: &Spot) -> bool {
        let (frame, place) = (&self.frame, &spot.place);
        let is_inside = place[0] > frame[0] + 1.0
            && place[2] < frame[2] - 1.0
            && place[1] > frame[1] + 1.0
            && place[3] < frame[3] - 1.0;
        let lies_on = |leader: [Pixel; 2], place: &Box4| along(leader).any(|point| distance(place, point) < 1.0);
        let meets = |other: &Spot| {
            let (own, others) = (spot.leader(), other.leader());
            meet(place, &other.place)
                || own.is_some_and(|own| lies_on(own, &other.place))
                || others.is_some_and(|leader| lies_on(leader, place))
                || own.zip(others).is_some_and(|(a, b)| cross(a, b))
        };
        is_inside && !self.written.iter().any(meets)
    }

    /// The cost of a place: what it covers, how far it is from its cloud, whether another cloud is as close, and what
    /// its leader crosses. `None` if it covers another cloud and may not.
    fn cost(&self, spot: &Spot, owner: usize, may_cover: bool) -> Option<f64> {
        let Spot { place, away, .. } = spot;
        let (low, high) = (cell((place[0] - AROUND, place[1] - AROUND)), cell((place[2] + AROUND, place[3] + AROUND)));
        let (mut covered, mut strangers) = (0_u32, 0_u32);
        for square in (low.0..=high.0).flat_map(|x| (low.1..=high.1).map(move |y| (x, y))) {
            let Some(owners) = self.cells.get(&square) else { continue };
            let middle = ((f64::from(square.0) + 0.5) * CELL, (f64::from(square.1) + 0.5) * CELL);
            let (reach, is_strange) = (distance(place, middle), owners.iter().any(|other| *other != owner));
            if is_strange && reach < 0.5 * CELL && !may_cover {
                return None;
            }
            covered += u32::from(reach < 0.5 * CELL);
            strangers += u32::from(is_strange && reach < AROUND.min(away + CELL));
        }
        let leader = spot.leader().into_iter().flat_map(along);
        let crossed = leader.filter(|point| !self.is_alone(*point, owner, 0)).count();
        Some(4.0 * f64::from(covered) + 1.5 * f64::from(strangers) + 0.5 * crossed as f64 + away)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_come_first_and_every_index_once() {
        assert_eq!(evenly(0), [] as [usize; 0]);
        assert_eq!(evenly(1), [0]);
        assert_eq!(evenly(2), [0, 1]);
        assert_eq!(evenly(5), [0, 4, 2, 1, 3]);
        let mut all = evenly(64);
        assert_eq!(all[..2], [0, 63]);
        all.sort_unstable();
        assert_eq!(all, (0..64).collect::<Vec<_>>());
    }
}

//! Where an ellipse enters and leaves the Earth's shadow.
//!
//! Places on the ellipse are given by the eccentric longitude `F`, the eccentric anomaly counted from the first
//! equinoctial axis, which is regular for circular orbits (Broucke & Cefola, Celest. Mech. 5, 1972). The square of the
//! distance from the shadow's axis is a trigonometric polynomial of degree 2 in `F`, so that the cylinder is met at
//! most four times. It is monotone between its extrema, of which there are two or four; between them, and the two
//! places where the satellite is at right angles to the Sun, there is one edge at most.
//!
//! An orbit whose pericentre is above the ground is in the shadow once in a revolution or never; one that passes
//! through the Earth may be in it up to three times.

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

use crate::model::elements::equinoctial_axes;
use crate::model::vector::{Vector, dot};

/// Most stretches of a revolution that are dark.
pub const MOST: usize = 4;
/// Number of places at which the slope of the distance is looked at, to find the extrema of the distance.
const PLACES: usize = 32;
/// Most extrema of the distance.
const MOST_EXTREMA: usize = 4;
/// Most places between which the distance is monotone.
const MOST_NODES: usize = MOST_EXTREMA + 2;

/// Sines and cosines of these places.
static CIRCLE: LazyLock<[(f64, f64); PLACES]> =
    LazyLock::new(|| std::array::from_fn(|k| libm::sincos(TAU * k as f64 / PLACES as f64)));

/// An ellipse as seen from the Sun. Lengths are in semi-major axes.
#[derive(Debug, Clone, Copy)]
pub struct Ellipse {
    /// Coordinates in the plane of the orbit: constant, and coefficients of `cos F` and `sin F`.
    x: [f64; 3],
    y: [f64; 3],
    /// Distance towards the Sun, in the same form.
    toward: [f64; 3],
    /// Radius of the Earth.
    radius: f64,
}

/// Why light begins or ends at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The cylinder is crossed.
    Cylinder,
    /// The satellite, nearer to the Earth's centre than one radius, is at right angles to the Sun.
    Face,
}

/// A place where light begins or ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// The eccentric longitude \[rad\].
    pub longitude: f64,
    /// Why.
    pub kind: Kind,
}

/// The dark stretches of a revolution, each from its beginning to its end, which is at a larger longitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dark {
    stretches: [(Edge, Edge); MOST],
    count: usize,
}

impl Dark {
    /// The stretches.
    pub fn stretches(&self) -> &[(Edge, Edge)] {
        &self.stretches[..self.count]
    }
}

fn at([constant, by_cos, by_sin]: [f64; 3], (sin, cos): (f64, f64)) -> f64 {
    by_sin.mul_add(sin, by_cos.mul_add(cos, constant))
}

fn slope([_, by_cos, by_sin]: [f64; 3], (sin, cos): (f64, f64)) -> f64 {
    by_sin.mul_add(cos, -by_cos * sin)
}

/// Sine and cosine, the same on every machine.
fn sin_cos(angle: f64) -> (f64, f64) {
    libm::sincos(angle)
}

impl Ellipse {
    /// The ellipse of an eccentricity vector and an angular momentum vector, with the direction to the Sun and the
    /// radius of the Earth in semi-major axes.
    pub fn new(e: Vector<f64>, h: Vector<f64>, to_sun: Vector<f64>, radius: f64) -> Self {
        let (first, second) = equinoctial_axes(h);
        let (k, l) = (dot(e, first), dot(e, second));
        let (sun_x, sun_y) = (dot(to_sun, first), dot(to_sun, second));
        let share = 1.0 / (1.0 + dot(h, h).sqrt());
        let x = [-k, 1.0 - share * l * l, share * k * l];
        let y = [-l, share * k * l, 1.0 - share * k * k];
        let toward = std::array::from_fn(|n| sun_x * x[n] + sun_y * y[n]);
        Self { x, y, toward, radius }
    }

    /// Square of the distance from the shadow's axis, less that of the Earth's radius.
    fn beyond(&self, place: (f64, f64)) -> f64 {
        let [x, y, toward] = [self.x, self.y, self.toward].map(|x| at(x, place));
        x * x + y * y - toward * toward - self.radius * self.radius
    }

    /// Half the slope of the square of the distance from the axis, and half its second derivative.
    fn slopes(&self, place: (f64, f64)) -> (f64, f64) {
        let (mut first, mut second) = (0.0, 0.0);
        for (coordinate, sign) in [(self.x, 1.0), (self.y, 1.0), (self.toward, -1.0)] {
            let (value, slope) = (at(coordinate, place), slope(coordinate, place));
            first += sign * value * slope;
            second += sign * (slope * slope - value * (value - coordinate[0]));
        }
        (first, second)
    }

    /// The extrema of the distance from the axis on the night side, in ascending order, and perhaps some next to it.
    fn extrema(&self) -> ([f64; MOST_EXTREMA], usize) {
        let longitude = |k: usize| TAU * k as f64 / PLACES as f64;
        let slopes = CIRCLE.map(|place| self.slopes(place).0);
        let (mut found, mut count) = ([0.0; MOST_EXTREMA], 0);
        for k in 0..PLACES {
            let next = slopes[(k + 1) % PLACES];
            let is_night = [k, (k + 1) % PLACES].iter().any(|&k| at(self.toward, CIRCLE[k]) < 0.0);
            if is_night && (slopes[k] < 0.0) != (next < 0.0) && count < MOST_EXTREMA {
                found[count] = zero(|f| self.slopes(sin_cos(f)), longitude(k), longitude(k + 1), slopes[k], next);
                count += 1;
            }
        }
        (found, count)
    }

    /// The two places at right angles to the Sun, in ascending order; none if the orbit is at right angles to the Sun
    /// as a whole.
    fn terminators(&self) -> Option<[f64; 2]> {
        let [constant, by_cos, by_sin] = self.toward;
        let size = by_cos.hypot(by_sin);
        // The Earth's centre is within the ellipse, so that there are two such places unless rounding is in the way.
        if size <= constant.abs() {
            return None;
        }
        let (middle, half) = (libm::atan2(by_sin, by_cos), libm::acos(-constant / size));
        let places = [middle - half, middle + half].map(|f| {
            let f = f.rem_euclid(TAU);
            if f < TAU { f } else { 0.0 }
        });
        Some(if places[0] < places[1] { places } else { [places[1], places[0]] })
    }

    /// The dark stretches.
    pub fn dark(&self) -> Dark {
        let none = Edge { longitude: 0.0, kind: Kind::Face };
        let mut dark = Dark { stretches: [(none, none); MOST], count: 0 };
        let Some(terminators) = self.terminators() else { return dark };
        let (extrema, count) = self.extrema();
        // Nodes in ascending order, with the terminators marked.
        let mut nodes = [(0.0, false); MOST_NODES];
        let all = extrema[..count].iter().map(|&f| (f, false)).chain(terminators.map(|f| (f, true)));
        let mut length = 0;
        for node in all {
            let mut place = length;
            while place > 0 && nodes[place - 1].0 > node.0 {
                nodes[place] = nodes[place - 1];
                place -= 1;
            }
            nodes[place] = node;
            length += 1;
        }
        // The revolution begins at a terminator, after which the night begins or ends.
        let start = nodes[..length].iter().position(|node| node.1).unwrap_or(0);
        let node = |k: usize| {
            let turns = (start + k) / length;
            let (longitude, is_terminator) = nodes[(start + k) % length];
            (longitude + TAU * turns as f64, is_terminator)
        };
        let mut open = None;
        for k in 0..length {
            let (from, to) = (node(k), node(k + 1));
            let is_night = at(self.toward, sin_cos(0.5 * (from.0 + to.0))) < 0.0;
            if !is_night {
                continue;
            }
            let ends = [from, to].map(|(longitude, _)| self.beyond(sin_cos(longitude)));
            if ends[0] < 0.0 && from.1 {
                open = Some(Edge { longitude: from.0, kind: Kind::Face });
            }
            if (ends[0] < 0.0) != (ends[1] < 0.0) {
                let both = |f: f64| {
                    let place = sin_cos(f);
                    (self.beyond(place), 2.0 * self.slopes(place).0)
                };
                let edge = Edge { longitude: zero(both, from.0, to.0, ends[0], ends[1]), kind: Kind::Cylinder };
                match open.take() {
                    None => open = Some(edge),
                    Some(begin) => dark.push(begin, edge),
                }
            }
            if let Some(begin) = open.take_if(|_| ends[1] < 0.0 && to.1) {
                dark.push(begin, Edge { longitude: to.0, kind: Kind::Face });
            }
        }
        dark
    }

    /// The extrema of the distance from the axis on the night side, by longitude and depth in Earth radii, which is
    /// below 0 in the shadow: the places at which a dark stretch of an orbit above the ground begins or ends to be.
    pub fn depths(&self) -> impl Iterator<Item = (f64, f64)> {
        let (extrema, count) = self.extrema();
        let own = *self;
        let night = extrema.into_iter().take(count).filter(move |&f| at(own.toward, sin_cos(f)) < 0.0);
        night.map(move |f| {
            let distance = (own.beyond(sin_cos(f)) / (own.radius * own.radius) + 1.0).max(0.0).sqrt();
            (f, distance - 1.0)
        })
    }
}

impl Dark {
    fn push(&mut self, begin: Edge, end: Edge) {
        if self.count < MOST {
            self.stretches[self.count] = (begin, end);
            self.count += 1;
        }
    }
}

/// The zero of a function, given with its slope, between two places at which it has these values of different signs:
/// Newton's method, and a halving where it would leave the interval.
fn zero(function: impl Fn(f64) -> (f64, f64), mut low: f64, mut high: f64, at_low: f64, at_high: f64) -> f64 {
    const MOST_STEPS: usize = 80;
    const ENOUGH: f64 = 2e-16;
    let mut place = low + (high - low) * at_low / (at_low - at_high);
    for _ in 0..MOST_STEPS {
        let (value, slope) = function(place);
        if (value < 0.0) == (at_low < 0.0) {
            low = place;
        } else {
            high = place;
        }
        let next = place - value / slope;
        let next = if next > low && next < high { next } else { low.midpoint(high) };
        let moved = (next - place).abs();
        place = next;
        // Newton's error after a step is the square of the step, nearly.
        if moved <= 1e-9 * (high - low).clamp(1e-6, 1.0) || moved <= ENOUGH * PI {
            break;
        }
    }
    place
}

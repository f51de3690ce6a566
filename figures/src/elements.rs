//! Elements that plotters lacks: dashed curves, markers, bands, and pictures stretched over a rectangle.
//!
//! plotters places each element in the coordinates of its panel, and [`SvgBackend`] draws it.

use plotters::element::{Drawable, PointCollection};
use plotters_backend::{BackendCoord, DrawingErrorKind};
use std::convert::Infallible;

use crate::backend::SvgBackend;
use crate::palette::{Ink, Marker, Pen, Stroke};

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

/// A point in the coordinates of a panel.
pub type Point = (f64, f64);

/// Something drawn at points of a panel.
#[derive(Debug, Clone)]
pub struct Element {
    points: Vec<Point>,
    shape: Shape,
}

#[derive(Debug, Clone)]
enum Shape {
    Curve(Stroke),
    Region(Ink, f64),
    Glyphs { outline: String, stroke: Stroke, filled: bool },
    Picture(String, Option<Ink>),
}

impl Element {
    /// A line through `points`.
    pub fn curve(points: Vec<Point>, stroke: Stroke) -> Self {
        Self { points, shape: Shape::Curve(stroke) }
    }

    /// The region between a lower and an upper curve, at `(x, lower, upper)`.
    pub fn band(limits: &[(f64, f64, f64)], ink: Ink) -> Self {
        let lower = limits.iter().map(|&(x, low, _)| (x, low));
        let upper = limits.iter().rev().map(|&(x, _, high)| (x, high));
        Self { points: lower.chain(upper).collect(), shape: Shape::Region(ink, 0.22) }
    }

    /// A filled rectangle.
    pub fn block((x0, y0): Point, (x1, y1): Point, ink: Ink, opacity: f64) -> Self {
        Self { points: vec![(x0, y0), (x1, y0), (x1, y1), (x0, y1)], shape: Shape::Region(ink, opacity) }
    }

    /// Markers `radius` px in half width.
    pub fn markers(points: Vec<Point>, marker: Marker, radius: f64, stroke: Stroke, filled: bool) -> Self {
        Self { points, shape: Shape::Glyphs { outline: marker.outline(radius), stroke, filled } }
    }

    /// The markers of a case.
    pub fn markers_of(points: Vec<Point>, pen: &Pen) -> Self {
        Self::markers(points, pen.marker, 3.5, pen.stroke, pen.filled)
    }

    /// A picture with this address between two corners.
    pub fn picture(corner: Point, opposite: Point, address: String) -> Self {
        Self { points: vec![corner, opposite], shape: Shape::Picture(address, None) }
    }

    /// Uses a picture as a stencil: `ink` is laid on where the picture is opaque. Other shapes stay as they are.
    pub fn inked(self, ink: Ink) -> Self {
        match self.shape {
            Shape::Picture(address, _) => Self { shape: Shape::Picture(address, Some(ink)), ..self },
            shape => Self { shape, ..self },
        }
    }
}

impl Element {
    /// The element with its points in backend units. plotters would move points outside a panel to its border, and so
    /// bend the curves that cross it.
    pub fn placed(&self, place: impl Fn(&Point) -> BackendCoord) -> Placed<'_> {
        Placed { points: self.points.iter().map(place).collect(), shape: &self.shape }
    }
}

/// An element at its place on the canvas.
#[derive(Debug)]
pub struct Placed<'e> {
    points: Vec<BackendCoord>,
    shape: &'e Shape,
}

impl<'a, C: 'a> PointCollection<'a, C> for &'a Placed<'_> {
    type Point = &'a C;
    type IntoIter = std::iter::Empty<&'a C>;

    fn point_iter(self) -> Self::IntoIter {
        std::iter::empty()
    }
}

impl Drawable<SvgBackend<'_>> for Placed<'_> {
    fn draw<I: Iterator<Item = BackendCoord>>(&self, _: I, backend: &mut SvgBackend<'_>, _: (u32, u32)) -> Drawn {
        match (self.shape, self.points.as_slice()) {
            (Shape::Curve(stroke), points) => backend.curve(points, stroke),
            (Shape::Region(ink, opacity), points) => backend.region(points, *ink, *opacity),
            (Shape::Glyphs { outline, stroke, filled }, points) => backend.glyphs(points, outline, stroke, *filled),
            (Shape::Picture(address, None), &[corner, opposite]) => backend.picture(corner, opposite, address),
            (Shape::Picture(address, Some(ink)), &[corner, opposite]) => {
                backend.stencil(corner, opposite, address, *ink);
            }
            (Shape::Picture(..), _) => {}
        }
        Ok(())
    }
}

/// Begins or ends a window outside which everything drawn in between is cut off.
#[derive(Debug)]
pub struct Window {
    corners: [Point; 2],
    opens: bool,
}

impl Window {
    /// The beginning of a window between two corners.
    pub fn begin(corner: Point, opposite: Point) -> Self {
        Self { corners: [corner, opposite], opens: true }
    }

    /// The end of a window.
    pub fn end() -> Self {
        Self { corners: [(0.0, 0.0); 2], opens: false }
    }
}

impl<'a> PointCollection<'a, Point> for &'a Window {
    type Point = &'a Point;
    type IntoIter = &'a [Point];

    fn point_iter(self) -> &'a [Point] {
        &self.corners
    }
}

impl Drawable<SvgBackend<'_>> for Window {
    fn draw<I: Iterator<Item = BackendCoord>>(
        &self,
        mut points: I,
        backend: &mut SvgBackend<'_>,
        _: (u32, u32),
    ) -> Drawn {
        match (self.opens, points.next(), points.next()) {
            (true, Some(corner), Some(opposite)) => backend.begin_window(corner, opposite),
            (true, ..) => {}
            (false, ..) => backend.end_window(),
        }
        Ok(())
    }
}

//! A plotters backend that writes SVG elements.
//!
//! plotters lays out areas, coordinates, ticks and labels. Its own SVG backend has no dashes, no pictures stretched to
//! a rectangle, and nothing by which a page could recolour a figure for a dark screen. Here every colour of the palette
//! is written as a plain attribute, so that any program shows the file, and as a class, so that a style sheet can
//! override it. Coordinates are in tenths of a pixel, because plotters rounds them to integers.

use std::convert::Infallible;

use maud::{Markup, Render, html};
use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, IntoDrawingArea};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind, FontTransform,
};

use crate::palette::{Ink, Stroke};
use crate::text::{SUBSCRIPT, drawn_width, text_width, with_subscripts};

/// Backend units per pixel.
pub const SCALE: u32 = 10;

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

/// Collects elements.
#[derive(Debug)]
pub struct SvgBackend<'a> {
    elements: &'a mut String,
    size: (u32, u32),
    /// Number of stencils so far.
    stencils: usize,
}

/// Placeholder for the name of the figure in the names of its elements; the figure puts its name there.
pub const FIGURE: char = '\u{E002}';

/// A whole figure or a part of it, to draw on.
pub type Area<'a> = DrawingArea<SvgBackend<'a>, Shift>;

/// A drawing area of `size` pixels that writes into `elements`.
pub fn canvas(elements: &mut String, size: (u32, u32)) -> Area<'_> {
    SvgBackend { elements, size: (size.0 * SCALE, size.1 * SCALE), stencils: 0 }.into_drawing_area()
}

/// A length given in backend units and written in pixels, with at most one decimal.
#[derive(Debug, Clone, Copy)]
struct Px(f64);

impl Render for Px {
    fn render_to(&self, out: &mut String) {
        let tenths = self.0.round() as i64;
        if tenths % 10 == 0 {
            (tenths / 10).render_to(out);
        } else {
            if tenths < 0 {
                out.push('-');
            }
            let tenths = tenths.abs();
            (tenths / 10).render_to(out);
            out.push('.');
            (tenths % 10).render_to(out);
        }
    }
}

fn px(units: i32) -> Px {
    Px(f64::from(units))
}

/// Path data through `points`.
fn path_data(points: &[BackendCoord], closed: bool) -> String {
    let mut data = String::with_capacity(points.len() * 12);
    for (i, &(x, y)) in points.iter().enumerate() {
        data.push(if i == 0 { 'M' } else { 'L' });
        px(x).render_to(&mut data);
        data.push(' ');
        px(y).render_to(&mut data);
    }
    if closed {
        data.push('Z');
    }
    data
}

impl SvgBackend<'_> {
    fn add(&mut self, element: &Markup) {
        self.elements.push_str(&element.0);
    }

    /// An open line through `points`.
    pub fn curve(&mut self, points: &[BackendCoord], stroke: &Stroke) {
        let dashes: Vec<String> = stroke.dashes.iter().map(ToString::to_string).collect();
        let dashes = (!dashes.is_empty()).then(|| dashes.join(" "));
        self.add(&html! {
            path class=(stroke.ink.stroke_class()) d=(path_data(points, false)) fill="none" stroke=(stroke.ink.hex())
                stroke-width=(stroke.width) stroke-linecap=[dashes.is_none().then_some("round")] stroke-dasharray=[dashes] stroke-linejoin="round" {}
        });
    }

    /// A filled polygon with an opacity.
    pub fn region(&mut self, points: &[BackendCoord], ink: Ink, opacity: f64) {
        self.add(&html! {
            path class=(ink.fill_class()) d=(path_data(points, true)) fill=(ink.hex()) fill-opacity=(opacity) {}
        });
    }

    /// The same small outline at many places. `glyph` is path data with relative commands, after a move to the place.
    pub fn glyphs(&mut self, points: &[BackendCoord], glyph: &str, stroke: &Stroke, filled: bool) {
        let mut data = String::with_capacity(points.len() * (12 + glyph.len()));
        for &(x, y) in points {
            data.push('M');
            px(x).render_to(&mut data);
            data.push(' ');
            px(y).render_to(&mut data);
            data.push_str(glyph);
        }
        let ink = stroke.ink;
        let filling = if filled { format!(" {}", ink.fill_class()) } else { String::new() };
        let classes = format!("{}{filling}", ink.stroke_class());
        let fill = if filled { ink.hex() } else { "none".into() };
        self.add(&html! {
            path class=(classes) d=(data) fill=(fill) stroke=(ink.hex()) stroke-width=(stroke.width) {}
        });
    }

    /// A picture stretched over a rectangle; its pixels have sharp borders.
    pub fn picture(&mut self, (x0, y0): BackendCoord, (x1, y1): BackendCoord, address: &str) {
        let (left, top) = (x0.min(x1), y0.min(y1));
        self.add(&html! {
            image x=(px(left)) y=(px(top)) width=(px((x1 - x0).abs())) height=(px((y1 - y0).abs()))
                preserveAspectRatio="none" style="image-rendering:pixelated" href=(address) {}
        });
    }

    /// A colour laid on a rectangle, as opaque as the picture at `address` is at each place.
    pub fn stencil(&mut self, (x0, y0): BackendCoord, (x1, y1): BackendCoord, address: &str, ink: Ink) {
        let name = format!("{FIGURE}-stencil-{}", self.stencils);
        self.stencils += 1;
        self.add(&html! {
            mask id=(name) maskContentUnits="objectBoundingBox" {
                image width="1" height="1" preserveAspectRatio="none" style="image-rendering:pixelated" href=(address) {}
            }
            rect class=(ink.fill_class()) x=(px(x0.min(x1))) y=(px(y0.min(y1))) width=(px((x1 - x0).abs()))
                height=(px((y1 - y0).abs())) fill=(ink.hex()) mask={ "url(#" (name) ")" } {}
        });
    }

    /// Everything that is drawn until [`SvgBackend::end_window`] is cut off outside this rectangle.
    pub fn begin_window(&mut self, (x0, y0): BackendCoord, (x1, y1): BackendCoord) {
        let (x, y) = (px(x0.min(x1)), px(y0.min(y1)));
        let (width, height) = (px((x1 - x0).abs()), px((y1 - y0).abs()));
        let view = html! { (x) " " (y) " " (width) " " (height) };
        let opened = html! { svg x=(x) y=(y) width=(width) height=(height) viewBox=(view.0) overflow="hidden" {} };
        self.elements.push_str(opened.0.trim_end_matches("</svg>"));
    }

    /// Ends the rectangle of [`SvgBackend::begin_window`].
    pub fn end_window(&mut self) {
        self.elements.push_str("</svg>");
    }
}

fn ink(color: BackendColor) -> Ink {
    Ink::from_rgb(color.rgb)
}

impl DrawingBackend for SvgBackend<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, point: BackendCoord, color: BackendColor) -> Drawn {
        let corner = (point.0 + SCALE as i32, point.1 + SCALE as i32);
        self.draw_rect(point, corner, &color, true)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Drawn {
        self.draw_path([from, to], style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        (x0, y0): BackendCoord,
        (x1, y1): BackendCoord,
        style: &S,
        fill: bool,
    ) -> Drawn {
        let corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)];
        if fill {
            self.fill_polygon(corners, style)
        } else {
            self.draw_path(corners.into_iter().chain([(x0, y0)]), style)
        }
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Drawn {
        let color = style.color();
        if color.alpha > 0.0 {
            let width = f64::from(style.stroke_width()) / f64::from(SCALE);
            self.curve(&path.into_iter().collect::<Vec<_>>(), &Stroke { ink: ink(color), width, dashes: &[] });
        }
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(&mut self, (x, y): BackendCoord, radius: u32, style: &S, fill: bool) -> Drawn {
        let around = |k: i32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 32.0).sin_cos();
            let radius = f64::from(radius);
            (x + (radius * cos).round() as i32, y + (radius * sin).round() as i32)
        };
        if fill { self.fill_polygon((0..32).map(around), style) } else { self.draw_path((0..=32).map(around), style) }
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, corners: I, style: &S) -> Drawn {
        let color = style.color();
        if color.alpha > 0.0 {
            self.region(&corners.into_iter().collect::<Vec<_>>(), ink(color), color.alpha);
        }
        Ok(())
    }

    fn draw_text<T: BackendTextStyle>(&mut self, text: &str, style: &T, (x, y): BackendCoord) -> Drawn {
        let size = style.size().round() / f64::from(SCALE);
        // Programs disagree on the centre of a text that has parts, so such a text is placed by its left end.
        let (anchor, shift) = match (style.anchor().h_pos, text.contains(SUBSCRIPT)) {
            (HPos::Left, _) => ("start", 0.0),
            (HPos::Center, false) => ("middle", 0.0),
            (HPos::Right, false) => ("end", 0.0),
            (HPos::Center, true) => ("start", -0.5 * drawn_width(text, size)),
            (HPos::Right, true) => ("start", -drawn_width(text, size)),
        };
        let left = Px(f64::from(x) + shift * f64::from(SCALE));
        // Distance from the named edge of the letters to their base line.
        let down = size
            * match style.anchor().v_pos {
                VPos::Top => 0.76,
                VPos::Center => 0.34,
                VPos::Bottom => -0.24,
            };
        let quarter_turns = match style.transform() {
            FontTransform::None => 0,
            FontTransform::Rotate90 => 1,
            FontTransform::Rotate180 => 2,
            FontTransform::Rotate270 => 3,
        };
        let turn = (quarter_turns != 0).then(|| html! { "rotate(" (90 * quarter_turns) " " (px(x)) " " (px(y)) ")" }.0);
        let ink = ink(style.color());
        let bold = style.style().as_str() == "bold";
        self.add(&html! {
            text class=(ink.fill_class()) x=(left) y=(Px(f64::from(y) + down * f64::from(SCALE))) fill=(ink.hex())
                font-size=(size) text-anchor=(anchor) font-weight=[bold.then_some("bold")] transform=[turn] {
                (with_subscripts(text, size))
            }
        });
        Ok(())
    }

    fn estimate_text_size<T: BackendTextStyle>(
        &self,
        text: &str,
        style: &T,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        Ok((text_width(text, style.size()) as u32, (1.2 * style.size()) as u32))
    }

    fn blit_bitmap(&mut self, _: BackendCoord, _: (u32, u32), _: &[u8]) -> Drawn {
        // Pictures are drawn with `picture`, at their own resolution.
        Ok(())
    }
}

//! The key to a figure, in rows above its panels, where it covers nothing.

use plotters::prelude::Text;
use plotters::style::text_anchor::{HPos, VPos};

use crate::backend::Area;
use crate::draw_error::DrawError;
use crate::elements::{Element, Point};
use crate::palette::{Ink, Marker, Pen, Stroke};
use crate::panel::{TEXT, text_style, units};
use crate::text::text_width;

/// The sample that an entry shows before its words.
#[derive(Debug, Clone, Copy)]
pub enum Sample {
    /// A line.
    Line(Stroke),
    /// A line with the case's marker.
    Case(Pen),
    /// A marker alone.
    Marker(Marker, Stroke, bool),
    /// A band.
    Band(Ink),
}

/// An entry: its sample and its words.
pub type Entry = (Sample, String);

const ROW: f64 = 20.0;
const SAMPLE: f64 = 30.0;
const GAP: f64 = 22.0;
const MARGIN: f64 = 10.0;

/// The place of each entry in `width` pixels: left end and row.
fn places(entries: &[Entry], width: f64) -> Vec<(f64, usize)> {
    let (mut x, mut row) = (MARGIN, 0);
    let place = |(_, words): &Entry| {
        let length = SAMPLE + 6.0 + text_width(words, TEXT);
        if x > MARGIN && x + length > width - MARGIN {
            (x, row) = (MARGIN, row + 1);
        }
        let place = (x, row);
        x += length + GAP;
        place
    };
    entries.iter().map(place).collect()
}

/// Height of the key in pixels.
pub fn height(entries: &[Entry], width: f64) -> f64 {
    places(entries, width).last().map_or(0.0, |&(_, row)| (row + 1) as f64 * ROW + 6.0)
}

/// Draws the key into `area`, which is `width` pixels wide.
pub fn draw(area: &Area<'_>, entries: &[Entry], width: f64) -> Result<(), DrawError> {
    let (left, top) = area.get_base_pixel();
    let at = |x: f64, y: f64| (f64::from(units(x)), f64::from(units(y)));
    let place = |&(x, y): &Point| (left + x as i32, top + y as i32);
    for ((sample, words), (x, row)) in entries.iter().zip(places(entries, width)) {
        let y = (row as f64 + 0.5) * ROW + 3.0;
        let line = |stroke: Stroke| Element::curve(vec![at(x, y), at(x + SAMPLE, y)], stroke);
        let middle = || vec![at(x + 0.5 * SAMPLE, y)];
        let elements = match sample {
            Sample::Line(stroke) => vec![line(*stroke)],
            Sample::Case(pen) => vec![line(pen.stroke), Element::markers_of(middle(), pen)],
            Sample::Marker(marker, stroke, filled) => {
                vec![Element::markers(middle(), *marker, 3.5, *stroke, *filled)]
            }
            Sample::Band(ink) => vec![Element::block(at(x, y - 5.0), at(x + SAMPLE, y + 5.0), *ink, 0.22)],
        };
        for element in &elements {
            area.draw(&element.placed(place))?;
        }
        let (text_x, text_y) = at(x + SAMPLE + 6.0, y);
        let style = text_style(TEXT, Ink::Text, HPos::Left, VPos::Center);
        area.draw(&Text::new(words.clone(), (text_x as i32, text_y as i32), style))?;
    }
    Ok(())
}

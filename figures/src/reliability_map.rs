//! A quantity over one or two numbers of a scenario: colours with contours, or a curve with its error.

use std::ops::Range;

use contour::ContourBuilder;
use plotters::style::text_anchor::{HPos, VPos};

use crate::axis::{Axis, Labels};
use crate::backend::Area;
use crate::colour_map::{Scale, picture, ramp};
use crate::draw_error::DrawError;
use crate::elements::{Element, Point};
use crate::figure::Figure;
use crate::palette::{Ink, Stroke};
use crate::panel::{Panel, SMALL, Surroundings, text_style, units};

const CONTOUR: Stroke = Stroke { ink: Ink::Paper, width: 1.4, dashes: &[] };
const CURVE: Stroke = Stroke { ink: Ink::Series(0), width: 1.8, dashes: &[] };
/// Width of the colour bar with its labels \[px\].
const BAR: f64 = 92.0;
/// The share of the scale that the least value has, so that it is not taken for one that is not there.
const FLOOR: f64 = 0.002;

/// An axis of a map: what it is, and the values at which points lie, evenly spaced and ascending.
#[derive(Debug, Clone)]
pub struct Along {
    /// The quantity, with its unit.
    pub label: String,
    /// The values.
    pub values: Vec<f64>,
}

/// What is drawn.
#[derive(Debug, Clone)]
pub struct Map {
    /// Name of the figure's file.
    pub name: String,
    /// The quantity, with its unit.
    pub label: String,
    /// Whether it is a probability.
    pub is_probability: bool,
    /// The horizontal axis.
    pub x: Along,
    /// The vertical axis, if there are two.
    pub y: Option<Along>,
    /// The quantity at each point with its error, the vertical axis running fastest; infinite where it is not reached.
    pub values: Vec<(f64, f64)>,
}

impl Map {
    /// Draws the map.
    ///
    /// # Errors
    /// `DrawError` if it cannot be drawn.
    pub fn draw(&self) -> Result<Figure, DrawError> {
        let title = format!("Map: {}", self.label);
        match &self.y {
            Some(y) => Figure::draw(&self.name, &title, &self.caption(), (760, 520), &[], |area| self.colours(area, y)),
            None => Figure::draw(&self.name, &title, &self.caption(), (760, 380), &[], |area| self.curve(area)),
        }
    }

    fn caption(&self) -> String {
        let largest = self.values.iter().map(|(_, error)| *error).filter(|error| error.is_finite()).fold(0.0, f64::max);
        let absent = self.values.iter().filter(|(value, _)| !value.is_finite()).count();
        let absent = match absent {
            0 => String::new(),
            count => format!(" {count} points without colour: not reached, or withheld."),
        };
        let what = if self.y.is_some() { "Colours and contours" } else { "The curve" };
        format!("{what}: {}. Largest error estimate of a point: {largest:.1e}.{absent}", self.label)
    }

    /// The range of the finite values.
    fn range(&self) -> Range<f64> {
        if self.is_probability {
            return 0.0..1.0;
        }
        let finite = || self.values.iter().map(|(value, _)| *value).filter(|value| value.is_finite());
        let (low, high) = finite().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        if low < high { low..high } else { low - 0.5..low + 0.5 }
    }

    /// The values at which contours are drawn.
    fn levels(&self) -> Vec<f64> {
        if self.is_probability {
            return vec![0.1, 0.5, 0.9, 0.99];
        }
        let range = self.range();
        let inside = |level: &f64| range.start < *level && *level < range.end;
        Axis::linear("", range.clone(), 7).ticks.into_iter().filter(inside).collect()
    }

    fn colours(&self, area: &Area<'_>, y: &Along) -> Result<(), DrawError> {
        let range = self.range();
        let (left, right) = super::drawings::beside_bar(area, BAR);
        let (across, up) = (cells(&self.x.values), cells(&y.values));
        let axes = (Axis::linear(&self.x.label, across.clone(), 7), Axis::linear(&y.label, up.clone(), 7));
        let panel = Panel::new(&left, &axes.0, &axes.1, Surroundings::default())?;
        let shown = |value: f64| FLOOR + (1.0 - FLOOR) * (value - range.start) / (range.end - range.start);
        let shares: Vec<f64> =
            self.values.iter().map(|(value, _)| if value.is_finite() { shown(*value) } else { f64::NAN }).collect();
        let address = picture(&shares, self.x.values.len(), y.values.len(), Scale::Linear(1.0))?;
        panel.draw(&[Element::picture((across.start, up.start), (across.end, up.end), address)])?;
        for level in self.levels() {
            let lines = self.contour(level, y)?;
            let longest = lines.iter().max_by_key(|line| line.len()).cloned();
            panel.draw(&lines.into_iter().map(|line| Element::curve(line, CONTOUR)).collect::<Vec<_>>())?;
            if let Some(line) = longest.filter(|line| line.len() > 2) {
                let style = text_style(SMALL, Ink::Paper, HPos::Left, VPos::Bottom);
                panel.write(&short(level), line[line.len() / 2], style)?;
            }
        }
        self.bar(&right, range)
    }

    fn bar(&self, area: &Area<'_>, range: Range<f64>) -> Result<(), DrawError> {
        let y = Axis::linear("", range.clone(), 6);
        let x = Axis { label: String::new(), range: 0.0..1.0, ticks: Vec::new(), labels: Labels::None };
        let area = area.margin(0, units(28.0), 0, 0);
        let panel =
            Panel::new(&area, &x, &y, Surroundings { is_bar: true, without_grid: true, ..Surroundings::default() })?;
        panel.draw(&[Element::picture((0.0, range.start), (1.0, range.end), ramp(Scale::Linear(1.0))?)])
    }

    /// The lines on which the quantity has this value.
    fn contour(&self, level: f64, y: &Along) -> Result<Vec<Vec<Point>>, DrawError> {
        let (width, height) = (self.x.values.len(), y.values.len());
        // Where the quantity is not reached it is larger than any.
        let finite = |value: f64| if value.is_finite() { value } else { f64::MAX.sqrt() };
        let rows: Vec<f64> = (0..height)
            .flat_map(|j| (0..width).map(move |i| i * height + j))
            .map(|k| finite(self.values[k].0))
            .collect();
        let failed = |error: contour::Error| DrawError(format!("contours cannot be drawn: {error}"));
        let found = ContourBuilder::new(width, height, true).lines(&rows, &[level]).map_err(failed)?;
        let at = |values: &[f64], cell: f64| {
            let position = (cell - 0.5).clamp(0.0, (values.len() - 1) as f64);
            let before = (position.floor() as usize).min(values.len().saturating_sub(2));
            values[before] + (position - before as f64) * (values[before + 1] - values[before])
        };
        // The library closes lines along the border, outside the middles of the cells.
        let is_inside = |x: f64, cells: usize| (0.5 - 1e-9..=cells as f64 - 0.5 + 1e-9).contains(&x);
        let mut lines: Vec<Vec<Point>> = Vec::new();
        for line in found.iter().flat_map(|line| line.geometry().0.iter()) {
            let parts = line.0.split(|point| !(is_inside(point.x, width) && is_inside(point.y, height)));
            for part in parts.filter(|part| part.len() > 1) {
                lines.push(part.iter().map(|point| (at(&self.x.values, point.x), at(&y.values, point.y))).collect());
            }
        }
        Ok(lines)
    }

    fn curve(&self, area: &Area<'_>) -> Result<(), DrawError> {
        let x = &self.x;
        let range = self.range();
        let ends = x.values.first().copied().unwrap_or(0.0)..x.values.last().copied().unwrap_or(1.0);
        let panel = Panel::new(
            area,
            &Axis::linear(&x.label, ends, 8),
            &Axis::linear(&self.label, range, 6),
            Surroundings::default(),
        )?;
        let points: Vec<(f64, (f64, f64))> = x.values.iter().copied().zip(self.values.iter().copied()).collect();
        for part in points.chunk_by(|a, b| a.1.0.is_finite() && b.1.0.is_finite()) {
            let line: Vec<Point> = part.iter().map(|(x, (value, _))| (*x, *value)).collect();
            if line.iter().all(|(_, value)| value.is_finite()) {
                let band: Vec<_> = part.iter().map(|(x, (v, error))| (*x, v - error, v + error)).collect();
                panel.draw(&[Element::band(&band, Ink::Series(0)), Element::curve(line, CURVE)])?;
            }
        }
        Ok(())
    }
}

/// From the border of the first cell to that of the last one.
fn cells(values: &[f64]) -> Range<f64> {
    let (first, last) = (values.first().copied().unwrap_or(0.0), values.last().copied().unwrap_or(1.0));
    let half = 0.5 * (last - first) / (values.len().max(2) - 1) as f64;
    first - half..last + half
}

fn short(level: f64) -> String {
    let text = format!("{level:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(height: usize) -> Map {
        let values = |count: usize, scale: f64| (0..count).map(|k| scale * k as f64).collect();
        let of = |i: usize, j: usize| 1.0 / (1.0 + (0.5 * (20.0 - i as f64 - j as f64)).exp());
        Map {
            name: "map".into(),
            label: "probability".into(),
            is_probability: true,
            x: Along { label: "x".into(), values: values(30, 0.1) },
            y: (height > 1).then(|| Along { label: "y".into(), values: values(height, 2.0) }),
            values: (0..30).flat_map(|i| (0..height).map(move |j| (of(i, j), 1e-4))).collect(),
        }
    }

    #[test]
    fn a_contour_lies_where_the_quantity_has_its_value() {
        let map = map(24);
        let lines = map.contour(0.5, map.y.as_ref().unwrap()).unwrap();
        let points: Vec<Point> = lines.concat();
        assert!(points.len() > 15);
        // On the line x/0.1 + y/2 = 20.
        assert!(points.iter().all(|(x, y)| (x / 0.1 + y / 2.0 - 20.0).abs() < 0.02), "{points:?}");
    }

    #[test]
    fn a_map_and_a_curve_are_drawn_also_where_nothing_is_reached() {
        let mut two = map(24);
        two.values[5].0 = f64::INFINITY;
        two.is_probability = false;
        let picture = two.draw().unwrap();
        assert!(picture.caption.contains("1 points without colour"), "{}", picture.caption);
        assert!(picture.to_file().contains("data:image/png"));
        let curve = map(1).draw().unwrap();
        assert!(curve.to_file().contains("<path") || curve.to_file().contains("polyline"));
        let mut nothing = map(24);
        nothing.is_probability = false;
        nothing.values.iter_mut().for_each(|value| value.0 = f64::NAN);
        assert!(nothing.draw().is_ok());
    }
}

//! Thin clouds, magnified about their peak, because their bins are hairlines at the size of a figure.

use std::ops::Range;

use plotters::style::text_anchor::{HPos, VPos};

use super::at_time;
use super::density_map::{Map, yardstick};
use crate::axis::Axis;
use crate::backend::Area;
use crate::colour_map::{LEAST, Scale, picture};
use crate::densities::Density;
use crate::draw_error::DrawError;
use crate::elements::{Element, Point};
use crate::palette::{Ink, Stroke};
use crate::panel::{Panel, SMALL, Surroundings, text_style, units};
use crate::scene::{Cloud, Method, Scene};
use crate::words::short_label;
use results::description::Variable;

/// A cloud is thin if less than this share of the bins in the rectangle around it is visible.
const THIN: f64 = 0.05;
/// A cloud is small if it takes less than this share of one of the axes.
const SMALLEST: f64 = 0.06;
/// Number of bins that are magnified along each axis.
const SIDE: usize = 14;
const FRAME: Stroke = Stroke { ink: Ink::Text, width: 0.8, dashes: &[] };
/// Number of insets in a row, and below the height of a row \[px\].
const COLUMNS: usize = 4;
const ROW: f64 = 138.0;
/// Largest number of insets in a figure.
const MOST: usize = 16;

/// Whether a density looks like a hairline on axes fitted to it.
pub fn is_thin(density: &Density) -> bool {
    let least = LEAST * density.peak();
    if density.is_withheld() || least <= 0.0 {
        return false;
    }
    let Cloud { x, y } = Cloud::of(density);
    let around = (x.end - x.start) / density.grid.x.width() * (y.end - y.start) / density.grid.y.width();
    let visible = density.joint.iter().filter(|p| **p >= least).count();
    (visible as f64) < THIN * around
}

/// Whether a density is only a spot or a stroke on these axes.
fn is_small(density: &Density, [x, y]: [&Range<f64>; 2]) -> bool {
    let cloud = Cloud::of(density);
    let share = |part: &Range<f64>, all: &Range<f64>| (part.end - part.start) / (all.end - all.start);
    !density.is_withheld() && share(&cloud.x, x).min(share(&cloud.y, y)) < SMALLEST
}

/// A rectangle of bins of a grid.
struct Window {
    x: Range<usize>,
    y: Range<usize>,
}

impl Window {
    /// The bins about the peak of a density.
    fn about_peak(density: &Density) -> Self {
        let grid = &density.grid;
        let peak = density.joint.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(k, _)| k);
        let about = |middle: usize, bins: usize| {
            let side = SIDE.min(bins);
            let first = middle.saturating_sub(side / 2).min(bins - side);
            first..first + side
        };
        Self { x: about(peak / grid.y.bins, grid.x.bins), y: about(peak % grid.y.bins, grid.y.bins) }
    }

    /// All bins.
    fn whole(density: &Density) -> Self {
        Self { x: 0..density.grid.x.bins, y: 0..density.grid.y.bins }
    }

    /// The corners of the window on the grid of a density.
    fn corners(&self, density: &Density) -> (Point, Point) {
        let grid = &density.grid;
        let corner = |i: usize, j: usize| (grid.x.edge(i), grid.y.edge(j));
        (corner(self.x.start, self.y.start), corner(self.x.end, self.y.end))
    }

    /// The picture of the values in the window.
    fn picture(&self, density: &Density, values: &[f64], scale: Scale) -> Result<String, DrawError> {
        let bins = density.grid.y.bins;
        let rows = self.x.clone().flat_map(|i| self.y.clone().map(move |j| i * bins + j));
        let part: Vec<f64> = rows.filter_map(|k| values.get(k).copied()).collect();
        picture(&part, self.x.len(), self.y.len(), scale)
    }
}

/// A magnified part with its own axes.
pub struct Inset {
    title: String,
    x: Range<f64>,
    y: Range<f64>,
    picture: String,
    ink: Ink,
}

/// The insets of a case on these axes: one per snapshot whose cloud is thin or small, with the same part for all cases.
pub fn insets(
    scene: &Scene<'_>,
    method: &Method<'_>,
    scale: Scale,
    axes: [&Range<f64>; 2],
) -> Result<Vec<Inset>, DrawError> {
    let mut insets = Vec::new();
    for (index, (density, &t)) in method.densities.iter().zip(&scene.times).enumerate() {
        let yardstick = yardstick(scene, density, index);
        if density.is_withheld() || density.grid != yardstick.grid || insets.len() == MOST {
            continue;
        }
        let window = match (is_thin(yardstick), is_small(yardstick, axes)) {
            (true, _) => Window::about_peak(yardstick),
            (false, true) => Window::whole(yardstick),
            (false, false) => continue,
        };
        let ((left, bottom), (right, top)) = window.corners(density);
        let picture = window.picture(density, &density.joint, scale)?;
        let ink = Ink::of_many(index, scene.times.len());
        insets.push(Inset { title: at_time(t), x: left..right, y: bottom..top, picture, ink });
    }
    Ok(insets)
}

/// Height of the rows of insets \[px\].
pub fn height(insets: &[Inset]) -> u32 {
    (insets.len().div_ceil(COLUMNS) as f64 * ROW) as u32
}

/// Draws the insets in rows.
pub fn draw(area: &Area<'_>, insets: &[Inset], variables: [&Variable; 2]) -> Result<(), DrawError> {
    let [horizontal, vertical] = variables.map(short_label);
    let rows = insets.len().div_ceil(COLUMNS);
    if rows == 0 {
        return Ok(());
    }
    for (area, inset) in area.split_evenly((rows, COLUMNS)).iter().zip(insets) {
        let around = Surroundings { title: &inset.title, ..Surroundings::default() };
        let (x, y) = (Axis::linear(&horizontal, inset.x.clone(), 3), Axis::linear(&vertical, inset.y.clone(), 3));
        let area = area.margin(0, 0, 0, units(6.0));
        let panel = Panel::new(&area, &x, &y, around)?;
        let ((left, right), (bottom, top)) = ((inset.x.start, inset.x.end), (inset.y.start, inset.y.end));
        let picture = Element::picture((left, bottom), (right, top), inset.picture.clone());
        panel.draw(&[picture.inked(inset.ink)])?;
    }
    Ok(())
}

/// Magnifies a part of a small map of a thin cloud, in the emptiest corner.
pub fn draw_inset(panel: &Panel<'_, '_>, map: &Map<'_>) -> Result<(), DrawError> {
    if !is_thin(map.yardstick) || map.density.grid != map.yardstick.grid {
        return Ok(());
    }
    let window = Window::about_peak(map.yardstick);
    let (low, high) = window.corners(map.density);
    let [left, top, right, bottom] = panel.frame();
    let (width, height) = (0.42 * (right - left), 0.42 * (bottom - top));
    let corners = [(left, top), (right - width, top), (left, bottom - height), (right - width, bottom - height)];
    let visible = visible_pixels(panel, map);
    let covered = |(x, y): (f64, f64)| {
        let inside = |p: &&Point| (x..x + width).contains(&p.0) && (y..y + height).contains(&p.1);
        visible.iter().filter(inside).count()
    };
    let Some((x, y)) = corners.into_iter().min_by_key(|corner| covered(*corner)) else { return Ok(()) };
    let (from, to) = (panel.point(x, y + height), panel.point(x + width, y));
    let frame = |(x0, y0): Point, (x1, y1): Point| {
        Element::curve(vec![(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)], FRAME)
    };
    panel.draw(&[
        Element::block(from, to, Ink::Paper, 1.0),
        Element::picture(from, to, window.picture(map.density, map.values, map.scale)?),
        frame(from, to),
        frame(low, high),
    ])?;
    let magnification = (to.0 - from.0) / (high.0 - low.0);
    let style = text_style(0.8 * SMALL, Ink::Text, HPos::Left, VPos::Top);
    panel.write(&format!("× {magnification:.1}"), panel.point(x + 3.0, y + 2.0), style)
}

/// Places of the visible bins of a map \[px\].
fn visible_pixels(panel: &Panel<'_, '_>, map: &Map<'_>) -> Vec<Point> {
    let (grid, least) = (&map.yardstick.grid, LEAST * map.yardstick.peak());
    let bins = map.yardstick.joint.iter().enumerate().filter(|(_, p)| **p >= least);
    bins.map(|(k, _)| panel.pixels((grid.x.edge(k / grid.y.bins), grid.y.edge(k % grid.y.bins)))).collect()
}

//! A panel: one pair of axes and the elements between them.

use plotters::chart::{ChartBuilder, ChartContext};
use plotters::prelude::{Cartesian2d, Color, CoordTranslate, IntoFont, RGBColor, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontFamily, FontStyle, ShapeStyle, TextStyle};
use plotters_backend::BackendColor;

use crate::axis::{Axis, Labels};
use crate::backend::{Area, SCALE, SvgBackend};
use crate::draw_error::DrawError;
use crate::elements::{Element, Point, Window};
use crate::palette::Ink;
use crate::text::text_width;

/// Size of text \[px\].
pub const TEXT: f64 = 12.0;
/// Size of the labels at ticks \[px\].
pub const SMALL: f64 = 11.0;

/// Width of a colour bar \[px\].
const BAR: f64 = 16.0;

type Coordinates = Cartesian2d<Axis, Axis>;

/// A pair of axes.
pub struct Panel<'a, 'b> {
    chart: ChartContext<'a, SvgBackend<'b>, Coordinates>,
    /// Two opposite corners.
    corners: [Point; 2],
}

/// What surrounds a panel.
#[derive(Debug, Clone, Copy, Default)]
pub struct Surroundings<'t> {
    /// Words above it.
    pub title: &'t str,
    /// Whether it is a colour bar: narrow, with the labels on the right.
    pub is_bar: bool,
    /// Whether to leave out the lines of the grid.
    pub without_grid: bool,
    /// Room on the left for the words of the axis \[px\], so that panels below one another begin at the same place; 0
    /// for as much as the words need.
    pub beside: f64,
}

/// A line width or a length in backend units.
pub fn units(pixels: f64) -> u32 {
    (pixels * f64::from(SCALE)).round() as u32
}

fn colour(ink: Ink) -> RGBColor {
    let (r, g, b) = ink.rgb();
    RGBColor(r, g, b)
}

/// A style for text.
pub fn text_style(size: f64, ink: Ink, horizontal: HPos, vertical: VPos) -> TextStyle<'static> {
    let font = (FontFamily::SansSerif, size * f64::from(SCALE)).into_font();
    TextStyle { font, color: BackendColor { alpha: 1.0, rgb: ink.rgb() }, pos: Pos::new(horizontal, vertical) }
}

/// The same in bold.
pub fn bold(style: TextStyle<'static>) -> TextStyle<'static> {
    TextStyle { font: style.font.style(FontStyle::Bold), ..style }
}

/// A style for lines.
pub fn line(ink: Ink, width: f64) -> ShapeStyle {
    ShapeStyle { color: colour(ink).to_rgba(), filled: false, stroke_width: units(width) }
}

/// How much room the words of an axis need on the left \[px\].
pub fn room_beside(y: &Axis) -> f64 {
    match y.labels {
        Labels::None => 4.0,
        _ => 10.0 + text_width(&y.longest_label(), SMALL) + if y.label.is_empty() { 0.0 } else { TEXT + 8.0 },
    }
}

impl<'a, 'b> Panel<'a, 'b> {
    /// Draws the axes into `area`.
    pub fn new(area: &'a Area<'b>, x: &Axis, y: &Axis, around: Surroundings<'_>) -> Result<Self, DrawError> {
        let beside = if around.beside > 0.0 { around.beside } else { room_beside(y) };
        let below = match x.labels {
            Labels::None => 4.0,
            _ => 10.0 + SMALL + if x.label.is_empty() { 0.0 } else { TEXT + 1.0 },
        };
        let left = if around.is_bar { 0.0 } else { beside };
        let above = if around.title.is_empty() { 8.0 } else { TEXT + 9.0 };
        if !around.title.is_empty() {
            // The title may reach over a colour bar beside the panel, but not out of the figure.
            let room = f64::from(area.dim_in_pixel().0) / f64::from(SCALE) + 66.0 - left;
            let size = TEXT * (room / (1.05 * text_width(around.title, TEXT))).min(1.0);
            let place = ((units(left + 4.0)) as i32, units(3.0) as i32);
            area.draw(&Text::new(around.title, place, bold(text_style(size, Ink::Text, HPos::Left, VPos::Top))))?;
        }
        let mut builder = ChartBuilder::on(area);
        builder.margin_top(units(above)).margin_right(units(8.0)).margin_left(units(4.0)).margin_bottom(units(3.0));
        builder.x_label_area_size(units(below));
        match around.is_bar {
            true => builder.right_y_label_area_size(area.dim_in_pixel().0.saturating_sub(units(12.0 + BAR))),
            false => builder.y_label_area_size(units(beside)),
        };
        let mut chart = builder.build_cartesian_2d(x.clone(), y.clone())?;
        let labels = text_style(SMALL, Ink::Text, HPos::Center, VPos::Top);
        let grid =
            if around.without_grid { ShapeStyle::from(colour(Ink::Grid).mix(0.0)) } else { line(Ink::Grid, 0.8) };
        let is_bare = |axis: &Axis| axis.labels == Labels::None;
        let mut mesh = chart.configure_mesh();
        mesh.light_line_style(colour(Ink::Grid).mix(0.0)).bold_line_style(grid).axis_style(line(Ink::Text, 1.0));
        mesh.label_style(labels).axis_desc_style(text_style(TEXT, Ink::Text, HPos::Center, VPos::Top));
        mesh.x_labels(x.ticks.len().max(1)).y_labels(y.ticks.len().max(1));
        mesh.set_all_tick_mark_size(units(3.0));
        if !is_bare(x) && !x.label.is_empty() {
            mesh.x_desc(x.label.as_str());
        }
        if !is_bare(y) && !y.label.is_empty() {
            mesh.y_desc(y.label.as_str());
        }
        mesh.draw()?;
        drop(mesh);
        Ok(Self { chart, corners: [(x.range.start, y.range.start), (x.range.end, y.range.end)] })
    }

    /// Draws `elements`, cut off at the axes.
    pub fn draw(&self, elements: &[Element]) -> Result<(), DrawError> {
        let area = self.chart.plotting_area();
        let [corner, opposite] = self.corners;
        area.draw(&Window::begin(corner, opposite))?;
        self.draw_over(elements)?;
        Ok(area.draw(&Window::end())?)
    }

    /// Draws `elements`, even where they reach beyond the axes.
    pub fn draw_over(&self, elements: &[Element]) -> Result<(), DrawError> {
        let area = self.chart.plotting_area();
        let place = |point: &Point| area.as_coord_spec().translate(point);
        elements.iter().try_for_each(|element| Ok(area.draw(&element.placed(place))?))
    }

    /// Writes a text at a point.
    pub fn write(&self, text: &str, at: Point, style: TextStyle<'static>) -> Result<(), DrawError> {
        let area = self.chart.plotting_area();
        let place = area.map_coordinate(&at);
        area.use_screen_coord().draw(&Text::new(text.to_owned(), place, style))?;
        Ok(())
    }

    /// The place of a point in the figure \[px\].
    pub fn pixels(&self, at: Point) -> (f64, f64) {
        let (x, y) = self.chart.plotting_area().map_coordinate(&at);
        (f64::from(x) / f64::from(SCALE), f64::from(y) / f64::from(SCALE))
    }

    /// Left, top, right and bottom of the panel in the figure \[px\].
    pub fn frame(&self) -> [f64; 4] {
        let [(left, bottom), (right, top)] = self.corners.map(|corner| self.pixels(corner));
        [left, top, right, bottom]
    }

    /// The point at this place in the figure \[px\].
    pub fn point(&self, x: f64, y: f64) -> Point {
        let [left, top, right, bottom] = self.frame();
        let [(x0, y0), (x1, y1)] = self.corners;
        (x0 + (x - left) / (right - left) * (x1 - x0), y0 + (y - bottom) / (top - bottom) * (y1 - y0))
    }
}

//! A joint density as colours: the density that sets the axes, the place of the picture, and the colour bar.

use std::ops::Range;

use super::TURN;
use crate::axis::{Axis, Labels, power_label};
use crate::backend::Area;
use crate::colour_map::{LEAST, Scale, picture, ramp};
use crate::densities::Density;
use crate::draw_error::DrawError;
use crate::elements::Element;
use crate::palette::Ink;
use crate::panel::{Panel, Surroundings, units};
use crate::scene::Scene;
use crate::words::density_label;
use results::description::Variable;

/// Additional space above a panel with a title \[px\].
pub const TITLE: f64 = 13.0;

/// The density that sets the axes of a snapshot: the yardstick's, or `own` if the yardstick withholds its density.
pub fn yardstick<'s>(scene: &'s Scene<'_>, own: &'s Density, index: usize) -> &'s Density {
    let given = scene.yardstick().and_then(|yardstick| yardstick.densities.get(index));
    given.filter(|density| !density.is_withheld()).unwrap_or(own)
}

/// A small map.
pub struct Map<'s> {
    /// The density whose bins the map has.
    pub density: &'s Density,
    /// The value shown in each bin.
    pub values: &'s [f64],
    /// The density that sets the axes.
    pub yardstick: &'s Density,
    /// The two variables.
    pub variables: [&'s Variable; 2],
    /// The colours.
    pub scale: Scale,
}

/// Pictures of values over the grid of `density`, moved by `shift` along the first variable. If that is an angle and
/// `axis` one turn, there is a picture for every turn that meets it; otherwise there is one picture of the whole grid.
pub fn placed(
    density: &Density,
    shift: f64,
    axis: &Range<f64>,
    values: &[f64],
    scale: Scale,
) -> Result<Vec<Element>, DrawError> {
    let (x, y) = (density.grid.x, density.grid.y);
    let address = picture(values, x.bins, y.bins, scale)?;
    let at = |shift: f64| Element::picture((x.low + shift, y.low), (x.high + shift, y.high), address.clone());
    if !density.grid.is_circle || axis.end - axis.start > TURN + 1e-6 {
        return Ok(vec![at(shift)]);
    }
    let first = ((axis.start - x.high - shift) / TURN + 1e-9).ceil() as i32;
    let shifts = (first..).map(|turn| shift + f64::from(turn) * TURN);
    Ok(shifts.take_while(|shift| x.low + shift < axis.end - 1e-9).map(at).collect())
}

/// A scale with its numbers. The label `words` gets the unit of a density of `variables`; long numbers are given in a
/// power of ten of that unit.
pub fn colour_bar(area: &Area<'_>, words: &str, variables: &[&Variable], scale: Scale) -> Result<(), DrawError> {
    let (end, unit) = match scale {
        Scale::Linear(end) | Scale::Difference(end) => unit(end),
        Scale::Strength(end) => (end, "1".to_owned()),
    };
    let label = density_label(words, &unit, variables);
    let y = match scale {
        Scale::Linear(_) => Axis::linear(&label, 0.0..end, 5),
        Scale::Difference(_) => Axis::linear(&label, -end..end, 5),
        Scale::Strength(_) if end > 0.0 => Axis::logarithmic(&label, LEAST * end, end, 5),
        Scale::Strength(_) => Axis::linear(&label, 0.0..1.0, 1),
    };
    let x = Axis { label: String::new(), range: 0.0..1.0, ticks: Vec::new(), labels: Labels::None };
    // As high as the map beside it, which has labels below.
    let area = area.margin(units(TITLE), units(35.0), 0, 0);
    let around = Surroundings { is_bar: true, without_grid: true, ..Surroundings::default() };
    let panel = Panel::new(&area, &x, &y, around)?;
    let colours = Element::picture((0.0, y.range.start), (1.0, y.range.end), ramp(scale)?);
    panel.draw(&[if let Scale::Strength(_) = scale { colours.inked(Ink::Text) } else { colours }])
}

/// The end of a scale in units of a power of ten, and that power as it is written.
fn unit(end: f64) -> (f64, String) {
    if end <= 0.0 || !end.is_finite() || (0.02..5000.0).contains(&end) {
        return (end, "1".to_owned());
    }
    let power = end.log10().floor();
    (end / 10f64.powf(power), power_label(power, false))
}

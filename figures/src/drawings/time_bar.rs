//! Which colour is which time, where there are too many snapshots for a key.

use crate::axis::{Axis, Labels};
use crate::backend::Area;
use crate::elements::Element;
use crate::figure::DrawError;
use crate::palette::Ink;
use crate::panel::{Panel, Surroundings, units};

/// Width of the bar with its words \[px\].
pub const TIME_BAR: f64 = 84.0;
/// Times written beside the bar, at most.
const NUMBERS: usize = 22;

/// A block of colour a snapshot, from the first below to the last above, with its time.
pub fn time_bar(area: &Area<'_>, times: &[f64]) -> Result<(), DrawError> {
    let mut y = Axis::names(times.iter().map(f64::to_string).collect());
    let stride = times.len().div_ceil(NUMBERS).max(1);
    y.ticks.retain(|tick| (*tick as usize).is_multiple_of(stride));
    y.label = "time t [yr]".into();
    let x = Axis { label: String::new(), range: 0.0..1.0, ticks: Vec::new(), labels: Labels::None };
    // As high as the panel beside it, which has labels below.
    let area = area.margin(0, units(35.0), 0, 0);
    let around = Surroundings { is_bar: true, without_grid: true, ..Surroundings::default() };
    let panel = Panel::new(&area, &x, &y, around)?;
    let count = times.len();
    let block = |index: usize| {
        let middle = index as f64;
        Element::block((0.0, middle - 0.5), (1.0, middle + 0.5), Ink::of_many(index, count), 1.0)
    };
    panel.draw(&(0..count).map(block).collect::<Vec<_>>())
}

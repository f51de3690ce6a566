//! The bar that shows which colour is which time.

use super::time_words;
use crate::axis::{Axis, Labels};
use crate::backend::Area;
use crate::draw_error::DrawError;
use crate::elements::Element;
use crate::palette::Ink;
use crate::panel::{Panel, Surroundings, units};

/// Width of the bar with its words \[px\].
pub const TIME_BAR: f64 = 84.0;
/// Largest number of times written beside the bar.
const NUMBERS: usize = 22;

/// Indices of the snapshots, of `count`, whose times are written: every second, third, ... and the last, with room
/// between them.
fn numbered(count: usize) -> impl Iterator<Item = usize> {
    let stride = count.div_ceil(NUMBERS).max(1);
    (0..count).filter(move |index| index + 1 == count || (index.is_multiple_of(stride) && index + stride < count))
}

/// A bar with one block of colour per snapshot, the first at the bottom and the last at the top, with its time.
pub fn time_bar(area: &Area<'_>, times: &[f64]) -> Result<(), DrawError> {
    let mut y = Axis::names(times.iter().map(|&t| time_words(t)).collect());
    y.ticks = numbered(times.len()).map(|index| index as f64).collect();
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_and_the_last_time_are_written_and_no_two_are_crowded() {
        for count in 1..=64 {
            let numbered: Vec<usize> = numbered(count).collect();
            assert_eq!([numbered[0], numbered[numbered.len() - 1]], [0, count - 1]);
            assert!(numbered.len() <= NUMBERS);
            let least = count.div_ceil(NUMBERS);
            assert!(numbered.windows(2).all(|pair| pair[1] - pair[0] >= least), "{count}: {numbered:?}");
        }
    }
}

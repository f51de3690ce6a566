//! A small map of one snapshot; for a thin cloud, the part about its peak is magnified.

use std::f64::consts::PI;

use super::density_map::{Map, colour_bar, placed};
use super::{beside_bar, write_absent, zoom};
use crate::axis::Axis;
use crate::densities::Density;
use crate::draw_error::DrawError;
use crate::figure::Figure;
use crate::panel::{Panel, Surroundings};
use crate::scene::Cloud;
use crate::words::short_label;

/// Width of the colour bar with its labels \[px\].
const BAR: f64 = 78.0;

impl Map<'_> {
    /// Draws the map; the words are its title, its heading and its caption.
    pub fn draw(&self, name: &str, [title, heading, caption]: [&str; 3], words: &str) -> Result<Figure, DrawError> {
        let is_withheld = self.values.iter().any(|value| !value.is_finite());
        let Cloud { x, y } = whole(self.yardstick);
        let [horizontal, vertical] = self.variables.map(short_label);
        let pictures = if is_withheld { Vec::new() } else { placed(self.density, 0.0, &x, self.values, self.scale)? };
        Figure::draw(name, title, caption, (264, 206), &[], |area| {
            let (left, right) = beside_bar(area, BAR);
            let around = Surroundings { title: heading, ..Surroundings::default() };
            let (x, y) = (Axis::linear(&horizontal, x, 4), Axis::linear(&vertical, y, 5));
            let panel = Panel::new(&left, &x, &y, around)?;
            panel.draw(&pictures)?;
            if is_withheld {
                return write_absent(&panel, "withheld");
            }
            zoom::draw_inset(&panel, self)?;
            colour_bar(&right, words, &self.variables, self.scale)
        })
    }
}

/// The range of all bins of a density. If the bins cover a whole turn and the cloud reaches over their ends, the range
/// begins where it keeps the cloud whole.
fn whole(density: &Density) -> Cloud {
    let (x, y) = (density.grid.x, density.grid.y);
    let cloud = Cloud::of(density);
    let start = if cloud.x.end > x.high + 1e-9 { cloud.x.start.midpoint(cloud.x.end) - PI } else { x.low };
    Cloud { x: start..start + (x.high - x.low), y: y.low..y.high }
}

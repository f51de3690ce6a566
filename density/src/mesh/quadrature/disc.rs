//! A disc within which the image of a cell lies, and whether solar angle and eccentricity are smooth in it.

use crate::angle::nearest;
use crate::model::plane::State;

/// Distance of a part's middle from the origin, in half widths of the part, beyond which `phi` and `e` are smooth in
/// it.
const FAR: f64 = 3.0;

/// A circle in `(x1, x2)` within which the image of a cell lies.
#[derive(Debug, Clone, Copy)]
pub(super) struct Disc {
    middle: State,
    radius: f64,
}

/// Factor by which an image may extend beyond the points examined.
const BULGE: f64 = 1.25;

impl Disc {
    /// Around points; the distance to the corners is `reach` times that to the farthest of the points.
    pub fn around(points: impl Iterator<Item = State> + Clone, reach: f64) -> Self {
        let sum = points.clone().fold([0.0; 3], |[x1, x2, n], state| [x1 + state.x1, x2 + state.x2, n + 1.0]);
        let middle = State { x1: sum[0] / sum[2], x2: sum[1] / sum[2] };
        let distance = |state: State| (state.x1 - middle.x1).hypot(state.x2 - middle.x2);
        Self { middle, radius: BULGE * reach * points.map(distance).fold(0.0, f64::max) }
    }

    /// Whether `phi` and `e` are smooth in the disc: it is far from the origin compared with its size, and off the cut.
    pub fn is_regular(&self, cut: f64) -> bool {
        let e = self.middle.eccentricity();
        e > FAR * self.radius && {
            let off_cut = nearest(self.middle.x1.atan2(self.middle.x2) - cut, 0.0).abs();
            off_cut > (self.radius / e).asin()
        }
    }
}

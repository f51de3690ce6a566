//! Whether what is varied has an effect on what is shown.

use toml::Spanned;

use super::{MapFile, Shown};
use crate::files::input::{InputError, InputFile};
use crate::files::sweep::Varied;

/// Largest relative difference by which rounding may change a number that does not depend on an axis.
const ROUNDING: f64 = 1e-12;

impl MapFile {
    /// Refuses an axis along which the quantity does not change.
    pub(super) fn check_effect(&self, file: &InputFile, vary: &Spanned<Varied>) -> Result<(), InputError> {
        for (axis, key) in self.axes.iter().enumerate() {
            if self.has_effect(axis)? {
                continue;
            }
            let place = vary.get_ref().keys().find(|known| known.get_ref() == key);
            let problem =
                format!("has no effect on the {}, so that it is no axis of its map; vary something else", self.label());
            return Err(place.map_or_else(|| file.error(vary, &problem), |place| file.error(place, &problem)));
        }
        Ok(())
    }

    /// Whether two points along an axis differ in something on which the quantity depends.
    fn has_effect(&self, axis: usize) -> Result<bool, InputError> {
        let count = if axis == 0 { self.size().0 } else { self.size().1 };
        let at = |k: usize| {
            let index = self.index(if axis == 0 { (k, 0) } else { (0, k) });
            let point = self.point(index)?;
            // Of a required value the quantity is a factor, which is shown times this.
            let scale = if self.shown == Shown::Itself { 1.0 } else { self.scale(index, &point) / point.radiation() };
            Ok((point.reduced_to(self.quantity), scale))
        };
        let (first, scale) = at(0)?;
        for k in 1..count {
            let (point, other) = at(k)?;
            if point != first || (other / scale - 1.0).abs() > ROUNDING {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

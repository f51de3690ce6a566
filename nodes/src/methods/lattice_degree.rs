//! The degree to which a lattice of characteristics is interpolated unless it is set.

/// Degree of a lattice that is large enough for it.
const USUAL: usize = 7;

/// The usual degree, or the largest that fits a lattice of `side` points per side if that is less.
pub(super) fn usual_degree(side: usize) -> usize {
    USUAL.min(side.saturating_sub(1)).max(1)
}

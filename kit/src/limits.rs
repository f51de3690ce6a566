//! The largest runs that messages can describe.

/// Most bins per axis of a comparison grid.
pub const MOST_BINS: usize = 2000;
/// Most cases of a run.
pub const MOST_CASES: usize = 64;

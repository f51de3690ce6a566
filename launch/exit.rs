//! Exit codes that several commands have.

/// Bad input; nothing was started.
pub const BAD_INPUT: u8 = 2;

/// The user asked to stop.
pub const INTERRUPTED: u8 = 130;

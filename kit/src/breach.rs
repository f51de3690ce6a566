//! The rules about snapshots by name, and a rule that one breaks.

use std::fmt;

/// A rule about snapshots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// It belongs to the run and the scenario.
    Identity,
    /// Its scenario has as many snapshots as it says.
    Count,
    /// It is the next one.
    Order,
    /// Its time is the one asked for, to the last bit.
    Time,
    /// Its kind is known, and it holds as many numbers as it says.
    Shape,
    /// All numbers are finite, except figures that a density withholds.
    Finite,
    /// All variables of trajectories lie in their ranges: `0 <= e < 1`.
    Range,
}

/// A rule that a snapshot breaks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Breach {
    /// Which rule.
    pub rule: Rule,
    /// What was seen, and what would be right.
    pub what: String,
}

impl fmt::Display for Breach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)
    }
}

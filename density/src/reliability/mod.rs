//! Maps from which a disposal designer decides: a quantity of a cloud for many scenarios, such as the probability of re-entry over
//! semi-major axis and area-to-mass ratio.
//!
//! What a cloud does with a *given* radiation parameter `C` is a function of `C` ([`by_radiation`]). An uncertain `C` only averages over that function, and all
//! scenarios that differ in `C` or in its uncertainty alone share it ([`rows`]). So a whole row of a map costs about as much as a few of its points.
//! Where the quantity hardly bends between points of the map, it is interpolated ([`refinement`]).

pub mod by_orbits;
pub mod by_radiation;
pub mod quantity;
pub mod refinement;
pub mod rows;

pub use quantity::Quantity;
pub use rows::{Point, Row, evaluate};

use crate::exact::Estimated;

/// A figure of which nothing is known.
pub const UNKNOWN: Estimated = Estimated { value: f64::NAN, error: f64::INFINITY };

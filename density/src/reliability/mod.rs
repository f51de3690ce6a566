//! Maps from which a disposal designer decides: a quantity of a cloud for many scenarios, such as the probability of
//! re-entry over semi-major axis and area-to-mass ratio.
//!
//! What a cloud does with a *given* radiation parameter `C` is a function of `C`. An uncertain `C` only averages over
//! that function, and all scenarios that differ in `C` or in its uncertainty alone share it. So a whole row of a map
//! costs about as much as a few of its points. Where the quantity hardly bends between points of the map, it is
//! interpolated.
//!
//! | file | idea |
//! |---|---|
//! | [`quantity`] | what a map shows |
//! | [`any_point`] | points in the plane or in space |
//! | [`rows`] | points in the plane: by the exact curve, or by orbits |
//! | [`in_space`] | points in space: by orbits |
//! | [`by_radiation`] | figures as a function of `C`, and their means over it |
//! | [`cloud`] | orbits that start in a cloud, each with a `C` of its own, in the plane or in space |
//! | [`by_orbits`] | the values of `C` with which orbits pass |
//! | [`followed`] | orbits that are followed to the end of a quantity |
//! | [`replicates`] | figures of independent samples, and their errors |
//! | [`required`] | the factor on `C` with which a probability is reached |
//! | [`difference`] | the difference between two models or methods |
//! | [`refinement`] | which points of a map are computed |

pub mod any_point;
pub mod by_orbits;
pub mod by_radiation;
pub mod cloud;
pub mod difference;
pub mod followed;
pub mod in_space;
pub mod quantity;
pub mod refinement;
pub mod replicates;
pub mod required;
pub mod rows;

pub use any_point::{AnyPoint, are_alike, evaluate};
pub use difference::Other;
pub use quantity::Quantity;
pub use rows::{Point, Row};

use crate::exact::Estimated;

/// A figure of which nothing is known.
pub const UNKNOWN: Estimated = Estimated { value: f64::NAN, error: f64::INFINITY };

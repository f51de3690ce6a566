//! The science of phasecloud, as a plain library: nothing here knows a process or a topic.
//!
//! A [`problem::Problem`] is carried by the [`flow::Flow`] of its [`dynamics::Force`]; every method ends in an
//! [`estimate::Estimate`] on the problem's comparison [`grid::Grid`].

pub mod angle;
pub mod binning;
pub mod distance;
pub mod dynamics;
pub mod estimate;
pub mod exact;
pub mod first_passage;
pub mod flow;
pub mod grid;
pub mod mesh;
pub mod mixture;
pub mod orbits;
pub mod partial;
pub mod problem;
pub mod sampling;
pub mod standard_errors;
pub mod trust;

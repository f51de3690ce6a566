//! The science of phasecloud, as a plain library: nothing here knows a process or a topic.
//!
//! A [`problem::Problem`] is carried by the [`flow::Flow`] of its [`model::Model`]; every method ends in an
//! [`estimate::Estimate`] on the problem's comparison [`grid::Grid`].

pub mod angle;
pub mod binning;
pub mod distance;
pub mod estimate;
pub mod exact;
pub mod first_passage;
pub mod flow;
pub mod gaussian;
pub mod grid;
pub mod mesh;
pub mod mixture;
pub mod model;
pub mod orbits;

pub mod problem;
pub mod problem_error;
pub mod sample_sums;
pub mod sampling;
pub mod standard_errors;
pub mod trust;
pub mod variable_moments;

/// The names of the paper's planar model by which the rest of the house has known them.
pub mod dynamics {
    pub use crate::model::earth::{self, SUN_MEAN_MOTION};
    pub use crate::model::planar::{Force, force_from_orbit};
    pub use crate::model::plane::{State, density_growth, density_growth_without_jacobian};
}

//! The science of phasecloud, as a plain library: nothing here knows a process or a topic.
//!
//! A [`problem::Problem`] is carried by the [`flow::Flow`] of its [`model::Model`]; every method ends in an
//! [`estimate::Estimate`] on the problem's comparison [`grid::Grid`].
//!
//! # A tour
//! The paper's scenario 1 half a year ahead, by Monte Carlo and exactly:
//!
//! ```
//! use density::exact::{Exact, ExactSettings};
//! use density::flow::Flow;
//! use density::grid::comparison_grids;
//! use density::model::planar::SrpJ2;
//! use density::orbits::Orbits;
//! use density::problem::{InitialGaussian, Problem};
//! use density::{binning, sampling};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let force = SrpJ2 { radiation: 0.15, oblateness: 0.40921 };
//! let initial = InitialGaussian { mean_phi: 2.2069, mean_e: 0.145, sigma_phi: 0.19635, sigma_e: 0.025, correlation: 0.0 };
//! let problem = Problem::new(force, initial, vec![0.0, 0.5], 0.6)?;
//! let flow = Flow::new(problem.model);
//! let grids = comparison_grids(&problem, &flow, 40, 40)?;
//!
//! // Monte Carlo: samples are drawn, moved, and counted into the bins of the grid.
//! let (x1, x2) = sampling::draw(&problem.initial, 1, 10_000);
//! let mut orbits = Orbits::new(flow, x1, x2);
//! orbits.advance_to(0.5)?;
//! let (mut phi, mut e) = (vec![0.0; 10_000], vec![0.0; 10_000]);
//! orbits.read_out(&mut phi, &mut e);
//! let sampled = binning::estimate(&phi, &e, grids[1], problem.critical_e);
//!
//! // The exact density, which knows its own error.
//! let exact = Exact::new(&problem, &flow, ExactSettings::default()).snapshot(&grids, 1)?;
//! assert!(exact.moment_error < 1e-7);
//! let difference = sampled.moments.mean_e - exact.estimate.moments.mean_e;
//! assert!(difference.abs() < 5.0 * sampled.standard_errors.mean_e);
//! # Ok(())
//! # }
//! ```

pub mod angle;
pub mod binning;
pub mod disposal;
pub mod distance;
pub mod estimate;
pub mod exact;
pub mod first_passage;
pub mod flow;
pub mod flow_map;
pub mod gaussian;
pub mod grid;
pub mod in_space;
pub mod lanes;
pub mod mesh;
pub mod mixture;
pub mod model;
pub mod orbits;
pub mod problem;
pub mod problem_error;
pub mod projected;
pub mod rare;
pub mod reliability;
pub mod sample_sums;
pub mod sampling;
pub mod standard_errors;
pub mod trust;
pub mod uncertain;
pub mod variable_moments;
mod wrapped;

pub use exact::Exact;
pub use flow::Flow;
pub use grid::Grid;
pub use model::Model;
pub use model::planar::SrpJ2;
pub use orbits::Orbits;
pub use problem::{InitialGaussian, Problem};

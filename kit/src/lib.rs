//! What a propagator needs: implement [`Propagator`], and let `main` return [`main`]'s result.
//!
//! A propagator turns a scenario into snapshots. This one carries the mean of the initial Gaussian along and says that
//! the cloud has not changed its shape, as a mixture of one component:
//!
//! ```no_run
//! use density::flow::Flow;
//! use density::model::registry::Planar;
//! use density::orbits::Orbits;
//! use kit::{Assignment, Failure, Form, Propagator};
//! use messages::content::Mixture;
//!
//! #[derive(Default)]
//! struct Rigid(Option<(Orbits<Planar>, Assignment)>);
//!
//! impl Propagator for Rigid {
//!     fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
//!         let problem = &assignment.plane()?.problem; // refuses a model that is none of the plane's
//!         let (phi, e) = (problem.initial.mean_phi, problem.initial.mean_e);
//!         let orbits = Orbits::from_polar(Flow::new(problem.model), &[phi], &[e]);
//!         self.0 = Some((orbits, assignment.clone()));
//!         Ok(Form::whole(Mixture::UNJUDGED, 1))
//!     }
//!
//!     fn advance(&mut self, index: usize) -> Result<usize, Failure> {
//!         let (orbits, assignment) = self.0.as_mut().ok_or_else(Failure::no_scenario)?;
//!         orbits.advance_to(assignment.times[index])?;
//!         Ok(1)
//!     }
//!
//!     fn write(&self, columns: &mut [f64]) {
//!         let Some((orbits, assignment)) = &self.0 else { return };
//!         let ([mut phi], [mut e]) = ([0.0], [0.0]);
//!         orbits.read_out(std::slice::from_mut(&mut phi), std::slice::from_mut(&mut e));
//!         let &[phi_phi, phi_e, e_e] = &assignment.description.covariance[..] else { return };
//!         Mixture::write_row(columns, 0, [1.0, phi, e, phi_phi, phi_e, e_e]);
//!     }
//! }
//!
//! fn main() -> std::process::ExitCode {
//!     kit::main(Rigid::default())
//! }
//! ```
//!
//! - [`propagator`]: the trait; `serving`: the loop that serves scenario after scenario; `drafting`: how a snapshot's
//!   message is made; [`passage`]: first passages as a propagator states them;
//! - [`assignment`]: a scenario as a propagator gets it; [`planar_problem`], [`space_problem`]: the problem that it
//!   states; [`space`]: its variables, and what is said of a cloud in them;
//! - [`kind`]: what is known of each kind of snapshot; [`snapshot_rules`]: what every snapshot must be;
//! - [`session`]: a process's access to the run; [`screen`]: what may pass from a topic into a process;
//! - [`shard`], [`reduced`]: cases in parts, and samples that are reduced before they are sent;
//! - [`failure`], [`log`]: why a process ends before its work is done, and the log.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic))]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod assignment;
pub mod breach;
mod carried_density;
pub mod clock;
pub mod diagnosis;
mod drafting;
pub mod environment;
pub mod example;
pub mod failure;
pub mod kind;
pub mod limits;
pub mod log;
pub mod newest;
pub mod passage;
pub mod planar_problem;
pub mod problem_key;
pub mod propagator;
pub mod reduced;
pub mod refusals;
pub mod screen;
pub mod sender;
mod serving;
pub mod session;
pub mod shard;
pub mod snapshot_rules;
pub mod space;
pub mod space_problem;
mod threads;

pub use assignment::{Assignment, Plane};
pub use failure::Failure;
pub use passage::Passage;
pub use propagator::{Form, Propagator};
pub use serving::{main, serve};
pub use session::Session;

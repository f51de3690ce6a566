//! What a propagator needs: implement [`Propagator`], and let `main` return [`main`]'s result.
//!
//! - [`propagator`]: the trait, and the loop that serves scenario after scenario;
//! - [`assignment`]: a scenario as a propagator gets it; [`space`]: its variables, and what is said of a cloud in them;
//! - [`kind`]: what is known of each kind of snapshot; [`snapshot_rules`]: what every snapshot must be;
//! - [`session`]: a process's access to the run; [`screen`]: what may pass from a topic into a process;
//! - [`shard`], [`reduced`]: cases in parts, and samples that are reduced before they are sent;
//! - [`failure`], [`log`]: why a process ends before its work is done, and the log.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic))]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod assignment;
mod carried_density;
pub mod clock;
pub mod example;
pub mod failure;
pub mod kind;
pub mod log;
pub mod newest;
pub mod propagator;
pub mod reduced;
pub mod screen;
pub mod sender;
pub mod session;
pub mod shard;
pub mod snapshot_rules;
pub mod space;
mod threads;

pub use assignment::{Assignment, Plane};
pub use failure::Failure;
pub use propagator::{Form, Passage, Propagator, main, serve};
pub use session::Session;

//! phasecloud's processes: the propagators that come with it, the services that every run has, and the files from which
//! they are told what to do.
//!
//! - [`methods`]: the built-in propagators, one module per method, and their registry;
//! - [`services`]: scenario, estimator, comparator, recorder and player;
//! - [`files`]: scenario, sweep and map files, and how mistakes in TOML files are reported;
//! - [`assigning`]: the assignment that a scenario file makes; [`in_process`]: a case that is computed without any
//!   other process.
//!
//! A process is a [`kit::session::Session`] (its access to the run) and a loop that sleeps until a message arrives. The
//! science is in `density`, the contract in `messages`, and what any propagator needs in `kit`.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic))]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

#[cfg(test)]
mod arbitrary_messages;
pub mod assigning;
pub mod files;
pub mod in_process;
pub mod methods;
pub mod services;

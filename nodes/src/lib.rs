//! phasecloud's processes, one module each, and the small [`kit`] with which anyone writes a propagator of their own.
//!
//! A process is a [`session::Session`] (its access to the run) and a loop that sleeps until a message arrives. The
//! science is in `density`, the contract in `messages`; this crate only joins them.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic))]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod accuracy;
pub mod assignment;
pub mod builtin;
mod carried_density;
pub mod clock;
pub mod comparator;
pub mod course;
pub mod dee;
pub mod estimator;
pub mod exact;
pub mod failure;
pub mod file_kind;
mod gathering;
pub mod gmm_ut;
#[cfg(test)]
mod hostile;
pub mod input;
mod key_path;
pub mod kind;
pub mod kit;
pub mod log;
pub mod mc;
pub mod method;
pub mod newest;
pub mod passage_rules;
pub mod plain_number;
pub mod player;
pub mod reading;
pub mod recorder;
pub mod reduced;
mod roomy;
pub mod roster;
pub mod scenario;
pub mod scenario_file;
pub mod screen;
pub mod sender;
pub mod session;
pub mod shard;
pub mod snapshot_rules;
pub mod space;
pub mod sweep;
mod sweep_values;
mod threads;
pub mod toml_words;
pub mod unknown_key;
pub mod yardstick;

//! The launcher behind the command `phasecloud`: it reads launch files, starts the processes of a run, looks after them, and prints what
//! came out.
//!
//! | room | what is in it |
//! |---|---|
//! | `command` | the command line: a file for each command |
//! | [`plan`] | launch files: what is to run, checked before anything starts |
//! | `domain` | the place of a run in shared memory: claimed, kept, found again |
//! | `crew` | processes: with which command each is started, how it is watched and ended |
//! | `run` | a run under way: who has said what, who has failed, when it is over |
//! | `results` | the results folder: where it lies, its manifest, its checksums; recordings |
//! | `report` | the tables that a run prints |
//! | `live`, `observe` | what is shown of a run while it lasts |
//! | `sweep` | many scenarios from one file |
//! | `check` | whether a propagator keeps the contract |

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic))]
// They end the process when nobody reads; see `output`.
#![deny(clippy::print_stdout, clippy::print_stderr)]

#[macro_use]
mod output;

mod check;
pub mod command;
mod crew;
mod domain;
mod exit;
mod live;
mod observe;
pub mod plan;
pub mod report;
mod results;
mod run;
mod shown;
mod sweep;

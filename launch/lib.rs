//! The launcher behind the command `phasecloud`: it starts and watches the processes of a run and prints its results.
//!
//! | module | what is in it |
//! |---|---|
//! | `command` | the command line: one file per command |
//! | [`plan`] | launch files: what is to run, checked before anything starts |
//! | `domain` | the domain of a run in shared memory: how it is claimed, kept and found again |
//! | `crew` | processes: the command that starts each, how it is watched and ended |
//! | `run` | a run under way: who has reported what, who has failed, when it is over |
//! | `record` | what a run leaves behind: its results folder while it is filled, the manifest, checksums, recordings |
//! | `report` | the tables that a run prints |
//! | `live`, `observe` | what is shown while a run lasts |
//! | `sweep` | many scenarios from one file |
//! | `map` | a quantity over one or two numbers of a scenario |
//! | `check` | whether a propagator keeps the contract |
//! | `output`, `shown` | printing that never fails, and the options by which a command says how much it shows |
//! | `exit` | exit codes that several commands have |

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic))]
// `println!` and `eprintln!` end the process when nobody reads its output; see `output`.
#![deny(clippy::print_stdout, clippy::print_stderr)]

#[macro_use]
mod output;

mod check;
pub mod command;
mod crew;
mod domain;
mod exit;
mod live;
mod map;
mod observe;
pub mod plan;
mod record;
pub mod report;
mod run;
mod shown;
mod sweep;

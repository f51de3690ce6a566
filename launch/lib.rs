//! What of the launcher others use as well: the reader of launch files, which tests and fuzzers feed.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic))]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod cases;
pub mod hosts;
pub mod launch_file;

//! The processes of a run: with which command each is started, how it is watched and ended.

pub mod commands;
pub mod ending;
pub mod environment;
pub mod guard;
pub mod log_sink;
pub mod member;
pub mod processes;
pub mod report_line;
#[cfg(feature = "hosts")]
pub mod share;
pub mod shares;
pub mod supervisor;

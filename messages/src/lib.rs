//! The contract between phasecloud's processes: what is sent, on which topic, with which guarantees. No science.
//!
//! ```text
//! scenario --scenario--> propagators --snapshot--> estimator --density--> comparator --comparison--> recorder
//!                        propagators --passage--> recorder
//!                        every node --status--> launcher --roster--> comparator, recorder
//! ```
//!
//! - [`layout`]: the headers, byte for byte, as any language sees them;
//! - [`content`]: the kinds of snapshots, their columns and further fields;
//! - [`payload`]: names and units of the numbers after a header;
//! - [`describe`]: tables of all fields and codes, for documents and tools;
//! - [`contract`]: the names of all messages, with their versions;
//! - [`topic`]: the topics and how many messages they hold;
//! - [`domain`]: the part of shared memory that belongs to one run;
//! - [`port`]: sending and receiving without silent loss of messages;
//! - [`observe`]: readers that never delay a run;
//! - [`patience`]: clocks that leave out the time in which their own process did not run;
//! - [`recording`]: every message of a run in one file;
//! - [`report`]: the report of a node, as a value;
//! - [`service`]: the processes that a run has besides its propagators;
//! - [`wait`]: sleeping until a message or a signal to stop arrives;
//! - [`scenario`]: the problem, with a description of its variables;
//! - [`text`]: text in fixed fields.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic))]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod content;
pub mod contract;
pub mod describe;
pub mod domain;
pub mod layout;
pub mod observe;
pub mod patience;
pub mod payload;
pub mod port;
mod port_error;
pub mod recording;
pub mod report;
pub mod scenario;
pub mod service;
pub mod text;
pub mod topic;
pub mod wait;

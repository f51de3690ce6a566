//! The contract between phasecloud's processes: what is sent, on which topic, with which guarantees. No science.
//!
//! ```text
//! scenario --scenario--> propagators --snapshot--> estimator --density--> comparator --comparison--> recorder
//!                        propagators --passage--> recorder
//!                        every node --status--> launcher --roster--> comparator, recorder
//! ```
//!
//! - [`layout`]: the headers, byte for byte, as any language sees them;
//! - [`topic`]: the topics and how many of what they hold;
//! - [`domain`]: the corner of shared memory that belongs to one run;
//! - [`port`]: sending and receiving without losing anything in silence;
//! - [`wait`]: sleeping until a message or a signal to stop arrives;
//! - [`text`]: text in fixed fields.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod domain;
pub mod layout;
pub mod port;
pub mod text;
pub mod topic;
pub mod wait;

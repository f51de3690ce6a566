//! The contract between phasecloud's processes: what is sent, on which topic, with which guarantees. No science.
//!
//! ```text
//! scenario --scenario--> propagators --snapshot--> estimator --density--> comparator --comparison--> recorder
//!                        propagators --passage--> recorder
//!                        every node --status--> launcher --roster--> comparator, recorder
//! ```
//!
//! - [`layout`]: the headers, byte for byte, as any language sees them;
//! - [`comparison_kind`]: what a comparison contains;
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
//! - [`reporter`]: who reports: a service, or a propagator;
//! - [`service`]: the processes that a run has besides its propagators;
//! - [`wait`]: sleeping until a message or a signal to stop arrives;
//! - [`scenario`]: the problem, with a description of its variables;
//! - [`text`]: text in fixed fields.
//!
//! A message is a header and a slice of items. A header is a plain structure that describes itself, and a scenario
//! message becomes a value that has been checked:
//!
//! ```
//! use messages::scenario::{Description, Moment, Parameter, Projection, Range, Variable};
//!
//! let variable = |symbol: &str, range| Variable { name: symbol.into(), symbol: symbol.into(), unit: String::new(), range };
//! let said = Description {
//!     run_id: 7,
//!     scenario: 0,
//!     scenarios: 1,
//!     name: "mine".into(),
//!     model: "planar".into(),
//!     parameters: vec![Parameter { name: "radiation".into(), symbol: "C".into(), value: 0.15 }],
//!     variables: vec![variable("phi", Range::Circle), variable("e", Range::Interval { low: 0.0, high: 1.0 })],
//!     reentry: 1,
//!     critical: 0.6,
//!     mean: vec![2.2, 0.145],
//!     covariance: vec![0.04, 0.0, 0.000625],
//!     projections: vec![Projection { first: (0, 100), second: Some((1, 100)) }],
//!     snapshots: vec![Moment { time: 0.0, ends: vec![[1.0, 3.0], [0.0, 0.3]] }],
//! };
//! let (header, items) = said.encode()?;
//! assert_eq!(items.len(), Description::numbers(2, 2, 1));
//! assert_eq!(Description::decode(&header, &items)?, said);
//! let field = <messages::scenario::ScenarioHeader as messages::Described>::FIELDS[1];
//! assert_eq!((field.name, field.offset), ("critical", 8));
//! # Ok::<(), String>(())
//! ```

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic))]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod comparison_kind;
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
pub mod reporter;
pub mod scenario;
pub mod service;
pub mod text;
pub mod topic;
pub mod wait;

pub use content::Content;
pub use describe::Described;
pub use domain::{Domain, Place};
pub use port::{Inlet, Message, Outlet, PortError};
pub use topic::Topic;

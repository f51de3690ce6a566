//! The node that carries messages between the domains of a run's hosts, over zenoh, and the questions by which worker
//! hosts get parts of a map.
//!
//! ```text
//!       home                                                     worker host
//!   estimator, recorder, launcher                             propagators, `phasecloud join`
//!        |  local domain                                          |  local domain
//!     bridge  <--- snapshot, passage, status, log ---  zenoh  ---  bridge
//!             ---- scenario ------------------------>
//! ```
//!
//! zenoh does discovery, routing, retransmission, flow control and encryption. The bridge ensures that no message is
//! lost or doubled when a link is cut or a process is started again: the reader pulls. It asks for the message after
//! the last one it has whole (`link/wire.rs`), piece by piece, and asks again when an answer does not come. The sender
//! keeps a message where it lies, in shared memory, until the reader asks for the next.
//!
//! - [`endpoint`]: where to listen or connect, and who may
//! - `pem`, only with the feature `zenoh`: whether the files for TLS are what they should be
//! - [`tls`]: the files that TLS needs
//! - [`plan`]: which process runs on which host
//! - `link`, only with the feature `zenoh`: all that needs a connection. Without it launch files can still be checked

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic))]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod endpoint;
pub mod plan;
pub mod tls;

#[cfg(feature = "zenoh")]
mod link;
#[cfg(feature = "zenoh")]
mod pem;
#[cfg(feature = "zenoh")]
pub use link::{dealing, greeting, run, session};
#[cfg(feature = "zenoh")]
pub use zenoh;

//! The node that carries messages between the domains of a run's hosts, over zenoh.
//!
//! ```text
//!       home                                                     worker host
//!   estimator, recorder, launcher                             propagators, `phasecloud join`
//!        |  local domain                                          |  local domain
//!     bridge  <--- snapshot, passage, status, log ---  zenoh  ---  bridge
//!             ---- scenario ------------------------>
//! ```
//!
//! Discovery, routing, retransmission, flow control and encryption are zenoh's. What is ours is that nothing is lost or
//! doubled when a link is cut or a process is started again: the reader pulls. It asks for the message after the last
//! one it has whole (`wire::Ask`), piece by piece, and asks again when an answer does not come. The sender keeps a
//! message where it lies, in shared memory, until the reader asks for the next.
//!
//! - [`endpoint`]: where to listen or connect, and who may; `session`: zenoh set up accordingly
//! - [`plan`]: who does what; `greeting`: a worker host introduces itself and is told its share
//! - `wire`, `serve`, `pull`: the stream of a topic's messages, its sender, its reader
//! - `landing`: what has been pulled goes into the local domain, once
//! - `home`, `worker`: the node at either end; `log_stream`: the log follows; `contact`: who was last heard when
//!
//! Without the feature `zenoh` only what describes a run over several hosts is there, so that files can be checked.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod endpoint;
pub mod plan;

#[cfg(feature = "zenoh")]
mod contact;
#[cfg(feature = "zenoh")]
pub mod greeting;
#[cfg(feature = "zenoh")]
mod home;
#[cfg(feature = "zenoh")]
mod landing;
#[cfg(feature = "zenoh")]
mod log_stream;
#[cfg(feature = "zenoh")]
mod pull;
#[cfg(feature = "zenoh")]
mod serve;
#[cfg(feature = "zenoh")]
pub mod session;
#[cfg(feature = "zenoh")]
mod wire;
#[cfg(feature = "zenoh")]
mod worker;

#[cfg(feature = "zenoh")]
mod node;
#[cfg(feature = "zenoh")]
pub use node::run;
#[cfg(feature = "zenoh")]
pub use zenoh;

#[cfg(all(test, feature = "zenoh"))]
mod tests;

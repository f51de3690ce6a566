//! All that needs a connection.
//!
//! - [`session`]: zenoh, set up for one home host and its workers
//! - [`greeting`]: a worker host introduces itself at home and is told its share; [`register`]: which hosts are there
//! - [`wire`], [`serve`], [`pull`]: the stream of a topic's messages, its sender, its reader
//! - [`landing`]: puts the messages that have been pulled into the local domain, each snapshot once
//! - [`log_stream`]: brings the log home; [`contact`]: when another host was last heard of
//! - [`home`], [`worker`]: the node at either end; [`node`] starts the right one
//! - [`dealing`]: the parts of a map, for which worker hosts ask

mod contact;
pub mod dealing;
pub mod greeting;
mod home;
mod landing;
mod log_stream;
mod node;
mod pull;
mod register;
mod serve;
pub mod session;
mod wire;
mod worker;

pub use node::run;

#[cfg(test)]
mod tests;

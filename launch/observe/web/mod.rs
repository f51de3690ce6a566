//! `phasecloud watch --web`: a run under way as a page on this machine, with the report of what has arrived.

mod feed;
mod partial;
mod server;

pub use feed::Feed;
pub use partial::page;
pub use server::Server;

//! What a run leaves behind: its results folder while it is being filled, the manifest with its checksums, recordings,
//! and their export.

pub mod checksums;
pub mod folder;
pub mod manifest;
pub mod mcap;
pub mod recording;

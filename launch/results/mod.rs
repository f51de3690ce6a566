//! The results folder and recordings, as the launcher sees them.

pub mod checksums;
pub mod folder;
pub mod manifest;
pub mod recording;

//! What is to be drawn.

use std::path::Path;

use nodes::files::map_file::MapFile;

use crate::plan::hosts::Hosts;

/// A map that is to be drawn.
#[derive(Debug, Clone, Copy)]
pub struct Order<'a> {
    /// What is drawn.
    pub map: &'a MapFile,
    /// The folder in which its parts are kept and its files are written.
    pub folder: &'a Path,
    /// The hosts that may contribute.
    pub hosts: Option<&'a Hosts>,
    /// Whether nothing but errors is printed.
    pub is_quiet: bool,
}

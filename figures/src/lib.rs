//! The figures and the report of a results folder.
//!
//! This crate reads and writes files, and uses neither processes nor topics.
//!
//! The crate `results` reads the folder, [`drawings`] draws one kind of figure per file, and [`report`] writes the
//! page. plotters lays out areas, coordinates and ticks; [`backend`] turns what it draws into SVG elements.

pub mod atlas;
pub mod axis;
pub mod backend;
pub mod branch;
pub mod colour_map;
pub mod densities;
pub mod draw_error;
pub mod drawings;
pub mod elements;
pub mod explorer;
pub mod figure;
pub mod hamiltonian;
pub mod labels;
pub mod legend;
pub mod palette;
pub mod panel;
pub mod reliability_map;
pub mod report;
pub mod scene;
pub mod sub_domains;
pub mod text;
pub mod words;

//! A random campaign: scenarios as other people have them, each method against an oracle.
//!
//! - [`scenario`]: what is drawn, and how it is written down so that phasecloud reads it;
//! - [`paths`]: the oracle's own integrator, with the largest eccentricity on the way;
//! - [`lattice`]: orbits that fill the initial Gaussian on lines of constant solar angle, with quadrature weights;
//! - [`crossing`], [`moments`], [`bins`]: probabilities, moments and the joint density from those orbits;
//! - [`oracle`]: all of them on finer and finer lattices, with the error that the last refinement shows, and Monte Carlo;
//! - [`methods`]: the methods, called as the nodes call them;
//! - [`cases`]: scenarios of other people, with values that others worked out;
//! - [`judge`]: whether a method's figures are what it says they are;
//! - [`summary`]: the table.
//!
//! Nothing of the oracle is shared with `density::exact` or `density::first_passage`.
#![allow(dead_code)] // each target uses its share

pub mod bins;
pub mod cases;
pub mod crossing;
pub mod judge;
pub mod lattice;
pub mod methods;
pub mod moments;
pub mod oracle;
pub mod paths;
pub mod scenario;
pub mod summary;

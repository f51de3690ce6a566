//! A random campaign: scenarios of the kind that users have, with each method compared to an oracle.
//!
//! - [`scenario`]: the random scenarios, and how they are written down so that phasecloud reads them;
//! - [`paths`]: the oracle's own integrator, with the largest eccentricity on the way;
//! - [`lattice`]: orbits that fill the initial Gaussian on lines of constant solar angle, with quadrature weights;
//! - [`crossing`], [`moments`], [`bins`]: probabilities, moments and the joint density from those orbits;
//! - [`oracle`]: all of them on finer and finer lattices, with the error that the last refinement shows, and Monte
//!   Carlo;
//! - [`methods`]: the methods, called as the nodes call them;
//! - [`cases`]: scenarios of other people, with values that others worked out;
//! - [`judge`]: whether a method's figures are as accurate as it claims;
//! - [`summary`]: the table of results.
//!
//! The oracle shares no code with `density::exact` or `density::first_passage`.
#![allow(dead_code)] // each target uses only a part

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

//! What is asked of the integrator and what it tells: orbits to be moved, an observer of their steps, and why an orbit
//! is lost.

use super::accuracy::Accuracy;
use crate::lanes::{LANES, Lanes};

/// Orbits to be moved.
#[derive(Debug)]
pub struct Batch<'a, 'b> {
    /// Their states: one column per coordinate, one row per orbit.
    pub columns: &'a mut [&'b mut [f64]],
    /// Time at the start \[yr\].
    pub from: f64,
    /// Number of years by which each orbit is moved, backwards if negative. The last entry also counts for all further
    /// orbits.
    pub years: &'a [f64],
}

/// Moves orbits and returns those that were lost, which keep their states.
///
/// The largest error after two years is about 14 tolerances in a cloud of 1e5 orbits and 24 tolerances among orbits
/// four standard deviations from the mean, whatever the order. The orders are the cheapest by measurement, by a small
/// margin.
pub struct Carry<'a, 'b, 'c> {
    /// How accurately orbits are propagated.
    pub accuracy: Accuracy,
    /// The orbits.
    pub batch: Batch<'a, 'b>,
    /// The observer of every step, if there is one.
    pub watch: Option<&'c mut dyn Watch>,
}

/// An observer of the orbits on their way. The integrator calls it through a pointer: its loop would otherwise be
/// compiled once for every kind of observer, and a call costs nothing beside the step of [`LANES`] orbits.
pub trait Watch {
    /// Whether it reads the clearance.
    fn sees_clearance(&self) -> bool;

    /// Sees a step of all lanes before it is taken.
    fn see(&mut self, step: &Step<'_>);
}

/// The step that all lanes are about to take.
pub struct Step<'a> {
    /// Coefficients of a coordinate of the state, by its number.
    pub coordinate: &'a dyn Fn(usize) -> &'a [Lanes],
    /// Coefficients of the clearance.
    pub clearance: &'a [Lanes],
    /// The length of each lane's step, without a sign \[1/n_sun\].
    pub lengths: &'a Lanes,
    /// Which orbit is in which lane.
    pub crew: &'a Crew,
}

/// Which orbit is in which lane, and how far it has to go.
#[derive(Debug)]
pub struct Crew {
    pub(super) orbit: [Option<usize>; LANES],
    /// -1 for an orbit that runs backwards.
    pub(super) sign: Lanes,
    /// Time left after the step under way \[1/n_sun\].
    pub(super) left: Lanes,
    /// Number of steps that the orbit may still take.
    pub(super) steps: Lanes,
    /// Number of lanes in which there is an orbit.
    pub(super) at_work: usize,
}

/// Why an orbit could not be followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, thiserror::Error)]
pub enum Loss {
    /// It reached `e = 1` or another boundary of the model's equations of motion, or became non-finite.
    #[error("left the domain e < 1 of the equations of motion")]
    LeftTheDomain,
    /// Its steps became too short to make progress: it turns too fast, as orbits next to `e = 1` do.
    #[error("turns too fast to be followed (the integrator would need more than 2e6 steps a year)")]
    Stuck,
}

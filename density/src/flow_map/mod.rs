//! Flow maps: where every start is at every snapshot time, interpolated from a lattice of orbits.
//!
//! The flow is smooth, so a few thousand orbits determine it throughout a cloud. The map from the standardised
//! coordinates of the initial Gaussian to the state at a time is interpolated by products of Chebyshev polynomials on
//! cells, which are halved where the flow bends, until an estimate of the error is below a setting. Moving an orbit
//! then costs one evaluation of a polynomial for each snapshot, whatever the horizon.
//!
//! The domain is the box of [`Settings::reach`] standard deviations about the mean. In the plane it may hold starts
//! with a negative eccentricity: `(phi, -e)` is `(phi + π, e)`, and the state `(e sin phi, e cos phi)` is analytic
//! through `e = 0`. A start is left to direct propagation where no map is worth its orbits: outside the box, and in
//! cells that hold less probability than [`Settings::smallest_share`] and are not resolved yet, as at a separatrix,
//! where neighbours come apart for ever. Where [`Settings::most_orbits`] do not suffice, the cells that hold least are
//! left as well. [`Summary`] says how much that is, and a map that covers less than [`Settings::least_mapped`] is
//! refused.
//!
//! The error of a cell is the larger of two estimates: how far the polynomial is off at the corners and in the middle,
//! where the polynomial that interpolates at Chebyshev nodes is furthest off, compared with orbits that end there; and
//! what the next coefficients would be, if they go on to fall as the last ones do.
//!
//! | file | idea |
//! |---|---|
//! | `chebyshev` | the polynomials, their coefficients and tails, and their values at many points |
//! | `cell` | boxes and the tree of their halvings |
//! | `build` | how the cells are found |
//! | [`refused`] | why there is no map, or none of a part of the cloud |
//! | `passing` | whether and when the orbits of a cell first reach the critical value |
//! | [`draw`] | how the starts of the orbits are drawn |
//! | [`mapped`] | a set of orbits that moves by a map |
//! | `determinant` | how a map in the plane changes a density |
//! | `left` | the orbits that a map leaves to direct propagation |
//! | [`by_angle`] | in the plane: a map by action and angle, which knows all times |

mod build;
pub mod by_angle;
mod cell;
mod chebyshev;
mod determinant;
pub mod draw;
mod left;
pub mod mapped;
mod passing;
pub mod refused;
#[cfg(test)]
mod tests;

use crate::flow::Flow;
use crate::gaussian::Gaussian;
use crate::model::Model;

use cell::{Cell, Locals, Tree, UNMAPPED};
use chebyshev::Polynomial;
use passing::Passing;

pub use build::check_error;
pub use by_angle::{AngleMap, AngleOrbits};
pub use mapped::MappedOrbits;
pub use refused::{Cause, Refused, Unresolved};

/// How far the domain of a map reaches from the mean along each axis unless set, in standard deviations. Beyond lie
/// 8e-11 of a Gaussian.
pub const REACH: f64 = 6.5;

/// What a map may cost and how far it may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Largest error of a coordinate of the state.
    pub error: f64,
    /// Largest number of orbits from which the map is made.
    pub most_orbits: usize,
    /// A cell that holds less probability than this is not halved again: its starts are propagated directly.
    pub smallest_share: f64,
    /// Least probability that a map must cover.
    pub least_mapped: f64,
    /// How far the domain reaches from the mean along each axis, in standard deviations. With many variables it holds
    /// mostly starts that no cloud has, and a smaller one takes far fewer orbits.
    pub reach: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { error: 1e-9, most_orbits: 300_000, smallest_share: 1e-5, least_mapped: 0.5, reach: REACH }
    }
}

/// What a map is made of and how far it is off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    /// Number of orbits propagated.
    pub orbits: usize,
    /// Number of cells with a map.
    pub cells: usize,
    /// Number of coefficients, of all cells and snapshots.
    pub coefficients: usize,
    /// Estimate of the largest error of a coordinate of a state, in any cell at any snapshot.
    pub error: f64,
    /// Estimate of the largest error of an interpolated passage time \[yr\].
    pub passage_error: f64,
    /// Probability of the cells with a map; of the uncut Gaussian.
    pub mapped: f64,
    /// The most probable cell without a map, if there is one.
    pub unresolved: Option<Unresolved>,
}

/// The map of one cell.
#[derive(Debug, Clone)]
struct CellMap<const N: usize> {
    cell: Cell<N>,
    locals: Locals<N>,
    /// The coordinates of the state at each snapshot after the first time, one snapshot after the other.
    states: Vec<Polynomial<N>>,
    passing: Passing<N>,
}

/// The map from the starts of a cloud to their states at the snapshot times.
#[derive(Debug, Clone)]
pub struct FlowMap<M, const N: usize> {
    /// Propagates the orbits that are in no cell.
    flow: Flow<M>,
    gaussian: Gaussian<N>,
    times: Vec<f64>,
    tree: Tree<N>,
    cells: Vec<CellMap<N>>,
    summary: Summary,
}

impl Summary {
    /// That of a map of which nothing has been made yet.
    fn empty() -> Self {
        Self { orbits: 0, cells: 0, coefficients: 0, error: 0.0, passage_error: 0.0, mapped: 0.0, unresolved: None }
    }

    /// Refuses a map that covers too little.
    fn check(&self, settings: &Settings) -> Result<(), Refused> {
        match self.unresolved {
            Some(unresolved) if self.mapped < settings.least_mapped => {
                let (orbits, mapped, least) = (self.orbits, self.mapped, settings.least_mapped);
                Err(Refused::CoversTooLittle { orbits, mapped, least, unresolved: Box::new(unresolved) })
            }
            _ => Ok(()),
        }
    }
}

impl<M: Model, const N: usize> FlowMap<M, N> {
    /// The map by `flow` of the cloud that starts as `gaussian` over the model's variables, to each of the ascending
    /// `times` \[yr\], the first of which is the start. With a critical value of the re-entry variable it also knows
    /// first passages. The accuracy of `flow` is that of orbits which the map leaves to direct propagation; those from
    /// which the map is made are ten times more accurate than it.
    ///
    /// # Errors
    /// [`Refused`] if the setting is finer than the orbits, or if the flow bends too much.
    ///
    /// # Panics
    /// If the model has not `N` variables, or if there are no times.
    pub fn new(
        flow: Flow<M>,
        gaussian: Gaussian<N>,
        times: &[f64],
        critical: Option<f64>,
        settings: &Settings,
    ) -> Result<Self, Refused> {
        assert_eq!(M::VARIABLES.len(), N, "a Gaussian over the model's variables");
        build::Builder::new(flow, gaussian, times, critical, settings)?.map()
    }

    /// What the map is made of and how far it is off.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// The snapshot times \[yr\].
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The cell of the start with these variables, and its local coordinates; `None` if it has to be propagated
    /// directly.
    fn locate(&self, variables: &[f64; N]) -> Option<(u32, [f64; N])> {
        let point = self.gaussian.standardise(variables);
        match self.tree.locate(&point) {
            UNMAPPED => None,
            cell => Some((cell, self.cells[cell as usize].locals.of(&point))),
        }
    }

    /// The polynomials of a cell at a snapshot after the first.
    fn states(&self, cell: u32, index: usize) -> &[Polynomial<N>] {
        let states = &self.cells[cell as usize].states;
        let count = states.len() / (self.times.len() - 1);
        &states[(index - 1) * count..index * count]
    }

    /// The coordinates of the state at snapshot `index` of the orbit that starts with these variables; `None` if it has
    /// to be propagated directly.
    ///
    /// # Panics
    /// If there is no such snapshot.
    pub fn state(&self, variables: &[f64; N], index: usize) -> Option<M::State<f64>> {
        use crate::model::Coordinates;
        let (cell, local) = self.locate(variables)?;
        if index == 0 {
            return Some(self.flow.model.state(self.times[0], Coordinates::from_fn(|k| variables[k])));
        }
        let states = self.states(cell, index);
        Some(Coordinates::from_fn(|k| states[k].at(&local)))
    }
}

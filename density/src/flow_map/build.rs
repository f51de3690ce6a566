//! How the cells of a map are found: level by level, a cell is fitted and kept, halved, or given up.

use rayon::prelude::*;

use super::cell::{Cell, Tree};
use super::chebyshev::{Basis, Polynomial};
use super::passing::{self, Decision, Passing, TIME_ERROR};
use super::refused::{Cause, Limit, rounded_place};
use super::{CellMap, FlowMap, Refused, Settings, Summary, Unresolved};
use crate::flow::{Accuracy, Flow};
use crate::gaussian::Gaussian;
use crate::model::{Coordinates, Model};

/// Orbits are this much more accurate than the map.
const FINER: f64 = 10.0;
/// Coefficients below this share of the error are left out, divided by the number of nodes along an axis.
const NEGLIGIBLE: f64 = 0.05;

/// The accuracy of the orbits from which a map with this error is made that reaches so many years.
///
/// # Errors
/// [`Refused::TooFine`] if no orbits are that accurate.
pub(super) fn accuracy_for(error: f64, years: f64) -> Result<Accuracy, Refused> {
    // The error of an orbit grows about linearly with time; `Accuracy` states it after two years.
    let of_orbits = |accuracy: Accuracy| accuracy.largest_error() * (0.5 * years).max(1.0);
    let fits = |&accuracy: &Accuracy| FINER * of_orbits(accuracy) <= error;
    let of_finest = of_orbits(Accuracy::Fine);
    let too_fine = Refused::TooFine { error, of_orbits: of_finest, years, least: FINER * of_finest };
    Accuracy::ALL.into_iter().find(fits).ok_or(too_fine)
}

/// Checks that there can be a map with this error that reaches so many years.
///
/// # Errors
/// [`Refused::TooFine`] if no orbits are accurate enough.
pub fn check_error(error: f64, years: f64) -> Result<(), Refused> {
    accuracy_for(error, years).map(drop)
}

/// The same for a map that knows first passages, if it does: their times are smooth functions of the start only as far
/// as the orbits are accurate.
fn accuracy_of(error: f64, years: f64, has_passages: bool) -> Result<Accuracy, Refused> {
    let of_states = accuracy_for(error, years)?;
    Ok(if has_passages { accuracy_for(error.min(TIME_ERROR), years).unwrap_or(Accuracy::Fine) } else { of_states })
}

/// What a map is made from.
pub(super) struct Builder<'a, M, const N: usize> {
    /// The flow of the orbits that are propagated directly.
    direct: Flow<M>,
    /// The flow of the orbits from which the map is made.
    flow: Flow<M>,
    gaussian: Gaussian<N>,
    times: &'a [f64],
    critical: Option<f64>,
    settings: &'a Settings,
    basis: Basis,
    /// The points of a cell at which orbits start, in local coordinates: the nodes, then the corners and the middle.
    points: Vec<[f64; N]>,
}

/// What a try to fit a cell came to.
enum Fit<const N: usize> {
    Fitted { states: Vec<Polynomial<N>>, passing: Passing<N>, error: f64, passage_error: f64 },
    Unfitted { axis: usize, cause: Cause },
}

/// A leaf of the tree that is to be fitted.
type Leaf<const N: usize> = (usize, Cell<N>);

impl<'a, M: Model, const N: usize> Builder<'a, M, N> {
    /// Checks what is asked for.
    pub fn new(
        flow: Flow<M>,
        gaussian: Gaussian<N>,
        times: &'a [f64],
        critical: Option<f64>,
        settings: &'a Settings,
    ) -> Result<Self, Refused> {
        let accuracy = accuracy_of(settings.error, times[times.len() - 1], critical.is_some())?;
        let basis = Basis::of(N);
        let corner = |number: usize| std::array::from_fn(|k| if number >> k & 1 == 0 { -1.0 } else { 1.0 });
        let nodes = (0..basis.len::<N>()).map(|i| basis.node(i));
        let points = nodes.chain((0..1 << N).map(corner)).chain([[0.0; N]]).collect();
        Ok(Self { direct: flow, flow: Flow { accuracy, ..flow }, gaussian, times, critical, settings, basis, points })
    }

    /// Finds the cells.
    pub fn map(self) -> Result<FlowMap<M, N>, Refused> {
        let whole = Cell::around_the_mean(self.settings.reach);
        let (mut tree, mut cells) = (Tree::new(whole), Vec::new());
        let mut summary = Summary::empty();
        let mut level: Vec<Leaf<N>> = vec![(0, whole)];
        while !level.is_empty() {
            let fits: Vec<Fit<N>> = level.par_iter().map(|(_, cell)| self.fit(cell)).collect();
            summary.orbits += fits.len() * self.points.len();
            let mut bent = Vec::new();
            for ((leaf, cell), fit) in level.into_iter().zip(fits) {
                match fit {
                    Fit::Fitted { states, passing, error, passage_error } => {
                        tree.assign(leaf, cells.len());
                        summary.error = summary.error.max(error);
                        summary.passage_error = summary.passage_error.max(passage_error);
                        summary.mapped += cell.probability();
                        summary.coefficients += states.iter().map(Polynomial::len).sum::<usize>();
                        cells.push(CellMap { locals: cell.locals(), cell, states, passing });
                    }
                    Fit::Unfitted { axis, cause } => bent.push(((leaf, cell), axis, cause)),
                }
            }
            level = self.halve(&mut tree, &mut summary, bent);
        }
        summary.cells = cells.len();
        summary.check(self.settings)?;
        let Self { direct, gaussian, times, .. } = self;
        Ok(FlowMap { flow: direct, gaussian, times: times.to_vec(), tree, cells, summary })
    }

    /// Halves the cells that are worth it, the most probable first, as far as orbits are left; the others are given up.
    fn halve(&self, tree: &mut Tree<N>, summary: &mut Summary, mut bent: Vec<(Leaf<N>, usize, Cause)>) -> Vec<Leaf<N>> {
        bent.sort_by(|((_, a), ..), ((_, b), ..)| b.probability().total_cmp(&a.probability()));
        let mut orbits_left = self.settings.most_orbits.saturating_sub(summary.orbits);
        let mut level = Vec::new();
        for ((leaf, cell), axis, cause) in bent {
            let (share, cost) = (cell.probability(), 2 * self.points.len());
            let is_worth_it = share > self.settings.smallest_share;
            if is_worth_it && cost <= orbits_left {
                orbits_left -= cost;
                level.extend(tree.halve(leaf, &cell, axis));
            } else if summary.unresolved.is_none_or(|found| found.share < share) {
                let middle = self.gaussian.point(cell.point(&[0.0; N]));
                let place = rounded_place(M::VARIABLES, |k| middle[k]);
                let limit = if is_worth_it { Limit::Orbits } else { Limit::Share };
                summary.unresolved = Some(Unresolved { place, share, cause, limit });
            }
        }
        level
    }

    /// Propagates the orbits of a cell and interpolates between them, until a snapshot shows that the cell is too
    /// large.
    fn fit(&self, cell: &Cell<N>) -> Fit<N> {
        let nodes = self.basis.len::<N>();
        let (mut columns, mut times, mut lowest) = self.start(cell);
        let (mut states, mut largest) = (Vec::new(), 0.0f64);
        for interval in self.times.windows(2) {
            self.carry(&mut columns, (interval[0], interval[1]), &mut times, &mut lowest);
            let (mut error, mut tails) = (0.0f64, [0.0f64; N]);
            for column in &columns {
                let mut coefficients = column[..nodes].to_vec();
                self.basis.transform::<N>(&mut coefficients);
                let negligible = NEGLIGIBLE * self.settings.error / self.basis.count as f64;
                let polynomial = Polynomial::new(&self.basis, &coefficients, negligible);
                let found = self.basis.tails::<N>(&coefficients);
                let next: f64 = found.iter().map(|tail| tail.next).sum();
                (0..N).for_each(|k| tails[k] = tails[k].max(found[k].last));
                error = error.max(next).max(self.checked(&polynomial, column));
                states.push(polynomial);
            }
            if error.is_nan() || error > self.settings.error {
                let axis = (0..N).max_by(|&a, &b| tails[a].total_cmp(&tails[b])).unwrap_or(0);
                // Where an orbit was lost, no axis is worse than another: the longer side is halved.
                let axis = if tails[axis].is_finite() { axis } else { cell.longest_axis() };
                return Fit::Unfitted { axis, cause: Cause::Bends { years: interval[1], error } };
            }
            largest = largest.max(error);
        }
        let error = largest;
        let Some(critical) = self.critical else {
            return Fit::Fitted { states, passing: Passing::Unasked, error, passage_error: 0.0 };
        };
        let critical = self.flow.model.critical_clearance(critical);
        let orbits = passing::Orbits { times: &times, lowest: &lowest, critical, checks: &self.points[nodes..] };
        match orbits.decide(&self.basis) {
            Decision::Known(passing, passage_error) => Fit::Fitted { states, passing, error, passage_error },
            Decision::Halve(axis) => Fit::Unfitted { axis, cause: Cause::FirstPassages },
        }
    }

    /// The columns of the states at the start, when each orbit has passed, and its least clearance.
    fn start(&self, cell: &Cell<N>) -> (Vec<Vec<f64>>, Vec<f64>, Vec<f64>) {
        let mut columns = vec![Vec::with_capacity(self.points.len()); M::State::<f64>::COUNT];
        for local in &self.points {
            let variables = self.gaussian.point(cell.point(local));
            let state = self.flow.model.state(self.times[0], Coordinates::from_fn(|k| variables[k]));
            columns.iter_mut().enumerate().for_each(|(k, column)| column.push(state.component(k)));
        }
        (columns, vec![f64::INFINITY; self.points.len()], vec![f64::INFINITY; self.points.len()])
    }

    fn carry(&self, columns: &mut [Vec<f64>], interval: (f64, f64), times: &mut [f64], lowest: &mut [f64]) {
        let mut columns: Vec<&mut [f64]> = columns.iter_mut().map(Vec::as_mut_slice).collect();
        match self.critical {
            Some(critical) => self.flow.carry_approaching(&mut columns, interval, critical, times, lowest),
            None => self.flow.carry_where_possible(&mut columns, interval.0, interval.1),
        }
    }

    /// How far a polynomial is off at the corners and in the middle.
    fn checked(&self, polynomial: &Polynomial<N>, column: &[f64]) -> f64 {
        let nodes = self.basis.len::<N>();
        let off = |(local, value): (&[f64; N], &f64)| (polynomial.at(local) - value).abs();
        let worse = |most: f64, off: f64| if off.is_nan() { f64::INFINITY } else { most.max(off) };
        self.points[nodes..].iter().zip(&column[nodes..]).map(off).fold(0.0, worse)
    }
}

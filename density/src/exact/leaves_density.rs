//! The density at points where the radiation parameter is uncertain.
//!
//! At a point the density is `∫ n_z(phi, e) w(z) dz`, and each leaf's density `n_z` follows from the orbit that ends
//! there, carried back to the start. As a function of `z` it is a bump as the leaf's cloud passes over the point, and a
//! narrow one where the parameter matters more than the start. The start of that orbit, however, moves smoothly with
//! `z`. So orbits are carried back for evenly spaced leaves only, and between two leaves the start follows by a
//! polynomial of degree 5 through the nearest six; the density along that curve is integrated by Gauss-Legendre rules
//! on pieces of about two standard deviations. The same with polynomials one degree lower says how good it is.
//!
//! The Hamiltonian, which is constant along an orbit, says for which leaves a point may hold a part of the cloud at
//! all.

use std::ops::{Range, RangeInclusive};
use std::sync::OnceLock;

use rayon::prelude::*;

use crate::flow::{Accuracy, Flow};
use crate::model::PlanarHamiltonian;
use crate::model::plane::State;
use crate::model::registry::Planar;
use crate::uncertain::UncertainProblem;

use super::hamiltonian_range::{HamiltonianRange, range_within};
use super::measure::{Measure, normal_density};
use super::rules::gauss;

/// Standard deviations of start and parameter together beyond which the cloud counts as empty: 2e-6 of it lie there.
const REACH: f64 = 5.5;
/// Steps of `z` at the coarsest level; every level has twice as many as the one before.
const COARSEST_STEPS: usize = 11;
/// Number of levels.
pub(super) const LEVELS: usize = 6;
/// Leaves through which a polynomial goes.
const NODES: usize = 6;
/// Length of a piece of the curve of starts for one rule, in standard deviations.
const PIECE: f64 = 2.0;
/// Largest number of pieces between two leaves.
const MOST_PIECES: f64 = 64.0;

/// The leaves that are carried, and what all points need to know of them.
#[derive(Debug)]
pub(super) struct Leaves<'a> {
    problem: &'a UncertainProblem,
    years: f64,
    measure: Measure,
    levels: [OnceLock<Level>; LEVELS],
}

/// Evenly spaced leaves.
#[derive(Debug)]
struct Level {
    step: f64,
    leaves: Vec<CarriedLeaf>,
}

/// A leaf whose orbits are carried back: its value of the parameter, and on which orbits its cloud lies.
#[derive(Debug)]
struct CarriedLeaf {
    z: f64,
    /// `None` where the parameter is out of the range of the model.
    of_cloud: Option<(Planar, HamiltonianRange)>,
}

/// The density at points.
#[derive(Debug, Default)]
pub(super) struct Values {
    pub density: Vec<f64>,
    /// What polynomials one degree lower change.
    pub difference: Vec<f64>,
    /// Number of orbits followed.
    pub orbits: usize,
}

impl<'a> Leaves<'a> {
    pub fn new(problem: &'a UncertainProblem, years: f64) -> Self {
        Self { problem, years, measure: Measure::new(problem.plane.initial), levels: Default::default() }
    }

    fn level(&self, level: usize) -> &Level {
        self.levels[level].get_or_init(|| {
            let lowest = self.problem.lowest().max(-REACH);
            let steps = COARSEST_STEPS << level;
            let step = (REACH - lowest) / steps as f64;
            let leaf = |k: usize| {
                let z = lowest + step * k as f64;
                let radius = (REACH * REACH - z * z).max(0.0).sqrt();
                let of_cloud = self.problem.leaf(z).map(|leaf| {
                    let range = range_within(&leaf.model, &self.measure, radius);
                    (leaf.model, range)
                });
                CarriedLeaf { z, of_cloud }
            };
            Level { step, leaves: (0..=steps).into_par_iter().map(leaf).collect() }
        })
    }

    /// The density at points `(phi, e)`, from the leaves of this level.
    pub fn density(&self, points: &[(f64, f64)], level: usize) -> Values {
        let level = self.level(level);
        let inside = |&(_, e): &(f64, f64)| e > 0.0 && e < 1.0;
        let ends: Vec<Option<State>> =
            points.iter().map(|point| inside(point).then(|| State::from_polar(point.0, point.1))).collect();
        let spans: Vec<Vec<usize>> =
            ends.par_iter().map(|end| end.map_or(Vec::new(), |end| level.spans(end))).collect();
        let starts: Vec<(Vec<u32>, Vec<State>)> =
            (0..level.leaves.len()).into_par_iter().map(|k| self.carry_back(level, k, &ends, &spans)).collect();
        let orbits = starts.iter().map(|(points, _)| points.len()).sum();
        let mut by_point = vec![Vec::new(); points.len()];
        for (k, (points, states)) in starts.iter().enumerate() {
            points.iter().zip(states).for_each(|(&point, &state)| by_point[point as usize].push((k, state)));
        }
        let at = |point: usize| {
            let end = ends[point].filter(|_| !spans[point].is_empty());
            end.map_or([0.0; 2], |end| self.integral(level, end, &spans[point], &by_point[point]))
        };
        let found: Vec<[f64; 2]> = (0..points.len()).into_par_iter().map(at).collect();
        let difference = found.iter().map(|[value, rougher]| (value - rougher).abs()).collect();
        Values { density: found.into_iter().map(|[value, _]| value).collect(), difference, orbits }
    }

    /// The starts of the orbits of leaf `k` that end at those points for which it is needed.
    fn carry_back(
        &self,
        level: &Level,
        k: usize,
        ends: &[Option<State>],
        spans: &[Vec<usize>],
    ) -> (Vec<u32>, Vec<State>) {
        let Some((model, _)) = level.leaves[k].of_cloud else { return Default::default() };
        let last = level.leaves.len() - 1;
        let is_needed = |spans: &[usize]| spans.iter().any(|&span| nodes(span, last).contains(&k));
        let needed = (0u32..).zip(ends).zip(spans).filter(|(_, spans)| is_needed(spans));
        let (points, ends): (Vec<u32>, Vec<State>) =
            needed.filter_map(|((point, end), _)| end.map(|end| (point, end))).unzip();
        let (mut x1, mut x2): (Vec<f64>, Vec<f64>) = ends.iter().map(|state| (state.x1, state.x2)).unzip();
        Flow { model, accuracy: Accuracy::Coarse }.advance_where_possible(&mut x1, &mut x2, -self.years);
        (points, x1.into_iter().zip(x2).map(|(x1, x2)| State { x1, x2 }).collect())
    }

    /// The density at `end`, and by polynomials one degree lower.
    fn integral(&self, level: &Level, end: State, spans: &[usize], starts: &[(usize, State)]) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for &span in spans {
            let Some(curve) = Curve::through(starts, span) else { continue };
            let z = level.leaves[span].z;
            for piece in self.pieces(&curve) {
                for (t, weight) in gauss(piece.start, piece.end) {
                    let share = weight * normal_density(z + level.step * t);
                    for (sum, start) in sum.iter_mut().zip(curve.at(t)) {
                        *sum += share * self.measure.density_after(start, end);
                    }
                }
            }
        }
        sum.map(|sum| sum * level.step / self.problem.mass_inside())
    }

    /// The pieces of a curve of starts that are integrated apart; those far from the cloud are left out.
    fn pieces(&self, curve: &Curve) -> Vec<Range<f64>> {
        let standard = |t: f64| {
            let [start, _] = curve.at(t);
            self.measure.standardise(start.solar_angle(), start.eccentricity())
        };
        let length = |a: (f64, f64), b: (f64, f64)| {
            let along = (a.0 - b.0).abs() % self.measure.turn();
            along.min(self.measure.turn() - along).hypot(a.1 - b.1)
        };
        let nearest = |a: (f64, f64), b: (f64, f64)| a.0.hypot(a.1).min(b.0.hypot(b.1));
        let (first, last) = (standard(0.0), standard(1.0));
        let whole = length(first, last);
        if nearest(first, last) > REACH + 1.0 + whole {
            return Vec::new();
        }
        let count = (whole / PIECE).ceil().clamp(1.0, MOST_PIECES) as usize;
        if count == 1 {
            return vec![0.0..1.0];
        }
        let edge = |k: usize| k as f64 / count as f64;
        let edges: Vec<(f64, f64)> = (0..=count).map(|k| standard(edge(k))).collect();
        let is_near = |k: &usize| nearest(edges[*k], edges[k + 1]) <= REACH + length(edges[*k], edges[k + 1]);
        (0..count).filter(is_near).map(|k| edge(k)..edge(k + 1)).collect()
    }
}

impl Level {
    /// The intervals between two leaves in which a point may hold a part of the cloud, by the number of their first
    /// leaf.
    fn spans(&self, end: State) -> Vec<usize> {
        const MARGIN: f64 = 1e-9;
        // -1 below the orbits of the cloud, 1 above them.
        let side = |leaf: &CarriedLeaf| {
            let (model, range) = leaf.of_cloud?;
            let hamiltonian = model.hamiltonian(end);
            Some(i32::from(hamiltonian > range.high + MARGIN) - i32::from(hamiltonian < range.low - MARGIN))
        };
        let sides: Vec<Option<i32>> = self.leaves.iter().map(side).collect();
        let meets = |k: &usize| matches!((sides[*k], sides[k + 1]), (Some(a), Some(b)) if a * b <= 0);
        (0..self.leaves.len() - 1).filter(meets).collect()
    }
}

/// The leaves through which the polynomial between leaves `span` and `span + 1` goes.
fn nodes(span: usize, last: usize) -> RangeInclusive<usize> {
    let before = NODES / 2 - 1;
    let first = span.saturating_sub(before).min((last + 1).saturating_sub(NODES));
    first..=(first + NODES - 1).min(last)
}

/// The start of an orbit as a function of `z`, between two leaves.
#[derive(Debug)]
struct Curve {
    /// The leaves of the nodes, counted from the first one of the interval.
    nodes: Vec<f64>,
    /// Divided differences of the two coordinates, in Newton's form.
    coefficients: Vec<[f64; 2]>,
}

impl Curve {
    /// Through the starts that are known, of leaves next to one another; `None` if one of the two leaves has none.
    fn through(starts: &[(usize, State)], span: usize) -> Option<Self> {
        let is_known = |at: usize| starts.get(at).is_some_and(|(_, state)| !state.x1.is_nan());
        let middle = starts.binary_search_by_key(&span, |(k, _)| *k).ok()?;
        let is_next = |a: usize, b: usize| is_known(a) && is_known(b) && starts[b].0 == starts[a].0 + 1;
        if !is_next(middle, middle + 1) {
            return None;
        }
        let (mut first, mut last) = (middle, middle + 1);
        while last + 1 - first < NODES {
            let can = (first > 0 && is_next(first - 1, first), is_next(last, last + 1));
            match can {
                (true, below) if !below || middle - first < last - middle => first -= 1,
                (_, true) => last += 1,
                _ => break,
            }
        }
        let known = &starts[first..=last];
        let nodes: Vec<f64> = known.iter().map(|(k, _)| *k as f64 - span as f64).collect();
        let mut coefficients: Vec<[f64; 2]> = known.iter().map(|(_, state)| [state.x1, state.x2]).collect();
        for order in 1..nodes.len() {
            for i in (order..nodes.len()).rev() {
                let width = nodes[i] - nodes[i - order];
                coefficients[i] = std::array::from_fn(|c| (coefficients[i][c] - coefficients[i - 1][c]) / width);
            }
        }
        Some(Self { nodes, coefficients })
    }

    /// The start at a share of the interval, and that by a polynomial one degree lower.
    fn at(&self, t: f64) -> [State; 2] {
        let (mut value, mut lower, mut product) = ([0.0; 2], [0.0; 2], 1.0);
        for (node, coefficient) in self.nodes.iter().zip(&self.coefficients) {
            lower = value;
            value = std::array::from_fn(|c| value[c] + coefficient[c] * product);
            product *= t - node;
        }
        [value, lower].map(|[x1, x2]| State { x1, x2 })
    }
}

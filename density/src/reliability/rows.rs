//! Rows of a map: scenarios that differ in the radiation parameter and its uncertainty alone share one table of
//! figures.

use crate::exact::Estimated;
use crate::model::registry::Planar;
use crate::problem::Problem;
use crate::uncertain::{Distribution, Spread, UncertainProblem};

use super::UNKNOWN;
use super::by_orbits::{Asked, ByOrbits};
use super::by_radiation::{ByRadiation, Range};
use super::cloud::Cloud;
use super::quantity::Quantity;
use super::required::{error_at, factor_for};

/// Distance in standard deviations out to which the radiation parameter is followed; the probability beyond is 2e-9.
const REACH: f64 = 6.0;
/// Smallest radiation parameter of a table, as a share of the largest one.
const SMALLEST: f64 = 1e-4;
/// Largest distance between values of the radiation parameter in a table, as a share.
const COARSEST: f64 = 0.1;

/// A point of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// The problem, with the mean of the radiation parameter.
    pub problem: Problem<Planar>,
    /// How uncertain that parameter is, if it is.
    pub spread: Option<Spread>,
}

/// The quantity at points that differ in their radiation parameters and spreads alone, to about `tolerance`: a table of
/// the figures over the radiation parameters of all of them, and from it each point.
pub type Row = Vec<Estimated>;

/// Whether two points share a table.
pub fn are_alike(one: &Point, other: &Point) -> bool {
    let distribution = |point: &Point| point.spread.map(|spread| spread.distribution);
    let moved = one.problem.model.value("radiation").and_then(|c| other.problem.model.with("radiation", c).ok());
    moved == Some(one.problem.model)
        && distribution(one) == distribution(other)
        && (one.problem.initial, one.problem.critical_e) == (other.problem.initial, other.problem.critical_e)
}

/// The quantity at each of the points of a row, which must be alike ([`are_alike`]).
pub fn evaluate(row: &[Point], quantity: Quantity, tolerance: f64) -> Row {
    let radiation = |point: &Point| point.problem.model.value("radiation").unwrap_or(0.0);
    let Some(first) = row.first() else { return Row::new() };
    let figures = |c: f64| {
        let model = first.problem.model.with("radiation", c).ok()?;
        quantity.figures(&Problem { model, ..first.problem.clone() }, 0.2 * tolerance)
    };
    let needs_no_table =
        |point: &Point| radiation(point) == 0.0 || (point.spread.is_none() && quantity.factors() == (1.0, 1.0));
    let certain = |point: &Point| {
        // Without radiation pressure a factor on it has no effect.
        let found = figures(radiation(point)).unwrap_or(vec![UNKNOWN; quantity.count()]);
        if quantity.factors() == (1.0, 1.0) { quantity.of(&found) } else { UNKNOWN }
    };
    if row.iter().all(needs_no_table) {
        use rayon::prelude::*;
        return row.par_iter().map(certain).collect();
    }
    let acting: Vec<&Point> = row.iter().filter(|point| radiation(point) > 0.0).collect();
    let range = range(&acting, quantity, tolerance);
    if let Some(found) = years_of_orbits(row, quantity, tolerance).and_then(|years| {
        with_orbits(row, quantity, tolerance, Asked { ends: range.ends, narrowest: range.narrowest, years })
    }) {
        return found;
    }
    let distribution = first.spread.map_or(Distribution::LogNormal, |spread| spread.distribution);
    let table = ByRadiation::new(distribution, range, quantity.count(), figures);
    let figures = |point: &Point, factor: f64| match uncertain(point, factor) {
        Some(problem) => table.means(&problem, 1.0),
        None => table.at(factor * radiation(point)),
    };
    let at = |point: &Point| match needs_no_table(point) {
        true => certain(point),
        false => of_point(quantity, |factor| figures(point, factor)),
    };
    row.iter().map(at).collect()
}

/// The quantity at each point by a sample of orbits; none if one of them cannot be followed.
fn with_orbits(row: &[Point], quantity: Quantity, tolerance: f64, asked: Asked) -> Option<Row> {
    let first = row.first()?;
    let cloud = Cloud::in_plane(&first.problem, first.spread).ok()?;
    let probability = |orbits: &ByOrbits, point: &Point, factor: f64| {
        orbits.probability(factor * point.problem.model.value("radiation").unwrap_or(0.0), point.spread)
    };
    let error = |orbits: &ByOrbits| {
        let at = |point: &Point| error_at(quantity, |factor| probability(orbits, point, factor));
        row.iter().map(at).fold(0.0, f64::max)
    };
    let orbits = ByOrbits::new(&cloud, asked, tolerance, error);
    let of = |point| of_point(quantity, |factor| vec![probability(&orbits, point, factor)]);
    (orbits.lost() == 0).then(|| row.iter().map(of).collect())
}

/// The years within which passages are asked for, if a sample of orbits answers well enough: where the parameter of
/// every point is uncertain.
fn years_of_orbits(row: &[Point], quantity: Quantity, tolerance: f64) -> Option<f64> {
    let is_uncertain = |point: &Point| point.spread.is_some_and(|spread| spread.relative >= NARROWEST_OF_ORBITS);
    let are_enough = tolerance >= FINEST_OF_ORBITS && row.iter().all(is_uncertain);
    match quantity {
        Quantity::Reentry { within } | Quantity::RequiredFactor { within, .. } if are_enough => Some(within),
        _ => None,
    }
}

/// Narrowest relative deviation of the radiation parameter that makes the probability smooth enough for a sample of
/// orbits, and the finest tolerance for which a sample takes less time than the exact curve.
const NARROWEST_OF_ORBITS: f64 = 0.02;
const FINEST_OF_ORBITS: f64 = 5e-4;

/// The radiation parameters of all these points, as far as their figures matter.
fn range(points: &[&Point], quantity: Quantity, tolerance: f64) -> Range {
    let (least, most) = quantity.factors();
    let ends = points.iter().map(|point| {
        let mean = point.problem.model.value("radiation").unwrap_or(0.0);
        match uncertain(point, 1.0) {
            Some(problem) => (least * problem.radiation(problem.lowest().max(-REACH)), most * problem.radiation(REACH)),
            None => (least * mean, most * mean),
        }
    });
    let (low, high) = ends.fold((f64::INFINITY, 0.0f64), |(low, high), (a, b)| (low.min(a), high.max(b)));
    let spreads = points.iter().map(|point| point.spread.map_or(0.0, |spread| spread.relative));
    let narrowest = spreads.fold(f64::INFINITY, f64::min);
    // A mean is over some twenty distances of values; each point of a certain parameter has one.
    let tolerance = if narrowest > 0.0 { 0.05 * tolerance } else { 0.3 * tolerance };
    Range { ends: (low.max(SMALLEST * high), high), coarsest: COARSEST, tolerance, narrowest }
}

/// The problem of a point whose radiation parameter is `factor` times as large and uncertain.
fn uncertain(point: &Point, factor: f64) -> Option<UncertainProblem> {
    let model = point.problem.model;
    let model = model.with("radiation", factor * model.value("radiation")?).ok()?;
    Some(UncertainProblem { plane: Problem { model, ..point.problem.clone() }, spread: point.spread? })
}

/// The quantity at a point, of which `figures` gives the figures for a factor on the radiation parameter.
fn of_point(quantity: Quantity, figures: impl Fn(f64) -> Vec<Estimated>) -> Estimated {
    match quantity {
        Quantity::RequiredFactor { probability, .. } => factor_for(probability, |factor| figures(factor)[0]),
        _ => quantity.of(&figures(1.0)),
    }
}

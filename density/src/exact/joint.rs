//! The joint density on the comparison grid as exact bin averages.
//!
//! Every orbit is followed once round, from grid line to grid line. What lies between two of them is in one bin, and its
//! probability is that of the same arc `t` earlier on the orbit, a difference of a function that only grows
//! ([`super::share`]). So bins get positive probabilities that add up to that of the cloud, however thin it has been wound, and
//! the only error is that of the integral over the orbits: the difference between its two rules, bin by bin.

use rayon::prelude::*;

use crate::angle::nearest;
use crate::grid::Grid;
use crate::model::plane::{PlanarHamiltonian, State};

use super::contour::angle_of;
use super::crossings::{Piece, pieces};
use super::family::{Family, Interval, Orbit, worst};
use super::measure::Measure;
use super::rules::POINTS;

/// Bin averages of the joint density and what is known of their error.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Mean density in each bin \[1/rad\], `phi` outermost.
    pub density: Vec<f64>,
    /// Estimate of the L1 error of `density`.
    pub error: f64,
    /// Probability outside the grid.
    pub mass_outside: f64,
    /// Orbits followed.
    pub orbits: usize,
}

/// An interval of orbits with what it brings to each bin.
struct Leaf {
    interval: Interval,
    /// Bin (the number of bins for all that is outside the grid), probability by the Kronrod rule.
    masses: Vec<(u32, f64)>,
    /// Sum over the bins of the difference between the two rules.
    error: f64,
}

/// Backward orbits of one turn that the way by blocks may take for each orbit that the other may: an orbit of the latter costs
/// as much as so many.
const BACKWARD: f64 = 4.0;
/// Orbits that check the way by blocks.
const CHECKING: usize = 1_000;

/// The joint density after `years` on `grid`, to an L1 error of about `tolerance` unless that takes more than `most_orbits`.
///
/// While the cloud is not wound up, blocks of bins with a polynomial each ([`super::by_blocks`]) are the cheaper way. What they
/// say is taken only if a few orbits, followed from line to line, say the same within their error.
pub(super) fn joint(
    family: &Family<'_, impl PlanarHamiltonian>,
    grid: &Grid,
    years: f64,
    tolerance: f64,
    most_orbits: usize,
) -> Joint {
    if years == 0.0 {
        return at_start(&family.measure, grid);
    }
    let most_backward = (BACKWARD * most_orbits as f64 / turns(&family.flow.model, grid, years).max(1.0)) as usize;
    let coarse = by_orbits(family, grid, years, tolerance, CHECKING.min(most_orbits));
    if coarse.error <= tolerance {
        return coarse;
    }
    match super::by_blocks::joint(family.flow, &family.measure, grid, years, tolerance, most_backward) {
        Some(joint) if joint.error <= tolerance && joint.agrees_with(&coarse, grid) => joint,
        _ => by_orbits(family, grid, years, tolerance, most_orbits),
    }
}

/// Turns of the fastest orbit on the grid in so many years, about: an integrator's steps are proportional to them.
fn turns(model: &impl PlanarHamiltonian, grid: &Grid, years: f64) -> f64 {
    years * model.turning_rate(State { x1: 0.0, x2: grid.e.high }).max(1.0)
}

impl Joint {
    /// Whether another joint density is the same within both error estimates.
    fn agrees_with(&self, other: &Self, grid: &Grid) -> bool {
        let apart: f64 = self.density.iter().zip(&other.density).map(|(a, b)| (a - b).abs() * grid.bin_area()).sum();
        let outside = (self.mass_outside - other.mass_outside).abs();
        apart + outside <= 2.0 * (self.error + other.error)
    }
}

/// The initial Gaussian itself, from its distribution functions.
fn at_start(measure: &Measure, grid: &Grid) -> Joint {
    let (phi, e) = (&grid.phi, &grid.e);
    // On the mean's own turn of the circle.
    let shift = nearest(phi.low, measure.gaussian.mean_phi) - phi.low;
    let between = |i: usize| measure.phi_between(phi.edge(i) + shift, phi.edge(i + 1) + shift);
    let columns: Vec<f64> = (0..phi.bins).map(between).collect();
    let below = |j: usize| measure.e_probability(measure.e_sigmas(e.edge(j)));
    let rows: Vec<f64> = (0..e.bins).map(|j| below(j + 1) - below(j)).collect();
    let masses = columns.iter().flat_map(|column| rows.iter().map(move |row| column * row));
    let density: Vec<f64> = masses.map(|mass| mass / grid.bin_area()).collect();
    let inside = columns.iter().sum::<f64>() * rows.iter().sum::<f64>();
    Joint { density, error: grid.len() as f64 * f64::EPSILON, mass_outside: 1.0 - inside, orbits: 0 }
}

fn by_orbits(
    family: &Family<'_, impl PlanarHamiltonian>,
    grid: &Grid,
    years: f64,
    tolerance: f64,
    most_orbits: usize,
) -> Joint {
    let t = angle_of(years);
    let mut leaves: Vec<Leaf> = Vec::new();
    let mut pending = family.first_intervals();
    let mut orbits = 0;
    loop {
        orbits += pending.len() * POINTS;
        leaves.extend(pending.par_iter().map(|&interval| leaf(family, grid, t, interval)).collect::<Vec<_>>());
        leaves.sort_by(|a, b| a.interval.low.total_cmp(&b.interval.low));
        let error: f64 = leaves.iter().map(|leaf| leaf.error).sum();
        let most = most_orbits.saturating_sub(orbits) / (2 * POINTS);
        let shares: Vec<f64> = leaves.iter().map(|leaf| leaf.error / tolerance).collect();
        let worst = worst(&shares, most, |i| leaves[i].interval.can_be_halved());
        if error <= tolerance || worst.is_empty() {
            return finish(grid, &leaves, error, orbits);
        }
        pending = worst.iter().flat_map(|&i| leaves[i].interval.halves()).collect();
        let mut keep = vec![true; leaves.len()];
        worst.iter().for_each(|&i| keep[i] = false);
        let mut keep = keep.into_iter();
        leaves.retain(|_| keep.next().unwrap_or(true));
    }
}

fn finish(grid: &Grid, leaves: &[Leaf], error: f64, orbits: usize) -> Joint {
    let mut masses = vec![0.0; grid.len() + 1];
    for &(bin, mass) in leaves.iter().flat_map(|leaf| &leaf.masses) {
        masses[bin as usize] += mass;
    }
    let missing = (1.0 - masses.iter().sum::<f64>()).abs();
    let mass_outside = masses.pop().unwrap_or(0.0);
    let density = masses.into_iter().map(|mass| mass / grid.bin_area()).collect();
    Joint { density, error: error + missing, mass_outside, orbits }
}

fn leaf(family: &Family<'_, impl PlanarHamiltonian>, grid: &Grid, t: f64, interval: Interval) -> Leaf {
    let mut entries: Vec<(u32, f64, f64)> = Vec::new();
    for ((_, kronrod, gauss), orbit) in interval.nodes().iter().zip(family.orbits(interval)) {
        if let Some(orbit) = orbit.filter(|orbit| orbit.share.total() > 0.0) {
            visit(&orbit, &family.flow.model, grid, t, |bin, mass| {
                entries.push((bin, kronrod * orbit.width * mass, gauss * orbit.width * mass));
            });
        }
    }
    entries.sort_by_key(|&(bin, ..)| bin);
    let (mut masses, mut error): (Vec<(u32, f64)>, f64) = (Vec::new(), 0.0);
    for bin in entries.chunk_by(|a, b| a.0 == b.0) {
        let (kronrod, gauss) = bin.iter().fold((0.0, 0.0), |sum, &(_, k, g)| (sum.0 + k, sum.1 + g));
        masses.push((bin[0].0, kronrod));
        error += super::family::kronrod_error(kronrod - gauss, kronrod);
    }
    Leaf { interval, masses, error }
}

/// What an orbit holds in each of its pieces after the time `t`, per unit of `H`.
fn visit(orbit: &Orbit, model: &impl PlanarHamiltonian, grid: &Grid, t: f64, mut take: impl FnMut(u32, f64)) {
    let (contour, share) = (&orbit.contour, &orbit.share);
    let total = share.total();
    let outside = grid.len() as u32;
    // Probability before a time on the orbit, continued beyond a period.
    let start = contour.wrap(-contour.half - t);
    let at_start = share.before(start);
    let before = |theta: f64| {
        let earlier = start + (theta + contour.half);
        let (earlier, turns) =
            if earlier > contour.half { (earlier - contour.period(), total) } else { (earlier, 0.0) };
        share.before(earlier) + turns - at_start
    };
    let holds = |from: f64, to: f64| before(to) - before(from) > 0.0;
    pieces(contour, orbit.trail(model), model, grid, holds, |Piece { from, to, bin }| {
        let mass = before(to) - before(from);
        if mass > 0.0 {
            take(bin.map_or(outside, |bin| bin as u32), mass);
        }
    });
}

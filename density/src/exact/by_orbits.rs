//! The joint density by orbits, which works however long the cloud has been wound up.
//!
//! Every orbit is followed once round, from grid line to grid line. The arc between two grid lines is in one bin. Its
//! probability is the initial probability of the arc `t` earlier on the same orbit, and so a difference of two values
//! of a function that only grows ([`super::share`]). So bins get positive probabilities that add up to the probability
//! of the cloud, however thin it has been wound. The only error is that of the integral over the orbits: the difference
//! between its two rules, bin by bin.

use rayon::prelude::*;

use crate::grid::Grid;
use crate::model::plane::PlanarHamiltonian;

use super::adaptive::{Interval, kronrod_error, remove, worst};
use super::contour::angle_of;
use super::crossings::{Piece, pieces};
use super::family::{Family, Orbit};
use super::joint::Joint;
use super::rules::POINTS;

/// An interval of orbits with its contribution to each bin.
struct BinPanel {
    interval: Interval,
    /// Bin (the number of bins stands for everything outside the grid) and its probability by the Kronrod rule.
    masses: Vec<(u32, f64)>,
    /// Sum over the bins of the difference between the two rules.
    error: f64,
}

/// The joint density after `years` on `grid`, to an L1 error of about `tolerance` unless that takes more than
/// `most_orbits`.
pub(super) fn joint(
    family: &Family<impl PlanarHamiltonian>,
    grid: &Grid,
    years: f64,
    tolerance: f64,
    most_orbits: usize,
) -> Joint {
    let t = angle_of(years);
    let mut panels: Vec<BinPanel> = Vec::new();
    let mut pending = family.first_intervals();
    let mut orbits = 0;
    loop {
        orbits += pending.len() * POINTS;
        panels.extend(pending.par_iter().map(|&interval| panel(family, grid, t, interval)).collect::<Vec<_>>());
        panels.sort_by(|a, b| a.interval.low.total_cmp(&b.interval.low));
        let error: f64 = panels.iter().map(|panel| panel.error).sum();
        let most = most_orbits.saturating_sub(orbits) / (2 * POINTS);
        let shares: Vec<f64> = panels.iter().map(|panel| panel.error / tolerance).collect();
        let worst = worst(&shares, most, |i| panels[i].interval.can_be_halved());
        if error <= tolerance || worst.is_empty() {
            return finish(grid, &panels, error, orbits);
        }
        pending = worst.iter().flat_map(|&i| panels[i].interval.halves()).collect();
        remove(&mut panels, &worst);
    }
}

fn finish(grid: &Grid, panels: &[BinPanel], error: f64, orbits: usize) -> Joint {
    let mut masses = vec![0.0; grid.len() + 1];
    for &(bin, mass) in panels.iter().flat_map(|panel| &panel.masses) {
        masses[bin as usize] += mass;
    }
    let missing = (1.0 - masses.iter().sum::<f64>()).abs();
    let mass_outside = masses.pop().unwrap_or(0.0);
    let density = masses.into_iter().map(|mass| mass / grid.bin_area()).collect();
    Joint { density, error: error + missing, mass_outside, orbits }
}

fn panel(family: &Family<impl PlanarHamiltonian>, grid: &Grid, t: f64, interval: Interval) -> BinPanel {
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
        error += kronrod_error(kronrod - gauss, kronrod);
    }
    BinPanel { interval, masses, error }
}

/// Passes to `take` the bin of every piece of an orbit and the probability in it after the time `t`, per unit of `H`.
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

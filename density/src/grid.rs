//! The common grid on which the densities of all methods are compared.
//!
//! There is one grid per snapshot, fixed by the problem alone: the image of the 4-sigma ellipse under the flow bounds
//! the cloud. The file `grid/by_batch.rs` finds the bins of many samples side by side.

pub(crate) mod by_batch;

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use crate::angle::{Circular, fold, nearest};
use crate::flow::Flow;
use crate::model::plane::{PlanarHamiltonian, State};
use crate::model::registry::Planar;
use crate::orbits::{LostOrbit, Orbits};
use crate::problem::Problem;
use crate::uncertain::UncertainProblem;

/// A uniform partition of an interval into bins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// Lower edge of the first bin.
    pub low: f64,
    /// Upper edge of the last bin.
    pub high: f64,
    /// Number of bins.
    pub bins: usize,
}

impl Axis {
    /// Width of a bin.
    pub fn width(&self) -> f64 {
        (self.high - self.low) / self.bins as f64
    }

    /// Lower edge of bin `i`; for `i = bins`, the upper edge of the last bin.
    pub fn edge(&self, i: usize) -> f64 {
        self.low + (self.high - self.low) * (i as f64 / self.bins as f64)
    }

    /// All `bins + 1` edges.
    pub fn edges(&self) -> Vec<f64> {
        (0..=self.bins).map(|i| self.edge(i)).collect()
    }

    /// Middle of bin `i`.
    pub fn centre(&self, i: usize) -> f64 {
        self.low + (self.high - self.low) * ((i as f64 + 0.5) / self.bins as f64)
    }

    /// The bin that `value` falls into. The lower edge of a bin belongs to it and the upper edge does not, except for
    /// the upper edge of the last bin, as in numpy's `histogram`.
    pub fn bin(&self, value: f64) -> Option<usize> {
        let position = (value - self.low) / (self.high - self.low) * self.bins as f64;
        (self.bins > 0 && self.low <= value && value <= self.high).then(|| (position as usize).min(self.bins - 1))
    }
}

/// Bins in the `(phi, e)` plane. Arrays over it are flat, `phi` outermost: bin `(i, j)` is element `i * e.bins + j`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Bins in the solar angle \[rad\], on the branch that keeps the cloud whole; at most 2π wide.
    pub phi: Axis,
    /// Bins in the eccentricity.
    pub e: Axis,
}

impl Grid {
    /// Number of bins.
    pub fn len(&self) -> usize {
        self.phi.bins * self.e.bins
    }

    /// Whether the grid has no bins at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Area of a bin \[rad\].
    pub fn bin_area(&self) -> f64 {
        self.phi.width() * self.e.width()
    }

    /// The representative of `phi` on the branch that starts below the grid's lower edge, by half of the part of the
    /// circle that the grid leaves free, so that a point just below the grid stays below it.
    pub fn fold(&self, phi: f64) -> f64 {
        fold(phi, self.branch_low())
    }

    /// Where the grid's branch of `phi` starts \[rad\].
    pub fn branch_low(&self) -> f64 {
        self.phi.low.midpoint(self.phi.high) - PI
    }

    /// The flat index of the bin that `(phi, e)` falls into, with `phi` on any branch; `None` outside the grid.
    pub fn bin(&self, phi: f64, e: f64) -> Option<usize> {
        Some(self.phi.bin(self.fold(phi))? * self.e.bins + self.e.bin(e)?)
    }

    /// How many samples fall into each bin.
    pub fn count(&self, phi: &[f64], e: &[f64]) -> Vec<u64> {
        /// Number of samples that a thread counts at a time.
        const CHUNK: usize = 65_536;
        let none = || vec![0; self.len()];
        let add = |mut sum: Vec<u64>, (phi, e): (&[f64], &[f64])| {
            let counts = by_batch::count(self, phi, e);
            sum.iter_mut().zip(counts).for_each(|(sum, count)| *sum += u64::from(count));
            sum
        };
        let join = |mut sum: Vec<u64>, other: Vec<u64>| {
            sum.iter_mut().zip(other).for_each(|(sum, count)| *sum += count);
            sum
        };
        phi.par_chunks(CHUNK).zip(e.par_chunks(CHUNK)).fold(none, add).reduce(none, join)
    }
}

/// Bounds the cloud of `problem` at each snapshot: the comparison grids, `bins_phi` x `bins_e` each. Orbits that have
/// left `e < 1` do not count.
///
/// # Errors
/// [`LostOrbit`] if no trajectory of the 4-sigma ellipse can be followed.
pub fn comparison_grids<M: PlanarHamiltonian>(
    problem: &Problem<M>,
    flow: &Flow<M>,
    bins_phi: usize,
    bins_e: usize,
) -> Result<Vec<Grid>, LostOrbit> {
    let rings = ellipse_rings(problem);
    let (starts_1, starts_2): (Vec<f64>, Vec<f64>) = rings.iter().map(|(state, _)| (state.x1, state.x2)).unzip();
    let (mut x1, mut x2, mut now) = (starts_1.clone(), starts_2.clone(), 0.0);
    let mut grids = Vec::with_capacity(problem.times.len());
    for &time in &problem.times {
        flow.advance_where_possible(&mut x1, &mut x2, time - now);
        now = time;
        let states = x1.iter().zip(&x2).zip(&rings).map(|((&x1, &x2), &(_, weight))| (State { x1, x2 }, weight));
        let there: Vec<(State, f64)> = states.filter(|(state, _)| !state.x1.is_nan()).collect();
        if there.is_empty() {
            Orbits::new(*flow, starts_1.clone(), starts_2.clone()).advance_to(time)?;
        }
        grids.push(bounding_grid(&there, bins_phi, bins_e));
    }
    Ok(grids)
}

/// The comparison grids where the radiation parameter is uncertain: they enclose the images of the 4-sigma ellipse for
/// parameters out to three deviations.
///
/// # Errors
/// As [`comparison_grids`].
pub fn grids_over_leaves(problem: &UncertainProblem, bins_phi: usize, bins_e: usize) -> Result<Vec<Grid>, LostOrbit> {
    const LEAVES: i32 = 12;
    const REACH: f64 = 3.0;
    let rings = ellipse_rings(&problem.plane);
    let (starts_1, starts_2): (Vec<f64>, Vec<f64>) = rings.iter().map(|(state, _)| (state.x1, state.x2)).unzip();
    let z = |k: i32| REACH * f64::from(k) / f64::from(LEAVES);
    let leaves: Vec<(f64, Flow<Planar>)> = (-LEAVES..=LEAVES)
        .filter_map(|k| Some(((-0.5 * z(k) * z(k)).exp(), Flow::new(problem.leaf(z(k))?.model))))
        .collect();
    let mut states = vec![(starts_1.clone(), starts_2.clone()); leaves.len()];
    let (mut now, mut grids) = (0.0, Vec::new());
    for &time in &problem.plane.times {
        let mut there: Vec<(State, f64)> = Vec::new();
        for ((weight, flow), (x1, x2)) in leaves.iter().zip(&mut states) {
            flow.advance_where_possible(x1, x2, time - now);
            let known = x1.iter().zip(&*x2).zip(&rings).filter(|((x1, _), _)| !x1.is_nan());
            there.extend(known.map(|((&x1, &x2), &(_, share))| (State { x1, x2 }, weight * share)));
        }
        now = time;
        if there.is_empty() {
            Orbits::new(Flow::new(problem.plane.model), starts_1.clone(), starts_2.clone()).advance_to(time)?;
        }
        grids.push(bounding_grid(&there, bins_phi, bins_e));
    }
    Ok(grids)
}

/// Points on concentric rings that fill the 4-sigma ellipse of the initial Gaussian, with their share of its mass.
fn ellipse_rings<M>(problem: &Problem<M>) -> Vec<(State, f64)> {
    const RINGS: u32 = 16;
    const SPOKES: u32 = 120;
    const E_RANGE: (f64, f64) = (1e-9, 0.999);
    let mut points = Vec::new();
    for ring in 1..=RINGS {
        let radius = 4.0 * f64::from(ring) / f64::from(RINGS);
        for spoke in 0..SPOKES {
            let (sin, cos) = (TAU * f64::from(spoke) / f64::from(SPOKES)).sin_cos();
            let (phi, e) = problem.initial.point(radius * cos, radius * sin);
            let weight = radius * (-0.5 * radius * radius).exp();
            points.push((State::from_polar(phi, e.clamp(E_RANGE.0, E_RANGE.1)), weight));
        }
    }
    points
}

/// The grid around weighted states.
fn bounding_grid(cloud: &[(State, f64)], bins_phi: usize, bins_e: usize) -> Grid {
    const MARGIN: f64 = 0.02;
    let states = || cloud.iter().map(|(state, _)| state);
    let (sin, cos) = cloud.iter().fold((0.0, 0.0), |(sin, cos), (state, weight)| {
        let e = state.eccentricity();
        (sin + weight * state.x1 / e, cos + weight * state.x2 / e)
    });
    let centre = Circular::from_mean_vector(sin, cos).mean;
    let (phi_low, phi_high) = range(states().map(|state| nearest(state.solar_angle(), centre)));
    let (e_low, e_high) = range(states().map(|state| state.eccentricity()));
    let (phi_margin, e_margin) = (MARGIN * (phi_high - phi_low), MARGIN * (e_high - e_low));
    Grid {
        phi: Axis {
            low: (phi_low - phi_margin).max(centre - PI),
            high: (phi_high + phi_margin).min(centre + PI),
            bins: bins_phi,
        },
        e: Axis { low: (e_low - e_margin).max(0.0), high: (e_high + e_margin).min(1.0), bins: bins_e },
    }
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::paper::scenario;

    #[test]
    fn every_value_has_the_bin_whose_edges_enclose_it() {
        let axis = Axis { low: -1.0, high: 2.0, bins: 7 };
        for i in 0..axis.bins {
            assert_eq!(axis.bin(axis.centre(i)), Some(i));
        }
        assert_eq!(axis.bin(2.0), Some(6), "the last bin has its upper edge");
        assert_eq!((axis.bin(2.0f64.next_up()), axis.bin(2.0f64.next_down())), (None, Some(6)));
        assert_eq!((axis.bin(-1.0), axis.bin((-1.0f64).next_down())), (Some(0), None));
        assert_eq!(axis.bin(-1.1), None);
        assert_eq!(axis.bin(f64::NAN), None);
    }

    /// Where rounding would put a value past the last bin, or a value that lies past it inside.
    #[test]
    fn no_value_on_an_axis_is_lost_and_none_beside_it_is_found() {
        for (low, high, bins) in [(0.1, 0.3, 3), (5.9, TAU, 100), (0.0, 1.0, 2000), (-1e-9, 1e-9, 7)] {
            let axis = Axis { low, high, bins };
            assert_eq!((axis.bin(high), axis.bin(high.next_down())), (Some(bins - 1), Some(bins - 1)), "{axis:?}");
            assert_eq!((axis.bin(low), axis.bin(low.next_down())), (Some(0), None), "{axis:?}");
            assert_eq!(axis.bin(high.next_up()), None, "{axis:?}");
        }
    }

    #[test]
    fn a_point_on_the_upper_edges_of_the_grid_counts_in_the_last_bin_on_any_turn() {
        let grid = Grid { phi: Axis { low: 1.0, high: 2.0, bins: 4 }, e: Axis { low: 0.1, high: 0.3, bins: 5 } };
        assert_eq!(grid.bin(2.0, 0.3), Some(19));
        assert_eq!(grid.bin(1.0, 0.1), Some(0));
    }

    #[test]
    fn grids_of_scenario_three_keep_the_cloud_astride_zero_whole() {
        let problem = scenario(3);
        let grids = comparison_grids(&problem, &Flow::new(problem.model), 100, 100).unwrap();
        let last = grids[4].phi;
        assert!(last.high - last.low < 1.2, "{last:?}");
        assert!(grids[4].fold(0.01) > grids[4].fold(TAU - 0.01) || grids[4].phi.high < TAU);
    }
}

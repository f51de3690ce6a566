//! The joint density where the radiation parameter is uncertain, from its values at points ([`super::leaves_density`]).
//!
//! Averages over bins are those of polynomials through the points ([`super::bin_averages`]). An uncertain parameter
//! widens the cloud, so that one or two points to a side of a bin resolve it in most places. Where they do not, as in
//! the threads that a saddle draws out, tiles of the grid get more points, or more leaves, whichever their error
//! estimates ask for.

use std::ops::Range;

use rayon::prelude::*;

use crate::grid::{Axis, Grid};
use crate::uncertain::UncertainProblem;

use super::adaptive::worst;
use super::bin_averages::{Averaging, averages};

use super::joint::Joint;
use super::leaves_density::{LEVELS, Leaves};

/// Intervals to a side of a bin, coarse and fine.
const PARTS: [usize; 8] = [1, 2, 3, 4, 6, 8, 12, 16];
/// Level of the leaves at first.
const FIRST_LEVEL: usize = 1;
/// Bins to a side of a tile.
const TILE: usize = 10;
/// Points beyond a tile, for the polynomials.
const BEYOND: usize = 3;
/// Degree of the polynomials.
const DEGREE: usize = 7;
/// Largest number of orbits.
const MOST_ORBITS: usize = 4_000_000;

/// The joint density after `years` on `grid`, to an L1 error of about `tolerance` if the permitted number of orbits is
/// enough for that.
pub(super) fn joint(problem: &UncertainProblem, grid: &Grid, years: f64, tolerance: f64) -> Joint {
    let leaves = Leaves::new(problem, years);
    let rough = Tile { rows: 0..grid.phi.bins, columns: 0..grid.e.bins, parts: 0, level: FIRST_LEVEL };
    let whole = Tile { parts: 1, ..rough.clone() };
    let mut found = Bins { grid: *grid, bins: vec![Bin::default(); grid.len()], orbits: 0 };
    for tile in [&rough, &whole] {
        found.put(tile, tile.bins(&leaves, grid), true);
    }
    let mut tiles = whole.split();
    loop {
        let shares: Vec<f64> = tiles.iter().map(|tile| found.errors(tile).iter().sum::<f64>() / tolerance).collect();
        let worst = worst(&shares, tiles.len(), |i| tiles[i].finer(found.errors(&tiles[i])).is_some());
        if shares.iter().sum::<f64>() <= 1.0 || worst.is_empty() || found.orbits > MOST_ORBITS {
            return found.joint();
        }
        let finer: Vec<(usize, Tile)> =
            worst.into_iter().filter_map(|i| Some((i, tiles[i].finer(found.errors(&tiles[i]))?))).collect();
        let fresh: Vec<(Vec<Bin>, usize)> = finer.par_iter().map(|(_, tile)| tile.bins(&leaves, grid)).collect();
        for ((i, tile), fresh) in finer.into_iter().zip(fresh) {
            found.put(&tile, fresh, tile.parts > tiles[i].parts);
            tiles[i] = tile;
        }
    }
}

/// A rectangle of bins that are resolved alike.
#[derive(Debug, Clone)]
struct Tile {
    rows: Range<usize>,
    columns: Range<usize>,
    /// Number of the entry of [`PARTS`].
    parts: usize,
    level: usize,
}

/// What is known of a bin.
#[derive(Debug, Clone, Copy, Default)]
struct Bin {
    density: f64,
    /// Error of the average over the bin: what the last refinement of the points changed.
    by_points: f64,
    /// Error of the integral over the leaves.
    by_leaves: f64,
}

/// All bins of a grid.
struct Bins {
    grid: Grid,
    bins: Vec<Bin>,
    orbits: usize,
}

impl Tile {
    /// The tile with more points, or with more leaves, as its errors by either ask for; `None` if it has the most
    /// already.
    fn finer(&self, [by_points, by_leaves]: [f64; 2]) -> Option<Self> {
        let points = (self.parts + 1 < PARTS.len()).then(|| Self { parts: self.parts + 1, ..self.clone() });
        let leaves = (self.level + 1 < LEVELS).then(|| Self { level: self.level + 1, ..self.clone() });
        if by_points >= by_leaves { points } else { leaves }
    }

    /// Tiles of the usual size.
    fn split(&self) -> Vec<Self> {
        let cuts = |range: &Range<usize>| -> Vec<Range<usize>> {
            range.clone().step_by(TILE).map(|start| start..(start + TILE).min(range.end)).collect()
        };
        let columns = cuts(&self.columns);
        let of_rows = |rows: Range<usize>| {
            columns.iter().map(move |columns| Self { rows: rows.clone(), columns: columns.clone(), ..self.clone() })
        };
        cuts(&self.rows).into_iter().flat_map(of_rows).collect()
    }

    /// The bins of the tile, row after row, and how many orbits they took.
    fn bins(&self, leaves: &Leaves<'_>, grid: &Grid) -> (Vec<Bin>, usize) {
        let parts = PARTS[self.parts];
        let lines = [(&self.rows, grid.phi), (&self.columns, grid.e)];
        let [rows, columns] = lines.map(|(bins, axis)| lattice(bins, parts, axis));
        let at = |axis: Axis, k: usize| axis.low + axis.width() * (k as f64 / parts as f64);
        let on_row = |i: usize| columns.clone().map(move |j| (at(grid.phi, i), at(grid.e, j)));
        let points: Vec<(f64, f64)> = rows.clone().flat_map(on_row).collect();
        let values = leaves.density(&points, self.level);
        let average = |values: &[f64], degree: usize| {
            let of_rows = Averaging::new(self.rows.clone(), parts, degree, rows.clone());
            averages(values, &of_rows, &Averaging::new(self.columns.clone(), parts, degree, columns.clone()))
        };
        let (density, by_leaves) = (average(&values.density, DEGREE), average(&values.difference, 1));
        // Where there is nothing polynomials swing about zero.
        let bin = |(density, by_leaves): (f64, f64)| Bin { density: density.max(0.0), by_points: 0.0, by_leaves };
        (density.into_iter().zip(by_leaves).map(bin).collect(), values.orbits)
    }
}

/// The points of a line that bins need, of those of the whole axis.
fn lattice(bins: &Range<usize>, parts: usize, axis: Axis) -> Range<usize> {
    (bins.start * parts).saturating_sub(BEYOND)..(bins.end * parts + BEYOND).min(axis.bins * parts) + 1
}

impl Bins {
    /// Takes the bins of a tile instead of those that were there, of which the tile has other points or other leaves.
    fn put(&mut self, tile: &Tile, (bins, orbits): (Vec<Bin>, usize), has_other_points: bool) {
        let places = tile.rows.clone().flat_map(|row| tile.columns.clone().map(move |column| (row, column)));
        for ((row, column), fresh) in places.zip(bins) {
            let bin = &mut self.bins[row * self.grid.e.bins + column];
            let by_points = if has_other_points { (fresh.density - bin.density).abs() } else { bin.by_points };
            *bin = Bin { by_points, ..fresh };
        }
        self.orbits += orbits;
    }

    /// L1 errors of a tile by its points and by its leaves.
    fn errors(&self, tile: &Tile) -> [f64; 2] {
        let (width, area) = (self.grid.e.bins, self.grid.bin_area());
        let bins = tile.rows.clone().flat_map(|row| &self.bins[row * width..][tile.columns.clone()]);
        bins.fold([0.0; 2], |[a, b], bin| [a + area * bin.by_points, b + area * bin.by_leaves])
    }

    fn joint(&self) -> Joint {
        let area = self.grid.bin_area();
        let sum = |of: fn(&Bin) -> f64| self.bins.iter().map(of).sum::<f64>() * area;
        let error = sum(|bin| bin.by_points + bin.by_leaves);
        let density = self.bins.iter().map(|bin| bin.density).collect();
        Joint { density, error, mass_outside: (1.0 - sum(|bin| bin.density)).max(0.0), orbits: self.orbits }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::measure::{Measure, normal_density};
    use crate::exact::rules::gauss;
    use crate::flow::{Accuracy, Flow};
    use crate::grid::grids_over_leaves;
    use crate::model::plane::State;
    use crate::problem::{Problem, paper};
    use crate::uncertain::{Distribution, Spread};

    /// Scenario `number` of the paper with a deviation of `relative`, and the grid after `years`.
    fn cloud(number: usize, relative: f64, years: f64) -> (UncertainProblem, Grid) {
        let Problem { model, initial, critical_e, .. } = paper::scenario(number);
        let plane = Problem { model: model.into(), initial, times: vec![0.0, years], critical_e };
        let problem = UncertainProblem::new(plane, Spread { relative, distribution: Distribution::Gaussian }).unwrap();
        let grid = grids_over_leaves(&problem, 60, 60).unwrap()[1];
        (problem, grid)
    }

    /// The midpoint rule over 1,500 values of the parameter, at 8 by 8 points of a bin (Gauss-Legendre), each with its
    /// own orbit.
    fn by_orbits(problem: &UncertainProblem, grid: &Grid, years: f64, bin: usize) -> f64 {
        const STEPS: usize = 1_500;
        let on = |axis: Axis, bin: usize| gauss(axis.edge(bin), axis.edge(bin + 1)).map(|(x, w)| (x, w / axis.width()));
        let (rows, columns) = (on(grid.phi, bin / grid.e.bins), on(grid.e, bin % grid.e.bins));
        let pairs = rows.iter().flat_map(|row| columns.iter().map(move |column| (row, column)));
        let (ends, weights): (Vec<State>, Vec<f64>) =
            pairs.map(|(&(phi, a), &(e, b))| (State::from_polar(phi, e), a * b)).unzip();
        let measure = Measure::new(problem.plane.initial);
        let lowest = problem.lowest().max(-6.0);
        let step = (6.0 - lowest) / STEPS as f64;
        let of_leaf = |k: usize| -> f64 {
            let z = lowest + step * (k as f64 + 0.5);
            let (mut x1, mut x2): (Vec<f64>, Vec<f64>) = ends.iter().map(|end| (end.x1, end.x2)).unzip();
            let flow = Flow { model: problem.leaf(z).unwrap().model, accuracy: Accuracy::Fine };
            flow.advance_where_possible(&mut x1, &mut x2, -years);
            let starts = x1.iter().zip(&x2).map(|(&x1, &x2)| State { x1, x2 });
            let densities = starts.zip(&ends).map(|(start, &end)| measure.density_after(start, end));
            normal_density(z) * densities.zip(&weights).map(|(density, weight)| weight * density).sum::<f64>()
        };
        let leaves: Vec<f64> = (0..STEPS).into_par_iter().map(of_leaf).collect();
        leaves.iter().sum::<f64>() * step / problem.mass_inside()
    }

    /// Also where a saddle draws the cloud out into a thread, in scenario 2.
    #[test]
    fn bins_have_the_density_of_a_rule_over_orbits() {
        for (number, relative, years) in [(1, 0.1, 1.5), (2, 0.05, 1.0), (3, 0.03, 1.0)] {
            let (problem, grid) = cloud(number, relative, years);
            let found = joint(&problem, &grid, years, 1e-4);
            assert!(
                found.error < 2e-4 && found.mass_outside < 0.02,
                "{number}: {:e} {}",
                found.error,
                found.mass_outside
            );
            let mut order: Vec<usize> = (0..grid.len()).collect();
            order.sort_by(|&a, &b| found.density[b].total_cmp(&found.density[a]));
            let peak = found.density[order[0]];
            for k in [0, 40, 150, 400, 1_000] {
                let (density, right) = (found.density[order[k]], by_orbits(&problem, &grid, years, order[k]));
                assert!((density - right).abs() < 3e-4 * peak, "{number}: {density} {right} of {peak}");
            }
        }
    }

    /// The estimate against a density that is thirty times as good, where clouds are wide, thin, and cut at `e = 0`.
    #[test]
    fn the_error_is_at_most_the_estimate_and_no_fiftieth_of_it() {
        for (number, relative, years) in [(1, 0.01, 1.0), (1, 0.3, 1.0), (2, 0.05, 1.0), (2, 0.01, 1.0), (3, 0.1, 1.0)]
        {
            let (problem, grid) = cloud(number, relative, years);
            let (found, better) = (joint(&problem, &grid, years, 3e-3), joint(&problem, &grid, years, 1e-4));
            let pairs = found.density.iter().zip(&better.density);
            let error = pairs.map(|(a, b)| (a - b).abs()).sum::<f64>() * grid.bin_area();
            println!(
                "{number} {relative} {years}: {error:e} estimated {:e}, {:e}; {} and {} orbits",
                found.error, better.error, found.orbits, better.orbits
            );
            assert!(error < found.error + better.error, "{number}: {error:e} {:e}", found.error);
            assert!(error > 0.02 * found.error, "{number}: {error:e} {:e}", found.error);
        }
    }
}

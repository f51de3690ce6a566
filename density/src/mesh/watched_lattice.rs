//! How much of the probability on a refined lattice has passed.
//!
//! A count of the lattice points that have passed is accurate to a cell only. The flow between the points is known much
//! better: on a refined lattice the interpolated states give the running maximum of `e` up to every time. It is a
//! continuous function of the initial point, whereas the time of passage is not: it jumps where an orbit's peak just
//! touches. The probability that the maximum exceeds the critical eccentricity is the probability of the pieces of
//! triangles in which its linear interpolation does.
//!
//! Within a step the excess `f = e² - e_crit²` of an orbit follows the quintic through value, slope and second
//! derivative at both ends, as in [`crate::first_passage::times`].

use rayon::prelude::*;

use super::MeshError;
use super::fine::number_nodes;
use super::gaussian::probability;
use super::lattice::{Refinement, graded_triangles};
use super::watched_orbit::WatchedOrbit;
use crate::first_passage::times::excess;
use crate::model::plane::{PlanarHamiltonian, State};
use crate::orbits::Orbits;
use crate::problem::Problem;

/// The refined lattice and the excess that its orbits have reached.
pub(super) struct WatchedLattice {
    pub refinement: Refinement,
    /// The points of the refined lattice that are corners of triangles.
    used: Vec<u32>,
    /// Triangulations of these, each with the probabilities of its triangles.
    meshes: Vec<Vec<([u32; 3], f64)>>,
    /// Total probability of the first triangulation.
    pub total: f64,
    orbits: Vec<WatchedOrbit>,
    /// Length of the last step \[yr\].
    step: f64,
}

impl WatchedLattice {
    /// The orbits of the lattice with these lines, interpolated to `degree` on at least `cells` cells per side. For
    /// each of `strides` there is a triangulation between every `stride`-th line of the refined lattice.
    pub fn new<M: PlanarHamiltonian>(
        problem: &Problem<M>,
        lines: &[Vec<f64>; 2],
        (degree, cells): (usize, usize),
        strides: &[usize],
        orbits: &Orbits<M>,
    ) -> Result<Self, MeshError> {
        let factor = cells.div_ceil(lines[0].len() - 1);
        let refinement = Refinement::new(&lines[0], &lines[1], degree, factor)?;
        let mut meshes: Vec<_> = strides.iter().map(|&stride| triangles(&refinement, stride)).collect();
        let used = number_nodes(meshes.iter_mut().flatten().map(|(corners, _)| corners).collect());
        let total = meshes[0].iter().map(|(_, mass)| mass).sum();
        let mut watched = Self { refinement, used, meshes, total, orbits: Vec::new(), step: 0.0 };
        watched.orbits =
            watched.excesses(problem, orbits.x1(), orbits.x2()).into_iter().map(WatchedOrbit::new).collect();
        Ok(watched)
    }

    /// The excess `f`, `f'`, `f''` of the used points, from the states of the lattice.
    fn excesses<M: PlanarHamiltonian>(&self, problem: &Problem<M>, x1: &[f64], x2: &[f64]) -> Vec<[f64; 3]> {
        let [x1, x2] = [x1, x2].map(|values| self.refinement.apply(values));
        let inside = |x1: f64, x2: f64| {
            // Where it resolves nothing, the interpolation may overshoot the disc `e < 1`.
            let shrink = (0.999_999 / x1.hypot(x2)).min(1.0);
            State { x1: shrink * x1, x2: shrink * x2 }
        };
        let excess = |&k: &u32| excess(&problem.model, problem.critical_e, inside(x1[k as usize], x2[k as usize]));
        self.used.par_iter().map(excess).collect()
    }

    /// Takes note of a step of `years` that ends at these states of the lattice.
    pub fn see<M: PlanarHamiltonian>(&mut self, problem: &Problem<M>, years: f64, x1: &[f64], x2: &[f64]) {
        let excesses = self.excesses(problem, x1, x2);
        let before = std::mem::replace(&mut self.step, years);
        self.orbits.par_iter_mut().zip(&excesses).for_each(|(orbit, &excess)| orbit.go_on(before, years, excess));
    }

    /// The change of the share of the probability that has passed, if all peaks were off by as much as they may be.
    pub fn doubt(&self, within: f64, years: f64) -> f64 {
        let highest = |orbit: &WatchedOrbit| (orbit.highest(within, years), orbit.doubt);
        let highest: Vec<(f64, f64)> = self.orbits.par_iter().map(highest).collect();
        let mesh = &self.meshes[0];
        let share = |(corners, mass): &([u32; 3], f64)| {
            let with = |sign: f64| {
                share_above(corners.map(|corner| {
                    let (value, doubt) = highest[corner as usize];
                    value + sign * doubt
                }))
            };
            [mass * (with(1.0) - with(-1.0)), *mass]
        };
        let [doubtful, total] = crate::estimate::ordered_sum(mesh.len(), |k| share(&mesh[k]));
        doubtful / total
    }

    /// The share of the probability that has passed up to the time `within` a step of the length `years`, on each
    /// triangulation.
    pub fn passed(&self, within: f64, years: f64) -> Vec<f64> {
        let highest: Vec<f64> = self.orbits.par_iter().map(|orbit| orbit.highest(within, years)).collect();
        let of_mesh = |mesh: &Vec<([u32; 3], f64)>| {
            let share = |(corners, mass): &([u32; 3], f64)| {
                [mass * share_above(corners.map(|corner| highest[corner as usize])), *mass]
            };
            let [passed, total] = crate::estimate::ordered_sum(mesh.len(), |k| share(&mesh[k]));
            (passed / total).clamp(0.0, 1.0)
        };
        self.meshes.iter().map(of_mesh).collect()
    }
}

/// Triangles between every `stride`-th line of a refined lattice, the last line included, with their probabilities.
fn triangles(refinement: &Refinement, stride: usize) -> Vec<([u32; 3], f64)> {
    let chosen = |lines: &[f64]| -> Vec<usize> {
        let last = lines.len() - 1;
        (0..last).step_by(stride).chain([last]).collect()
    };
    let (rows, columns) = (chosen(&refinement.outer), chosen(&refinement.inner));
    let outer: Vec<f64> = rows.iter().map(|&i| refinement.outer[i]).collect();
    let inner: Vec<f64> = columns.iter().map(|&j| refinement.inner[j]).collect();
    let width = refinement.inner.len();
    graded_triangles(&outer, &inner)
        .into_par_iter()
        .map(|triangle| {
            let at = triangle.map(|node| [node as usize / inner.len(), node as usize % inner.len()]);
            let mass = probability(&at.map(|[i, j]| [outer[i], inner[j]]));
            (at.map(|[i, j]| (rows[i] * width + columns[j]) as u32), mass)
        })
        .collect()
}

/// Share of a triangle in which the linear function with these values at the corners is not negative.
fn share_above(mut values: [f64; 3]) -> f64 {
    values.sort_by(f64::total_cmp);
    let [low, middle, high] = values;
    if low >= 0.0 {
        1.0
    } else if high < 0.0 {
        0.0
    } else if middle >= 0.0 {
        1.0 - low * low / ((middle - low) * (high - low))
    } else {
        high * high / ((high - low) * (high - middle))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_of_a_triangle_above_zero_is_that_of_its_area() {
        assert_eq!(share_above([1.0, 2.0, 3.0]), 1.0);
        assert_eq!(share_above([-1.0, -2.0, -3.0]), 0.0);
        assert!((share_above([1.0, -1.0, -1.0]) - 0.25).abs() < 1e-15);
        assert!((share_above([-1.0, 1.0, 1.0]) - 0.75).abs() < 1e-15);
        assert!((share_above([0.0, -1.0, 1.0]) - 0.5).abs() < 1e-15);
    }
}

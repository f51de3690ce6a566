//! First passages of the flow that a lattice interpolates.
//!
//! Counting the lattice points that have passed is good to a cell. The flow between the points is known much better: on a
//! refined lattice the interpolated states give the running maximum of `e` up to every time, which is a continuous function of
//! the initial point (when an orbit passes is not: it jumps where its peak just touches). The probability that it exceeds
//! the critical eccentricity is that of the pieces of triangles in which its linear interpolation does.
//!
//! Between two times the excess `f = e² - e_crit²` of an orbit is followed by the quintic through value, slope and second
//! derivative at both ends, as in [`crate::first_passage::times`]; steps are so short that no orbit of the lattice turns by
//! more than half a radian.

use rayon::prelude::*;

use super::carried::judge_cells;
use super::gaussian::probability;
use super::lattice::{Refinement, graded_triangles, lattice_lines};
use super::{MeshError, Points};
use crate::dynamics::{SUN_MEAN_MOTION, State};
use crate::first_passage::Quintic;
use crate::first_passage::times::excess;
use crate::flow::{Escaped, Flow};
use crate::orbits::Orbits;
use crate::problem::Problem;

/// Cells a side to which the lattice is refined.
const FINE_CELLS: usize = 300;
/// Phase by which an orbit may turn in a step \[rad\].
const PHASE: f64 = 0.5;
/// Steps between two times at most, whatever the phase: orbits beyond are those next to `e = 1`.
const MOST_STEPS: usize = 4096;
/// How far from its peak the excess must be for the quintic to matter.
const NEAR: f64 = 0.5;

/// Why there is no curve.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PassageError {
    /// The points are no lattice, or the degree does not fit it.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A characteristic cannot be followed.
    #[error(transparent)]
    Escaped(#[from] Escaped),
}

/// `P(T <= t)` at ascending times.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PassageCurve {
    /// The probability at each time.
    pub probability: Vec<f64>,
    /// An estimate of its error: what half the refinement and half the degree of interpolation change, the defect of
    /// the invariant measure so far, and what lies outside the lattice.
    pub error: Vec<f64>,
}

/// Of a long curve the mesh is judged at the first of so many times.
const JUDGED: usize = 8;

/// The curve at `times` \[yr\], ascending from zero, of the lattice `points` interpolated to `degree`.
///
/// # Errors
/// [`PassageError`].
pub fn passage_curve(
    problem: &Problem,
    flow: &Flow,
    points: &Points,
    degree: usize,
    times: &[f64],
) -> Result<PassageCurve, PassageError> {
    let initial = &problem.initial;
    let standard = |(&phi, &e)| initial.standardise(phi, e).into();
    let standard: Vec<[f64; 2]> = points.phi.iter().zip(&points.e).map(standard).collect();
    let lines = lattice_lines(&standard, points.lattice.unwrap_or(0))?;
    let watched = Watched::new(&lines, degree)?;
    let lower = (degree > 2 && watched.refinement.outer.len() > lines[0].len()).then_some(degree / 2);
    let compared = lower.map(|degree| Watched::new(&lines, degree)).transpose()?;
    let orbits = Orbits::from_polar(*flow, &points.phi, &points.e);
    let lattices = [Some(watched), compared].into_iter().flatten().map(|watched| watched.started(problem, &orbits));
    let mut walk = Walk { problem, flow, x1: orbits.x1.clone(), x2: orbits.x2.clone(), steps: 1, hurried: false };
    let (mut lattices, mut curve, mut now): (Vec<Watched>, _, _) = (lattices.collect(), PassageCurve::default(), 0.0);
    let outside = 1.0 - (lattices[0].total / initial.mass_inside()).min(1.0);
    // Where the interpolation has lost the flow at any time so far, what it says of passages may be as far off.
    let mut lost = 0.0_f64;
    for (index, &time) in times.iter().enumerate() {
        walk.on(time - now, &mut lattices)?;
        now = time;
        if index % JUDGED == 0 || times.len() <= JUDGED {
            let judged = judge_cells(initial, [&lines[0], &lines[1]], &lattices[0].refinement, [&walk.x1, &walk.x2]);
            lost = lost.max(judged.measure_defect);
        }
        let [fine, coarse] = lattices[0].passed();
        let other = lattices.get(1).map_or(fine, |lattice| lattice.passed()[0]);
        let hurried = if walk.hurried { 1.0 } else { 0.0 };
        // Rounding must not let it fall.
        curve.probability.push(curve.probability.last().map_or(fine, |last| fine.max(*last)));
        curve.error.push((fine - coarse).abs() + (fine - other).abs() + lost + outside + hurried);
    }
    Ok(curve)
}

/// The lattice's orbits on their way.
struct Walk<'a> {
    problem: &'a Problem,
    flow: &'a Flow,
    x1: Vec<f64>,
    x2: Vec<f64>,
    /// Steps that the last interval took.
    steps: usize,
    /// Whether an interval needed more than [`MOST_STEPS`].
    hurried: bool,
}

impl Walk<'_> {
    /// Moves on by `years` in steps that are short enough, which the lattices see.
    fn on(&mut self, years: f64, lattices: &mut [Watched]) -> Result<(), Escaped> {
        if years <= 0.0 {
            return Ok(());
        }
        let reached = lattices.iter().map(|lattice| (lattice.excess.clone(), lattice.highest.clone()));
        let (before, reached) = ((self.x1.clone(), self.x2.clone()), reached.collect::<Vec<_>>());
        let mut count = self.steps.max(self.needed(years)).min(MOST_STEPS);
        loop {
            let (step, mut needed) = (years / count as f64, 1);
            for _ in 0..count {
                self.flow.advance(&mut self.x1, &mut self.x2, step)?;
                lattices.iter_mut().for_each(|lattice| lattice.see(self.problem, step, &self.x1, &self.x2));
                needed = needed.max(self.needed(years));
                if needed > count && count < MOST_STEPS {
                    break;
                }
            }
            self.hurried |= needed > MOST_STEPS;
            if needed <= count || count == MOST_STEPS {
                self.steps = needed.min(MOST_STEPS);
                return Ok(());
            }
            // Once more, in shorter steps.
            (self.x1, self.x2) = before.clone();
            for (lattice, (excess, highest)) in lattices.iter_mut().zip(&reached) {
                (lattice.excess, lattice.highest) = (excess.clone(), highest.clone());
            }
            count = (needed + needed / 4).min(MOST_STEPS);
        }
    }

    /// Steps in which the fastest orbit below the critical eccentricity turns by [`PHASE`] at most.
    fn needed(&self, years: f64) -> usize {
        let Problem { force, critical_e, .. } = self.problem;
        let rate = |x1: f64, x2: f64| {
            let turning = (force.oblateness / State { x1, x2 }.s().powi(4) - 1.0).abs().max(1.0);
            SUN_MEAN_MOTION * (turning + force.radiation)
        };
        let below = |&(&x1, &x2): &(&f64, &f64)| x1 * x1 + x2 * x2 < critical_e * critical_e;
        let fastest = self.x1.iter().zip(&self.x2).filter(below).map(|(&x1, &x2)| rate(x1, x2)).fold(0.0, f64::max);
        ((fastest * years / PHASE).ceil() as usize).max(1)
    }
}

/// The refined lattice and what its orbits have reached.
struct Watched {
    refinement: Refinement,
    /// Triangles of the refined lattice, and of the one half as fine, with their probabilities.
    meshes: [Vec<([u32; 3], f64)>; 2],
    total: f64,
    /// Excess `f`, `f'`, `f''` of each point of the refined lattice.
    excess: Vec<[f64; 3]>,
    /// The largest excess so far.
    highest: Vec<f64>,
}

impl Watched {
    fn new(lines: &[Vec<f64>; 2], degree: usize) -> Result<Self, MeshError> {
        let factor = FINE_CELLS.div_ceil(lines[0].len() - 1);
        let refinement = Refinement::new(&lines[0], &lines[1], degree, factor)?;
        let meshes = [1, 2].map(|stride| triangles(&refinement, stride));
        let total = meshes[0].iter().map(|(_, mass)| mass).sum();
        Ok(Self { refinement, meshes, total, excess: Vec::new(), highest: Vec::new() })
    }

    fn started(mut self, problem: &Problem, orbits: &Orbits) -> Self {
        self.excess = self.excesses(problem, [&orbits.x1, &orbits.x2]);
        self.highest = self.excess.iter().map(|excess| excess[0]).collect();
        self
    }

    fn excesses(&self, problem: &Problem, states: [&[f64]; 2]) -> Vec<[f64; 3]> {
        let [x1, x2] = states.map(|values| self.refinement.apply(values));
        let inside = |x1: f64, x2: f64| {
            // Interpolation may overshoot the domain where it resolves nothing.
            let shrink = (0.999_999 / x1.hypot(x2)).min(1.0);
            State { x1: shrink * x1, x2: shrink * x2 }
        };
        let excess = |(&x1, &x2)| excess(problem.force, problem.critical_e, inside(x1, x2));
        x1.par_iter().zip(&x2).map(excess).collect()
    }

    /// Takes note of a step of so many years to these states of the lattice.
    fn see(&mut self, problem: &Problem, years: f64, x1: &[f64], x2: &[f64]) {
        let ends = self.excesses(problem, [x1, x2]);
        let starts = &self.excess;
        self.highest.par_iter_mut().zip(starts).zip(&ends).for_each(|((highest, &start), &end)| {
            if *highest >= 0.0 {
                return;
            }
            *highest = highest.max(end[0]);
            let peaks = start[1] > 0.0 && end[1] < 0.0 && start[0].max(end[0]) > -NEAR;
            if peaks && let Some(time) = Quintic::new(start, end, years).peak() {
                *highest = highest.max(Quintic::new(start, end, years).at(time));
            }
        });
        self.excess = ends;
    }

    /// The share of the probability that has passed, on both triangulations.
    fn passed(&self) -> [f64; 2] {
        self.meshes.each_ref().map(|mesh| {
            let share = |(corners, mass): &([u32; 3], f64)| {
                [mass * share_above(corners.map(|corner| self.highest[corner as usize])), *mass]
            };
            let [passed, total] = crate::estimate::ordered_sum(mesh.len(), |k| share(&mesh[k]));
            (passed / total).clamp(0.0, 1.0)
        })
    }
}

/// Triangles between every `stride`-th line of a refined lattice, and the last.
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

//! First passages of the flow that a lattice interpolates.
//!
//! A count of the lattice points that have passed is accurate to a cell only. The flow between the points is known much
//! better: on a refined lattice the interpolated states give the running maximum of `e` up to every time. It is a
//! continuous function of the initial point, whereas the time of passage is not: it jumps where an orbit's peak just
//! touches. The probability that the maximum exceeds the critical eccentricity is the probability of the pieces of
//! triangles in which its linear interpolation does.
//!
//! The orbits of the lattice are carried in steps so short that none of them turns by more than half a radian. Within a step
//! the excess `f = e² - e_crit²` of an orbit follows the quintic through value, slope and second derivative at both ends, as
//! in [`crate::first_passage::times`]; the times at which the curve is read off are independent of the steps.
//!
//! A dense lattice is first tried with about a hundred of its lines per side. All lines are taken if the estimated
//! error of interpolation is too large with these, unless the orbits turn so often that this would take minutes.

use rayon::prelude::*;

use super::carried::judge_cells;
use super::fine::number_nodes;
use super::gaussian::probability;
use super::lattice::{Refinement, graded_triangles, lattice_lines};
use super::watched_orbit::WatchedOrbit;
use super::{MeshError, Points};
use crate::first_passage::times::excess;
use crate::flow::{Escaped, Flow};
use crate::model::earth::SUN_MEAN_MOTION;
use crate::model::plane::{PlanarHamiltonian, State};
use crate::orbits::Orbits;
use crate::problem::Problem;

/// Cells per side to which the lattice is refined.
const FINE_CELLS: usize = 300;
/// The same for one of many lattices of which a mean is taken.
const CELLS_OF_MANY: usize = 60;
/// Number of lines of a dense lattice that are tried first.
const ENOUGH_LINES: usize = 100;
/// Estimated error of interpolation below which fewer lines are enough.
const GOOD: f64 = 1e-5;
/// Largest phase by which an orbit may turn in a step \[rad\].
const PHASE: f64 = 0.5;
/// Largest number of steps of a curve, whatever the phase: only orbits next to `e = 1` need more.
const MOST_STEPS: f64 = 8192.0;
/// A curve of more steps is not computed a second time with all lines of a dense lattice.
const MANY_STEPS: usize = 1024;
/// Factor by which the difference between two refinements or two degrees is multiplied in the reported error: where an
/// orbit just touches the critical eccentricity, both err to the same side.
const SAFETY: f64 = 3.0;

/// Why there is no curve.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PassageError {
    /// The points are not a lattice, or the degree does not fit it.
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
    /// An estimate of its error, the sum of these terms: three times the change by half the refinement and half the degree
    /// of interpolation; the change if peaks are off by as much as the quintic between steps may be; the largest defect of
    /// the invariant measure so far; and the probability outside the lattice. Rounding at `t = 0`, where the probability
    /// is that of the initial Gaussian.
    pub error: Vec<f64>,
}

/// The curve at `times` \[yr\], ascending from zero, of the lattice `points` interpolated to `degree`.
///
/// # Errors
/// [`PassageError`].
pub fn passage_curve<M: PlanarHamiltonian>(
    problem: &Problem<M>,
    flow: &Flow<M>,
    points: &Points,
    degree: usize,
    times: &[f64],
) -> Result<PassageCurve, PassageError> {
    let side = points.lattice.unwrap_or(0);
    if let Some(thinned) = thinned(points, side, degree) {
        let Walked { curve, interpolation, steps } = curve_of(problem, flow, &thinned, degree, times, FINE_CELLS)?;
        if interpolation < GOOD || steps > MANY_STEPS {
            return Ok(curve);
        }
    }
    curve_of(problem, flow, points, degree, times, FINE_CELLS).map(|walked| walked.curve)
}

/// The same for one of many lattices of which a mean is taken, so that each may be read more coarsely.
///
/// # Errors
/// [`PassageError`].
pub fn layer_curve<M: PlanarHamiltonian>(
    problem: &Problem<M>,
    flow: &Flow<M>,
    points: &Points,
    degree: usize,
    times: &[f64],
) -> Result<PassageCurve, PassageError> {
    curve_of(problem, flow, points, degree, times, CELLS_OF_MANY).map(|walked| walked.curve)
}

/// Every few lines of a lattice of `side` lines; `None` if it is not dense.
fn thinned(points: &Points, side: usize, degree: usize) -> Option<Points> {
    let stride = side.saturating_sub(1) / ENOUGH_LINES;
    if stride < 2 || side * side != points.phi.len() || ENOUGH_LINES <= degree {
        return None;
    }
    let lines: Vec<usize> = (0..side - 1).step_by(stride).chain([side - 1]).collect();
    let rows = || lines.iter().flat_map(|i| lines.iter().map(move |j| i * side + j));
    let [phi, e] = [&points.phi, &points.e].map(|column| rows().map(|row| column[row]).collect());
    Some(Points { phi, e, lattice: Some(lines.len()) })
}

/// A curve and how it was obtained.
struct Walked {
    curve: PassageCurve,
    /// The part of its error that more lines would lower.
    interpolation: f64,
    /// Number of steps of the lattice's orbits.
    steps: usize,
}

/// Like [`passage_curve`], with all points, refined to at least `cells` cells per side.
fn curve_of<M: PlanarHamiltonian>(
    problem: &Problem<M>,
    flow: &Flow<M>,
    points: &Points,
    degree: usize,
    times: &[f64],
    cells: usize,
) -> Result<Walked, PassageError> {
    let initial = &problem.initial;
    let standard = |(&phi, &e)| initial.standardise(phi, e).into();
    let standard: Vec<[f64; 2]> = points.phi.iter().zip(&points.e).map(standard).collect();
    let lines = lattice_lines(&standard, points.lattice.unwrap_or(0))?;
    let orbits = Orbits::from_polar(*flow, &points.phi, &points.e);
    let start = |degree, strides: &[usize]| Watched::new(problem, &lines, (degree, cells), strides, &orbits);
    let mut fine = start(degree, &[1, 2])?;
    let mut rough = match degree > 2 && fine.refinement.outer.len() > lines[0].len() {
        true => Some(start(degree / 2, &[2])?),
        false => None,
    };
    let end = times.last().copied().unwrap_or(0.0);
    let mut walk =
        Walk { problem, flow, x1: orbits.x1().to_vec(), x2: orbits.x2().to_vec(), now: 0.0, end, hurried: false };
    let (mut curve, mut step, mut steps) = (PassageCurve::default(), 0.0, 0);
    let at_start = initial.probability_above(problem.critical_e);
    let outside = 1.0 - (fine.total / initial.mass_inside()).min(1.0);
    // If the interpolation has lost the flow at any time so far, the passages may be off by as much.
    let (mut lost, mut interpolation) = (0.0_f64, 0.0_f64);
    for &time in times {
        while walk.now < time {
            (step, steps) = (walk.step()?, steps + 1);
            for lattice in [Some(&mut fine), rough.as_mut()].into_iter().flatten() {
                lattice.see(problem, step, &walk.x1, &walk.x2);
            }
            let judged = judge_cells(initial, [&lines[0], &lines[1]], &fine.refinement, [&walk.x1, &walk.x2], &[]);
            lost = lost.max(judged.measure_defect);
        }
        let within = step - (walk.now - time);
        if time == 0.0 {
            curve.probability.push(at_start);
            curve.error.push(f64::EPSILON);
            continue;
        }
        let passed = fine.passed(within, step);
        let (passed, coarse) = (passed[0], passed[1]);
        let other = rough.as_ref().map_or(coarse, |lattice| lattice.passed(within, step)[0]);
        interpolation = interpolation.max((coarse - other).abs() + lost);
        let hurried = f64::from(walk.hurried);
        // The curve does not fall, and at least the orbits that were above at the start have passed.
        curve.probability.push(curve.probability.last().map_or(passed.max(at_start), |last| passed.max(*last)));
        let differences = (passed - coarse).abs() + (coarse - other).abs();
        curve.error.push(SAFETY * differences + fine.doubt(within, step) + lost + outside + hurried);
    }
    Ok(Walked { curve, interpolation, steps })
}

/// The lattice's orbits, moved step by step.
struct Walk<'a, M> {
    problem: &'a Problem<M>,
    flow: &'a Flow<M>,
    x1: Vec<f64>,
    x2: Vec<f64>,
    /// Time \[yr\].
    now: f64,
    /// Last time of the curve \[yr\].
    end: f64,
    /// Whether a step should have been shorter than [`MOST_STEPS`] allows.
    hurried: bool,
}

impl<M: PlanarHamiltonian> Walk<'_, M> {
    /// Moves on by a step that is short enough, and returns its length \[yr\].
    fn step(&mut self) -> Result<f64, Escaped> {
        let (left, shortest) = (self.end - self.now, self.end / MOST_STEPS);
        let mut step = (PHASE / self.fastest()).max(shortest).min(left);
        let before = (self.x1.clone(), self.x2.clone());
        loop {
            self.flow.advance(&mut self.x1, &mut self.x2, step)?;
            let too_long = step * self.fastest() > 1.5 * PHASE;
            self.hurried |= too_long && step <= shortest;
            if !too_long || step <= shortest {
                self.now = if step < left { self.now + step } else { self.end };
                return Ok(step);
            }
            step = (0.5 * step).max(shortest);
            (self.x1, self.x2) = before.clone();
        }
    }

    /// Rate at which the fastest orbit below the critical eccentricity turns \[rad/yr\].
    fn fastest(&self) -> f64 {
        let Problem { model, critical_e, .. } = self.problem;
        let rate = |x1: f64, x2: f64| SUN_MEAN_MOTION * (model.turning_rate(State { x1, x2 }).max(1.0) + model.pull());
        let below = |&(&x1, &x2): &(&f64, &f64)| x1 * x1 + x2 * x2 < critical_e * critical_e;
        let rates = self.x1.iter().zip(&self.x2).filter(below).map(|(&x1, &x2)| rate(x1, x2));
        rates.fold(SUN_MEAN_MOTION, f64::max)
    }
}

/// The refined lattice and the excess that its orbits have reached.
struct Watched {
    refinement: Refinement,
    /// The points of the refined lattice that are corners of triangles.
    used: Vec<u32>,
    /// Triangulations of these, each with the probabilities of its triangles.
    meshes: Vec<Vec<([u32; 3], f64)>>,
    /// Total probability of the first triangulation.
    total: f64,
    orbits: Vec<WatchedOrbit>,
    /// Length of the last step \[yr\].
    step: f64,
}

impl Watched {
    /// The orbits of the lattice with these lines, interpolated to `degree` on at least `cells` cells per side. For each of `strides` there is a
    /// triangulation between every `stride`-th line of the refined lattice.
    fn new<M: PlanarHamiltonian>(
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
    fn see<M: PlanarHamiltonian>(&mut self, problem: &Problem<M>, years: f64, x1: &[f64], x2: &[f64]) {
        let excesses = self.excesses(problem, x1, x2);
        let before = std::mem::replace(&mut self.step, years);
        self.orbits.par_iter_mut().zip(&excesses).for_each(|(orbit, &excess)| orbit.go_on(before, years, excess));
    }

    /// The change of the share of the probability that has passed, if all peaks were off by as much as they may be.
    fn doubt(&self, within: f64, years: f64) -> f64 {
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
    fn passed(&self, within: f64, years: f64) -> Vec<f64> {
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

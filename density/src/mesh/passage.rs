//! First passages of the flow that a lattice interpolates.
//!
//! The orbits of the lattice are carried in steps so short that none of them turns by more than half a radian. After
//! each step the refined lattice takes note of how high its orbits have come ([`super::watched_lattice`]), from which
//! the probability of having passed follows. The times at which the curve is read off are independent of the steps.
//!
//! A dense lattice is first tried with about a hundred of its lines per side. All lines are taken if the estimated
//! error of interpolation is too large with these, unless the orbits turn so often that this would take minutes.

use super::carried::judge_cells;
use super::lattice::lattice_lines;
use super::watched_lattice::WatchedLattice;
use super::{MeshError, Points};
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
    /// An estimate of its error, the sum of these terms: three times the change by half the refinement and half the
    /// degree of interpolation; the change if peaks are off by as much as the quintic between steps may be; the largest
    /// defect of the invariant measure so far; and the probability outside the lattice. Rounding at `t = 0`, where the
    /// probability is that of the initial Gaussian.
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
    let start = |degree, strides: &[usize]| WatchedLattice::new(problem, &lines, (degree, cells), strides, &orbits);
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

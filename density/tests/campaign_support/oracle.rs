//! The oracle: quadrature on finer and finer lattices until nothing that matters changes, and Monte Carlo.
//!
//! The error of a figure is [`SAFETY`] times the largest change of its group of figures by the last refinement; a
//! single figure may change little by chance, where a branch cut or a separatrix lies between the nodes. Where Monte
//! Carlo is more accurate (for a cloud wound so thinly that no lattice resolves it), its value and four of its standard
//! errors are taken instead.

use density::angle::nearest;
use density::grid::Grid;
use density::problem::{InitialGaussian, Problem};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use super::bins::joint;
use super::crossing::{Reading, probability};
use super::lattice::Lattice;
use super::moments::{Cloud, cloud};
use super::paths::{Motion, Paths, follow};

/// Limits of the oracle's work.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Lines and nodes of the first lattice; each further one has twice as many of both.
    pub first: (usize, usize),
    /// Largest number of lattices.
    pub most_levels: usize,
    /// Largest number of steps, of bundles of orbits, that a further lattice may be expected to take.
    pub most_steps: u64,
    /// Number of orbits of the Monte Carlo run.
    pub samples: usize,
    /// Number of steps after which an orbit is given up.
    pub most_orbit_steps: u64,
    /// Number of lines, interpolated ones included, that fill the bins of the joint density.
    pub joint_lines: usize,
}

impl Effort {
    /// For a campaign.
    pub const THOROUGH: Self = Self {
        first: (48, 96),
        most_levels: 4,
        most_steps: 1_500_000,
        samples: 20_000,
        most_orbit_steps: 20_000,
        joint_lines: 2_400,
    };
    /// For the tests.
    pub const QUICK: Self = Self {
        first: (40, 80),
        most_levels: 3,
        most_steps: 100_000,
        samples: 3_000,
        most_orbit_steps: 2_000,
        joint_lines: 1_000,
    };
}

/// Errors below which no finer lattice is needed: of moments and probabilities, and of the joint density.
const GOOD_ENOUGH: (f64, f64) = (1e-8, 1e-3);

/// Factor from a change to an error, see the [module's text](self).
const SAFETY: f64 = 3.0;

/// The right figures at one time.
#[derive(Debug, Clone)]
pub struct Truth {
    /// Moments.
    pub cloud: Cloud,
    /// Probability above the critical eccentricity.
    pub above: f64,
    /// Probability of having been above it.
    pub ever: f64,
    /// Errors of the two probabilities from too few lines.
    pub doubt: [f64; 2],
    /// Joint density on the grid, and its L1 error from too few lines through its bins.
    pub joint: (Vec<f64>, f64),
    /// Errors of these figures.
    pub error: Errors,
}

/// Errors of a [`Truth`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Errors of the moments, in standard deviations or products of them.
    pub moments: [f64; 5],
    /// Error of the mean vector of the solar angle.
    pub vector: f64,
    /// Error of the probability above the critical eccentricity.
    pub above: f64,
    /// Error of the probability of having been above it.
    pub ever: f64,
    /// L1 error of the joint density.
    pub joint: f64,
}

/// The oracle's answer.
#[derive(Debug, Clone)]
pub struct Oracle {
    /// The right figures at each time of the problem.
    pub truths: Vec<Truth>,
    /// Lines and nodes of the last lattice.
    pub lattice: (usize, usize),
    /// Descriptions of figures in which quadrature and Monte Carlo contradict each other.
    pub contradictions: Vec<String>,
}

/// Solves `problem`, with joint densities on `grids`.
pub fn solve(problem: &Problem, grids: &[Grid], effort: &Effort) -> Oracle {
    let (mut lines, mut nodes) = effort.first;
    let (mut truths, mut steps) = level(problem, grids, effort, (lines, nodes));
    for _ in 1..effort.most_levels {
        if 4 * steps > effort.most_steps || truths.iter().all(Truth::is_good_enough) {
            break;
        }
        (lines, nodes) = (2 * lines, 2 * nodes);
        let (finer, finer_steps) = level(problem, grids, effort, (lines, nodes));
        steps = finer_steps;
        truths = finer.into_iter().zip(&truths).zip(grids).map(|((finer, t), grid)| finer.after(t, grid)).collect();
        // An error of the first-passage probability remains at all later times.
        for k in 1..truths.len() {
            truths[k].error.ever = truths[k].error.ever.max(truths[k - 1].error.ever);
        }
    }
    let sampled = Sampled::new(problem, effort);
    let mut contradictions = Vec::new();
    for (k, truth) in truths.iter_mut().enumerate() {
        sampled.check(truth, k, problem, &mut contradictions);
    }
    Oracle { truths, lattice: (lines, nodes), contradictions }
}

fn level(problem: &Problem, grids: &[Grid], effort: &Effort, (lines, nodes): (usize, usize)) -> (Vec<Truth>, u64) {
    let motion = Motion { force: problem.model, most_steps: effort.most_orbit_steps };
    let lattice = Lattice::new(problem.initial, lines, nodes);
    let paths = follow(motion, &lattice.starts(), &problem.times);
    let read =
        |k: usize, reading| probability(motion, &lattice, &paths, (&problem.times, k), problem.critical_e, reading);
    let unknown =
        Errors { moments: [f64::INFINITY; 5], vector: f64::INFINITY, above: 1.0, ever: 1.0, joint: f64::INFINITY };
    let truth = |(k, grid): (usize, &Grid)| {
        let ((above, above_doubt), (ever, ever_doubt)) = (read(k, Reading::Now), read(k, Reading::Ever));
        Truth {
            cloud: cloud(&lattice, &paths, k),
            above,
            ever,
            doubt: [above_doubt, ever_doubt],
            joint: joint(&lattice, &paths, k, grid, effort.joint_lines),
            error: unknown,
        }
    };
    (grids.iter().enumerate().map(truth).collect(), paths.steps)
}

impl Truth {
    fn is_good_enough(&self) -> bool {
        let Errors { moments, vector, above, ever, joint } = self.error;
        let figures = moments.into_iter().chain([vector, above, ever]);
        figures.fold(0.0, f64::max) < GOOD_ENOUGH.0 && joint < GOOD_ENOUGH.1
    }

    /// The same figures, with the errors that follow from the change since a coarser lattice.
    fn after(mut self, coarser: &Self, grid: &Grid) -> Self {
        // Orbits that could not be followed may be anywhere.
        let lost = self.cloud.lost;
        let scales = self.cloud.scales();
        let (values, before) = (self.cloud.moments, coarser.cloud.moments);
        let change = |i: usize| if i == 0 { nearest(values[0] - before[0], 0.0) } else { values[i] - before[i] };
        let spread = if lost > 0.0 { lost * (4.0 / scales[0]).max(1.0 / scales[2]).powi(2) } else { 0.0 };
        let vector = |i: usize| self.cloud.vector[i] - coarser.cloud.vector[i];
        let differences = self.joint.0.iter().zip(&coarser.joint.0).map(|(a, b)| (a - b).abs());
        let changes: [f64; 5] = std::array::from_fn(|i| (change(i) / scales[i]).abs());
        let (of_phi, of_e) = (largest([changes[0], changes[1], changes[4]]), largest([changes[2], changes[3]]));
        let of_probability = largest([self.above - coarser.above, self.ever - coarser.ever]);
        let branch = self.cloud.at_cut * std::f64::consts::TAU / scales[0];
        let group = |i: usize| if i == 2 || i == 3 { SAFETY * of_e } else { SAFETY * of_phi + branch };
        self.error = Errors {
            moments: std::array::from_fn(|i| group(i) + spread),
            vector: SAFETY * vector(0).hypot(vector(1)) + 2.0 * lost,
            above: SAFETY * of_probability + self.doubt[0] + lost,
            ever: SAFETY * of_probability + self.doubt[1] + lost,
            joint: differences.sum::<f64>() * grid.bin_area() + self.joint.1 + 2.0 * lost,
        };
        self
    }
}

/// The largest absolute value; NaN if one of them is NaN.
fn largest<const N: usize>(values: [f64; N]) -> f64 {
    values.into_iter().fold(0.0, |most: f64, value| if value.abs() <= most { most } else { value.abs() })
}

/// A Monte Carlo run on the oracle's integrator.
struct Sampled {
    paths: Paths,
    count: usize,
}

impl Sampled {
    fn new(problem: &Problem, effort: &Effort) -> Self {
        const SEED: u64 = 20_261_127;
        let InitialGaussian { mean_phi, mean_e, sigma_phi, sigma_e, .. } = problem.initial;
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let [phi, e] = [(mean_phi, sigma_phi), (mean_e, sigma_e)]
            .map(|(mean, sigma)| Normal::new(mean, sigma).expect("a scenario has a positive deviation"));
        let draws = std::iter::repeat_with(|| [phi.sample(&mut random), e.sample(&mut random)]);
        let starts: Vec<[f64; 2]> = draws.filter(|[_, e]| *e > 0.0 && *e < 1.0).take(effort.samples).collect();
        let motion = Motion { force: problem.model, most_steps: effort.most_orbit_steps };
        Self { paths: follow(motion, &starts, &problem.times), count: effort.samples }
    }

    /// Compares `truth` at time `k` with the sample, and replaces figures that the sample knows better.
    fn check(&self, truth: &mut Truth, k: usize, problem: &Problem, contradictions: &mut Vec<String>) {
        let points: Vec<(f64, f64)> = (0..self.count)
            .map(|i| (self.paths.x1[k][i], self.paths.x2[k][i]))
            .map(|(x1, x2)| (x1.atan2(x2), x1.hypot(x2)))
            .filter(|point| !point.0.is_nan())
            .collect();
        let n = points.len() as f64;
        if n < 100.0 {
            return;
        }
        let lost = 1.0 - n / self.count as f64;
        let mean = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
        let vector = [mean(&|p| p.0.sin()), mean(&|p| p.0.cos())];
        let vector_error = ((1.0 - vector[0].powi(2) - vector[1].powi(2)) / n).sqrt() + 2.0 * lost;
        let own_branch = 4.0 * vector_error < truth.error.vector;
        let c = if own_branch { vector[0].atan2(vector[1]) } else { truth.cloud.circular_mean() };
        let on_branch: Vec<(f64, f64)> = points.iter().map(|p| (nearest(p.0, c) - c, p.1)).collect();
        let mean = |f: &dyn Fn(&(f64, f64)) -> f64| on_branch.iter().map(f).sum::<f64>() / n;
        let r = mean(&|p| p.1);
        let raw = [mean(&|p| p.0), mean(&|p| p.0 * p.0), 0.0, mean(&|p| (p.1 - r).powi(2)), mean(&|p| p.0 * (p.1 - r))];
        let sampled = Cloud::from_raw(raw, c, r, vector, lost);
        let a = raw[0];
        let central = |i: i32, j: i32| mean(&|p| (p.0 - a).powi(i) * (p.1 - r).powi(j));
        let [_, sd_phi, _, sd_e, cov] = sampled.moments;
        let of_deviation = |m4: f64, sd: f64| ((m4 - sd.powi(4)).max(0.0) / (4.0 * sd * sd * n)).sqrt() / sd;
        let scale = 1.0 / n.sqrt();
        let mut errors = [
            scale,
            of_deviation(central(4, 0), sd_phi),
            scale,
            of_deviation(central(0, 4), sd_e),
            ((central(2, 2) - cov * cov).max(0.0) / n).sqrt() / (sd_phi * sd_e),
        ];
        if own_branch {
            // The cut moves with the sample's circular mean; the samples that it passes jump by a turn.
            let resultant = vector[0].hypot(vector[1]);
            let strip = mean(&|p| f64::from(p.0.abs() > std::f64::consts::PI - 0.1)) / 0.2;
            let moved = strip * std::f64::consts::TAU * vector_error / resultant / sd_phi;
            [0, 1, 4].iter().for_each(|&i| errors[i] += moved);
        }
        let scales = sampled.scales();
        for i in 0..5 {
            let difference = truth.cloud.moments[i] - sampled.moments[i];
            let difference = if i == 0 { nearest(difference, 0.0) } else { difference } / scales[i];
            let name = ["mean_phi", "std_phi", "mean_e", "std_e", "cov_phi_e"][i];
            let pair = (&mut truth.cloud.moments[i], &mut truth.error.moments[i]);
            let spread = if lost > 0.0 { lost * (4.0 / scales[0]).max(1.0 / scales[2]).powi(2) } else { 0.0 };
            settle(pair, sampled.moments[i], difference, (errors[i], spread), (name, k), contradictions);
        }
        if own_branch {
            (truth.cloud.vector, truth.error.vector) = (vector, 4.0 * vector_error);
        }
        let critical = problem.critical_e * problem.critical_e;
        let above = points.iter().filter(|p| p.1 * p.1 > critical).count() as f64;
        let ever = self.paths.peak[k].iter().filter(|&&e2| e2 > critical).count() as f64;
        let mut share = |hits: f64, value: &mut f64, error: &mut f64, name| {
            let p = (hits + 2.0) / (n + 4.0);
            let own = (p * (1.0 - p) / n).sqrt();
            let difference = *value - hits / n;
            settle((value, error), hits / n, difference, (own, lost), (name, k), contradictions);
        };
        share(above, &mut truth.above, &mut truth.error.above, "p_above");
        share(ever, &mut truth.ever, &mut truth.error.ever, "p_ever");
    }
}

/// Takes the more accurate of two figures that differ by `difference`, and notes if they contradict each other.
fn settle(
    (value, error): (&mut f64, &mut f64),
    sampled: f64,
    difference: f64,
    (standard_error, lost): (f64, f64),
    (name, k): (&str, usize),
    contradictions: &mut Vec<String>,
) {
    if *error < 1e300 && difference.abs() > *error + 6.0 * standard_error + lost {
        contradictions.push(format!(
            "{name} at time {k}: quadrature {value:.6e} +- {error:.1e}, Monte Carlo {sampled:.6e} +- {standard_error:.1e}"
        ));
        // Neither of them can be trusted beyond the difference.
        *error = error.max(difference.abs());
    }
    if 4.0 * standard_error + lost < *error || error.is_nan() {
        (*value, *error) = (sampled, 4.0 * standard_error + lost);
    }
}

//! The methods, called as the nodes call them, and the errors that each claims for its figures.

use std::panic::{AssertUnwindSafe, catch_unwind};

use density::binning;
use density::estimate::Estimate;
use density::exact::{Exact, ExactSettings};
use density::first_passage::curve_times;
use density::first_passage::empirical::{curve_of_points, point};
use density::first_passage::exact::exact_curve;
use density::flow::{Flow, Passages};
use density::grid::Grid;
use density::mesh::passage::passage_curve;
use density::mesh::{CarriedMesh, Placement, initial_points};
use density::mixture;
use density::model::planar::SrpJ2;
use density::orbits::Orbits;
use density::problem::Problem;
use density::sampling;
use density::trust::{Diagnosis, trust};
use rustix::time::{ClockId, clock_gettime};

/// A method of the campaign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// The exact density.
    Exact,
    /// Carried lattice of at most the given number of points.
    Mesh(usize),
    /// Mixture with the default split.
    Mixture,
    /// The given number of independent samples.
    MonteCarlo(usize),
}

impl Method {
    /// The method with a name from the command line.
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "exact" => Self::Exact,
            "dee-961" => Self::Mesh(961),
            "dee-1e5" => Self::Mesh(100_000),
            "gmm-ut" => Self::Mixture,
            "mc" => Self::MonteCarlo(100_000),
            _ => return None,
        })
    }

    /// Its name in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Mesh(points) if points < 10_000 => "dee-961",
            Self::Mesh(_) => "dee-1e5",
            Self::Mixture => "gmm-ut",
            Self::MonteCarlo(_) => "mc",
        }
    }
}

/// A method's answer to a scenario.
#[derive(Debug)]
pub struct Answer {
    /// One snapshot per time, or why there is none.
    pub snapshots: Vec<Result<Shown, String>>,
    /// First-passage curve, or why there is none; `None` if the method has no such curve.
    pub curve: Option<Result<Curve, String>>,
    /// Processor time of all threads \[s\].
    pub seconds: f64,
}

/// A snapshot with the claims of the method about it.
#[derive(Debug)]
pub struct Shown {
    /// The density.
    pub estimate: Estimate,
    /// The errors that the method claims or implies.
    pub claim: Claim,
    /// Its diagnostics, as [`density::trust::trust`] takes them.
    pub says: [f64; 4],
    /// Whether its own verdict says that the moments, or the density, should not be trusted.
    pub distrusted: Distrust,
    /// Probability outside the grid, if the method gives it.
    pub mass_outside: Option<f64>,
}

/// The figures that a method's verdict on itself ([`density::trust`], at `TOLERANCE`) does not vouch for.
#[derive(Debug, Clone, Copy, Default)]
pub struct Distrust {
    /// Moments and the probability above the critical eccentricity.
    pub moments: bool,
    /// The joint density.
    pub density: bool,
}

impl Distrust {
    fn of(diagnosis: Diagnosis, resultant: f64) -> Self {
        let verdict = trust(diagnosis, resultant, TOLERANCE);
        Self { moments: !verdict.moments(), density: !verdict.density() }
    }

    /// Whether any figure is distrusted.
    pub fn any(self) -> bool {
        self.moments || self.density
    }
}

/// The errors that a method claims.
#[derive(Debug, Clone, Copy)]
pub struct Claim {
    /// Errors of the moments, in standard deviations or products of them.
    pub moments: [f64; 5],
    /// Error of the probability above the critical eccentricity.
    pub above: f64,
    /// L1 error of the joint density; infinite if the method gives none.
    pub joint: f64,
}

/// A first-passage curve with the claims of the method about it.
#[derive(Debug)]
pub struct Curve {
    /// Times \[yr\].
    pub times: Vec<f64>,
    /// Probability, and the error that the method claims.
    pub points: Vec<(f64, f64)>,
}

/// Claimed error of a method that gives no error estimate, where its verdict is good.
pub const TOLERANCE: f64 = 0.01;
/// Factor by which an error may exceed its estimate.
const WITHIN: f64 = 10.0;
/// Number of standard errors within which a sample's figure must lie.
const STANDARD_ERRORS: f64 = 5.0;
/// Error from rounding and from the flow.
const ROUNDING: f64 = 1e-9;

/// Runs `method` on `problem`.
pub fn run(method: Method, problem: &Problem, grids: &[Grid]) -> Answer {
    let start = processor_seconds();
    let ran = catch_unwind(AssertUnwindSafe(|| match method {
        Method::Exact => exact(problem, grids),
        Method::Mesh(points) => mesh(problem, grids, points),
        Method::Mixture => gaussian_mixture(problem, grids),
        Method::MonteCarlo(samples) => monte_carlo(problem, grids, samples),
    }));
    let whole = ran.unwrap_or_else(|_| Err("it panicked".into()));
    let (snapshots, curve) =
        whole.unwrap_or_else(|why| (grids.iter().map(|_| Err(why.clone())).collect(), Some(Err(why.clone()))));
    Answer { snapshots, curve, seconds: processor_seconds() - start }
}

fn processor_seconds() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

type Parts = (Vec<Result<Shown, String>>, Option<Result<Curve, String>>);

/// Times of a curve: those of the problem and some between them.
fn times_of_curve(problem: &Problem) -> Vec<f64> {
    let mut times = curve_times(problem.times.last().copied().unwrap_or(0.0), 17);
    times.extend(&problem.times);
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}

fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

fn exact(problem: &Problem, grids: &[Grid]) -> Result<Parts, String> {
    let flow = Flow::new(problem.model);
    let exact = Exact::new(problem, &flow, ExactSettings::default());
    let snapshot = |index: usize| {
        let found = exact.snapshot(grids, index).map_err(text)?;
        let claim = Claim {
            moments: [WITHIN * found.moment_error + ROUNDING; 5],
            above: WITHIN * found.probability_error + ROUNDING,
            joint: WITHIN * found.joint_error + ROUNDING,
        };
        Ok(Shown {
            estimate: found.estimate,
            claim,
            says: [f64::NAN; 4],
            distrusted: Distrust::default(),
            mass_outside: Some(found.mass_outside),
        })
    };
    let snapshots = (0..grids.len()).map(snapshot).collect();
    let times = times_of_curve(problem);
    let curve = exact_curve(problem, &flow, &times).map_err(text).map(|curve| {
        let points = curve.iter().map(|p| (p.value, WITHIN * p.error + ROUNDING)).collect();
        Curve { times, points }
    });
    Ok((snapshots, Some(curve)))
}

const UNSAID: Claim = Claim { moments: [TOLERANCE; 5], above: TOLERANCE, joint: 2.0 * TOLERANCE };

fn mesh(problem: &Problem, grids: &[Grid], points: usize) -> Result<Parts, String> {
    const DEGREE: usize = 7;
    let Problem { initial, critical_e, .. } = problem;
    let flow = Flow::new(problem.model);
    let start = initial_points(problem, points, Placement::Lattice, 1).map_err(text)?;
    let mut orbits = Orbits::from_polar(flow, &start.phi, &start.e);
    let (mut phi, mut e) = (vec![0.0; orbits.len()], vec![0.0; orbits.len()]);
    let mesh = CarriedMesh::new(initial, &start.phi, &start.e, start.lattice, DEGREE).map_err(text)?;
    let mut snapshots = Vec::new();
    for (&time, grid) in problem.times.iter().zip(grids) {
        orbits.advance_to(time).map_err(text)?;
        orbits.read_out(&mut phi, &mut e);
        let found = mesh.estimate(&phi, &e, grid, *critical_e).map_err(text);
        snapshots.push(found.map(|(estimate, says)| {
            let says = [says.measure_defect, says.flipped_mass, says.truncated_mass, says.misplaced_mass];
            Shown {
                distrusted: Distrust::of(Diagnosis::mesh(says), estimate.circular.resultant),
                estimate,
                claim: UNSAID,
                says,
                mass_outside: None,
            }
        }));
    }
    let curve = mesh_curve(problem, &flow, &start, DEGREE);
    Ok((snapshots, Some(curve)))
}

fn mesh_curve(
    problem: &Problem,
    flow: &Flow<SrpJ2>,
    start: &density::mesh::Points,
    degree: usize,
) -> Result<Curve, String> {
    let times = times_of_curve(problem);
    let curve = passage_curve(problem, flow, start, degree, &times).map_err(text)?;
    Ok(Curve { points: curve.probability.into_iter().zip(curve.error).collect(), times })
}

fn gaussian_mixture(problem: &Problem, grids: &[Grid]) -> Result<Parts, String> {
    let flow = Flow::new(problem.model);
    let mut propagator =
        mixture::PlanarMixturePropagator::new(problem, &flow, &mixture::MixtureSettings::default()).map_err(text)?;
    let mut snapshot = |time: f64, grid: &Grid| {
        propagator.advance_to(time).map_err(text)?;
        let mixture = propagator.mixture();
        let beyond = problem.initial.mass_beyond_one();
        let says = [mixture.disagreement(), mixture::mass_below_zero(&mixture.components), 1.0, beyond];
        let estimate = mixture::estimate(&mixture.components, grid, problem.critical_e).map_err(text)?;
        let distrusted = Distrust::of(Diagnosis::mixture(says), estimate.circular.resultant);
        Ok(Shown { estimate, claim: UNSAID, says, distrusted, mass_outside: None })
    };
    Ok((problem.times.iter().zip(grids).map(|(&time, grid)| snapshot(time, grid)).collect(), None))
}

fn monte_carlo(problem: &Problem, grids: &[Grid], samples: usize) -> Result<Parts, String> {
    let times = times_of_curve(problem);
    let (x1, x2) = sampling::draw(&problem.initial, 1, samples);
    let mut orbits = Orbits::new(Flow::new(problem.model), x1, x2);
    let mut noted = vec![usize::MAX; samples];
    let note = |time| point(time, &times);
    let (mut phi, mut e) = (vec![0.0; samples], vec![0.0; samples]);
    let mut snapshots = Vec::new();
    for (&time, grid) in problem.times.iter().zip(grids) {
        let passages = Passages { passages: &mut noted, pending: usize::MAX, note: &note };
        orbits.advance_watching(time, problem.critical_e, passages).map_err(text)?;
        orbits.read_out(&mut phi, &mut e);
        let estimate = binning::estimate(&phi, &e, *grid, problem.critical_e);
        let [mean_phi, std_phi, mean_e, std_e, cov, above] =
            estimate.standard_errors.to_array().map(|error| STANDARD_ERRORS * error + ROUNDING);
        let [p, q] = [estimate.moments.std_phi, estimate.moments.std_e];
        let claim = Claim {
            moments: [mean_phi / p, std_phi / p, mean_e / q, std_e / q, cov / (p * q)],
            above: above.max(STANDARD_ERRORS * rare(samples)),
            joint: f64::INFINITY,
        };
        snapshots.push(Ok(Shown {
            estimate,
            claim,
            says: [f64::NAN; 4],
            distrusted: Distrust::default(),
            mass_outside: None,
        }));
    }
    let curve = curve_of_points(noted.iter().copied(), &times);
    let error = |p: f64| STANDARD_ERRORS * ((p * (1.0 - p) / samples as f64).sqrt() + rare(samples));
    Ok((snapshots, Some(Ok(Curve { points: curve.probability.iter().map(|&p| (p, error(p))).collect(), times }))))
}

/// The smallest probability that a sample can distinguish from 0, or from 1 by its complement.
fn rare(samples: usize) -> f64 {
    3.0 / samples as f64
}

//! The stack of carried meshes over an uncertain radiation parameter, against moments and probabilities that another
//! program computed by quadrature.

mod planar_reference;

use density::angle::nearest;
use density::estimate::Estimate;
use density::exact::ExactSettings;
use density::exact::leaves::ExactLeaves;
use density::first_passage::over_leaves::curve_on_lattices;
use density::flow::{Accuracy, Flow};
use density::grid::{Grid, grids_over_leaves};
use density::mesh::MeshDiagnostics;
use density::mesh::stack::{Layers, Stack, StackEstimate, cubic_lattice, layered_lattice};
use density::model::Model;
use density::model::planar::SrpJ2;
use density::model::uncertain_radiation::{Scale, UncertainRadiation};
use density::orbits::Orbits;
use density::problem::{InitialGaussian, Problem};
use density::sampling::draw_variables;
use density::uncertain::{Distribution, Spread, UncertainProblem, UncertainTask};
use planar_reference::{Snapshot, apart, relative_deviation_of_radiation};

/// Bins of the densities in each direction.
const BINS: usize = 40;

struct Carry<'a> {
    problem: &'a UncertainProblem,
    layers: &'a Layers,
    grids: Vec<Grid>,
    /// How much later the estimator believes that it is \[yr\].
    late: f64,
}

impl UncertainTask for Carry<'_> {
    type Output = Vec<StackEstimate>;

    fn with<S: Scale>(self, model: UncertainRadiation<S>) -> Self::Output {
        let Self { problem, layers, grids, late } = self;
        let points: Vec<[f64; 3]> = (0..layers.len()).map(|row| layers.point(row)).collect();
        let columns = [0, 1, 2].map(|k| points.iter().map(|point| point[k]).collect::<Vec<f64>>());
        let columns = columns.each_ref().map(Vec::as_slice);
        let flow = Flow { model, accuracy: Accuracy::Medium };
        let mut orbits = Orbits::from_variables(flow, &columns);
        let side = layers.plane.lattice.unwrap();
        let stack = Stack::new(problem, columns, side, 7).unwrap();
        let at = |(&time, grid): (&f64, &Grid)| {
            orbits.advance_to(time).unwrap();
            let mut found = [0, 1, 2].map(|_| vec![0.0; layers.len()]);
            orbits.read_out_columns(&mut found.each_mut().map(Vec::as_mut_slice));
            stack.estimate(&found[0], &found[1], grid, time + late).unwrap()
        };
        problem.plane.times.iter().zip(&grids).map(at).collect()
    }
}

/// The problem with those of its snapshots that end by `years`.
fn scenario(name: &str, years: f64) -> (UncertainProblem, Vec<Snapshot>) {
    let (mut plane, mut snapshots) = planar_reference::scenario(name);
    plane.times.retain(|time| *time <= years);
    snapshots.retain(|snapshot| snapshot.years <= years);
    let spread = Spread { relative: relative_deviation_of_radiation(name), distribution: Distribution::Gaussian };
    (UncertainProblem::new(plane, spread).unwrap(), snapshots)
}

/// How far the reference is off: 1e-5 in most; in `uncertain-3` too few values of the parameter make it worse, by as
/// much as it differs from `exact`, see `uncertain.rs`.
fn reference_error(name: &str, years: f64) -> f64 {
    match (name, years) {
        ("uncertain-3", 2.0) => 8.4e-4,
        ("uncertain-3", 1.5) => 2.5e-5,
        ("cliff", _) => 9e-5,
        _ => 1e-5,
    }
}

/// `PHASECLOUD_POINTS=1000000` takes so many points, to two years (six on the cliff), and prints how far the moments
/// are off; with `PHASECLOUD_SIDES=60x120` these are 120 layers of 60 by 60 points.
#[test]
fn the_stack_has_the_moments_of_the_reference_as_far_as_its_defect_says() {
    let wanted = std::env::var("PHASECLOUD_POINTS").ok().map(|text| text.parse::<usize>().unwrap());
    let cases = [("uncertain-1", 2.0), ("uncertain-3", 0.5)];
    let all = [("uncertain-1", 2.0), ("uncertain-3", 2.0), ("cliff", 6.0)];
    for (name, years) in if wanted.is_some() { all.to_vec() } else { cases.to_vec() } {
        let (problem, snapshots) = scenario(name, years);
        let sides = std::env::var("PHASECLOUD_SIDES").ok();
        let layers = match sides.as_deref().and_then(|sides| sides.split_once('x')) {
            Some((side, layers)) => layered_lattice(&problem, side.parse().unwrap(), layers.parse().unwrap()).unwrap(),
            None => cubic_lattice(&problem, wanted.unwrap_or(30_000)).unwrap(),
        };
        let grids = grids_over_leaves(&problem, BINS, BINS).unwrap();
        let found = problem.perform(Carry { problem: &problem, layers: &layers, grids, late: 0.0 });
        for (snapshot, found) in snapshots.iter().zip(&found) {
            let m = found.plane.moments;
            let difference = apart([m.mean_phi, m.std_phi, m.mean_e, m.std_e, m.cov_phi_e], snapshot.moments);
            let MeshDiagnostics { measure_defect, misplaced_mass, truncated_mass, .. } = found.diagnostics;
            let above = m.prob_above_critical_e - snapshot.above;
            println!(
                "{name} at {} yr: off by {difference:.1e}, probability above by {above:.1e}; defect {measure_defect:.1e}, misplaced \
                 {misplaced_mass:.1e}, left out {truncated_mass:.1e}",
                snapshot.years
            );
            let of_reference = reference_error(name, snapshot.years);
            assert!(difference < of_reference + measure_defect + truncated_mass, "{name} at {} yr", snapshot.years);
            let is_goal = name == "uncertain-1" && sides.is_none();
            assert!(!is_goal || difference < 5e-4, "{name} at {} yr: {difference:e}", snapshot.years);
            // Whatever the cloud, 1 % or a warning.
            assert!(
                difference < 0.01 || !found.diagnostics.is_resolved(),
                "{name} at {} yr: {difference:e}",
                snapshot.years
            );
            // No event's probability is off by more than the density.
            assert!(above.abs() < 1e-5 + misplaced_mass + measure_defect, "{name} at {} yr", snapshot.years);
            if snapshot.years == 0.0 {
                // All layers lie on one another.
                let Grid { phi, e } = found.plane.grid;
                let initial = &problem.plane.initial;
                let off = |bin: usize| {
                    let right =
                        initial.density(nearest(phi.centre(bin / BINS), initial.mean_phi), e.centre(bin % BINS));
                    (found.plane.joint[bin] - right).abs()
                };
                let distance = 0.5 * (0..BINS * BINS).map(off).sum::<f64>() * found.plane.grid.bin_area();
                println!("{name} at the start: {distance:.1e} from the Gaussian in total variation");
                // The density in the middle of a bin is not its mean over the bin.
                assert!(distance < 0.01 + misplaced_mass, "{name}: {distance:e}");
            }
            let third = found.third;
            assert!((third.mean / problem.mean() - 1.0).abs() < 1e-6, "the flow does not change the parameter");
            let marginal: f64 = found.plane.marginal_e.iter().sum::<f64>() * found.plane.grid.e.width();
            assert!((0.99..1.0 + 1e-9).contains(&marginal), "{name} at {} yr: {marginal}", snapshot.years);
        }
    }
}

/// Orbits of the problem's model tell at the points of the lattice whether that model has carried it. Here it has done
/// so for a shorter time.
#[test]
fn orbits_replace_polynomials_only_in_a_stack_that_the_model_has_carried() {
    let (problem, snapshots) = scenario("uncertain-1", 2.0);
    let layers = cubic_lattice(&problem, 30_000).unwrap();
    let grids = grids_over_leaves(&problem, BINS, BINS).unwrap();
    let [right, other] = [0.0, 0.1].map(|late| {
        let found = problem.perform(Carry { problem: &problem, layers: &layers, grids: grids.clone(), late });
        let StackEstimate { plane, diagnostics, .. } = found.last().unwrap().clone();
        let m = plane.moments;
        let expected = snapshots.last().unwrap().moments;
        let difference = apart([m.mean_phi, m.std_phi, m.mean_e, m.std_e, m.cov_phi_e], expected);
        println!("off by {difference:.1e}, defect {:.1e}", diagnostics.measure_defect);
        (difference, diagnostics.measure_defect)
    });
    assert!(right.0 < 5e-4 && right.1 < 5e-3, "{right:?}");
    assert!(other.1 > 10.0 * right.1 && other.0 < other.1, "polynomials alone, as they say themselves: {other:?}");
}

/// The reference is good to 1e-5, and to 9e-5 on the cliff.
#[test]
fn first_passages_of_the_lattices_are_those_of_the_reference_within_their_intervals() {
    let is_whole = std::env::var_os("PHASECLOUD_POINTS").is_some();
    let all = [("uncertain-1", 2.0), ("uncertain-3", 2.0), ("cliff", 6.0)];
    for (name, years) in if is_whole { all.to_vec() } else { vec![("uncertain-1", 0.5)] } {
        let (problem, snapshots) = scenario(name, years);
        let times = problem.plane.times.clone();
        let found = curve_on_lattices(&problem, Accuracy::Medium, (31, 7), &times).unwrap();
        for (passed, snapshot) in found.iter().zip(&snapshots) {
            let (probability, expected) = (passed.probability, snapshot.ever);
            println!("{name} by {} yr: {probability:?}, {expected}", snapshot.years);
            let tolerance = probability.error + if name == "cliff" { 9e-5 } else { 1e-5 };
            assert!((probability.value - expected).abs() < tolerance, "{name} by {} yr", snapshot.years);
            assert!(probability.error < 5e-3, "{name} by {} yr: {probability:?}", snapshot.years);
        }
    }
}

/// Densities of clouds that have been wound up for decades, of which the uncertain parameter moves layers by less than
/// a bin, against the exact ones.
#[test]
fn the_joint_density_is_the_exact_one_as_far_as_the_diagnostics_say() {
    for (relative, times) in [(0.001, vec![0.0]), (0.01, vec![20.0])] {
        let initial =
            InitialGaussian { mean_phi: 0.5, mean_e: 0.3, sigma_phi: 0.05, sigma_e: 0.005, correlation: -0.3 };
        let model = SrpJ2 { radiation: 0.03, oblateness: 1.2 }.into();
        let plane = Problem { model, initial, times: times.clone(), critical_e: 0.33 };
        let spread = Spread { relative, distribution: Distribution::Gaussian };
        let problem = UncertainProblem::new(plane, spread).unwrap();
        let grids = grids_over_leaves(&problem, BINS, BINS).unwrap();
        let layers = cubic_lattice(&problem, 150_000).unwrap();
        let found = problem.perform(Carry { problem: &problem, layers: &layers, grids: grids.clone(), late: 0.0 });
        let exact = ExactLeaves::new(problem.clone(), Accuracy::Medium, ExactSettings::default());
        for (index, found) in found.iter().enumerate() {
            let right = exact.snapshot(&grids, index).unwrap().plane;
            let pairs = found.plane.joint.iter().zip(&right.estimate.joint);
            let distance = 0.5 * pairs.map(|(a, b)| (a - b).abs()).sum::<f64>() * grids[index].bin_area();
            let misplaced = found.diagnostics.misplaced_mass;
            println!(
                "{relative} at {} yr: {distance:.1e}, misplaced {misplaced:.1e}, exact {:.1e}",
                times[index], right.joint_error
            );
            assert!(distance < misplaced + 0.5 * right.joint_error, "{relative} at {} yr: {distance:e}", times[index]);
            assert!(distance < 5e-3, "{relative} at {} yr: {distance:e}", times[index]);
        }
    }
}

/// A cloud that reaches round the circle: mean and deviation of the solar angle are those of the branch that is cut
/// opposite to the circular mean of the whole cloud, not of the mean that a few layers have.
#[test]
fn the_branch_of_a_cloud_round_the_circle_is_cut_opposite_to_its_mean() {
    let initial = InitialGaussian { mean_phi: 2.2, mean_e: 0.145, sigma_phi: 0.05, sigma_e: 0.005, correlation: 0.0 };
    let model = SrpJ2 { radiation: 0.15, oblateness: 0.40921 }.into();
    let plane = Problem { model, initial, times: vec![0.0, 2.0], critical_e: 0.6 };
    let spread = Spread { relative: 0.5, distribution: Distribution::LogNormal };
    let problem = UncertainProblem::new(plane, spread).unwrap();
    let grids = grids_over_leaves(&problem, BINS, BINS).unwrap();
    let layers = cubic_lattice(&problem, 100_000).unwrap();
    let found = problem.perform(Carry { problem: &problem, layers: &layers, grids, late: 0.0 });
    let StackEstimate { plane: Estimate { moments, circular, .. }, .. } = &found[1];
    let phi = problem.perform(Sampled { problem: &problem, years: 2.0 });
    // Of the sample, but on the branch of the estimate.
    let on_branch: Vec<f64> = phi.iter().map(|&phi| nearest(phi, circular.mean)).collect();
    let mean = on_branch.iter().sum::<f64>() / on_branch.len() as f64;
    let std = (on_branch.iter().map(|phi| (phi - mean).powi(2)).sum::<f64>() / on_branch.len() as f64).sqrt();
    println!("mean {} std {}, sample {mean} {std}", moments.mean_phi, moments.std_phi);
    // Five standard errors of a hundred thousand orbits, and what the mesh says it is off.
    let tolerance = 5.0 * std / (phi.len() as f64).sqrt() + 2e-3;
    assert!((moments.mean_phi - mean).abs() < tolerance, "{} {mean}", moments.mean_phi);
    assert!((moments.std_phi - std).abs() < tolerance, "{} {std}", moments.std_phi);
}

/// Orbits that start at random.
struct Sampled<'a> {
    problem: &'a UncertainProblem,
    years: f64,
}

impl UncertainTask for Sampled<'_> {
    type Output = Vec<f64>;

    fn with<S: Scale>(self, model: UncertainRadiation<S>) -> Self::Output {
        let variables = UncertainRadiation::<S>::VARIABLES;
        let start = draw_variables(&self.problem.gaussian(), variables, 3, 0..100_000);
        let mut orbits = Orbits::from_variables(Flow::new(model), &start.each_ref().map(Vec::as_slice));
        orbits.advance_to(self.years).unwrap();
        let mut found = [0, 1, 2].map(|_| vec![0.0; 100_000]);
        orbits.read_out_columns(&mut found.each_mut().map(Vec::as_mut_slice));
        let [phi, ..] = found;
        phi
    }
}

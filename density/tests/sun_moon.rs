//! Tests of every method in the paper's scenarios with the gravity of the Sun and the Moon.
//!
//! The reference is moments and probabilities that another program computed by quadrature over the initial Gaussian.

mod planar_reference;

use std::num::NonZeroUsize;

use density::exact::{Error, Exact, ExactSettings};
use density::first_passage::exact::exact_curve;
use density::first_passage::passage_times;
use density::flow::{Accuracy, Flow};
use density::grid::comparison_grids;
use density::mesh::{CarriedMesh, Placement, initial_points};
use density::mixture::{self, PlanarMixturePropagator};
use density::model::registry::Planar;
use density::orbits::Orbits;
use density::problem::{InitialGaussian, Problem};
use density::sampling::{Draws, SamplingPlan};
use planar_reference::{apart, scenario};

/// The scenarios of the reference without uncertain parameters. In `correlated-1` the pull of the Sun and the Moon
/// is 0.
const SCENARIOS: [&str; 4] = ["sun-moon-1", "sun-moon-2", "sun-moon-3", "correlated-1"];

fn five(moments: density::estimate::Moments) -> [f64; 5] {
    [moments.mean_phi, moments.std_phi, moments.mean_e, moments.std_e, moments.cov_phi_e]
}

#[test]
fn the_exact_density_has_the_moments_and_probabilities_of_the_reference() {
    for name in SCENARIOS {
        let (problem, snapshots) = scenario(name);
        let flow = Flow::new(problem.model);
        let exact = Exact::new(&problem, &flow, ExactSettings::default());
        let curve = exact_curve(&problem, &flow, &problem.times).unwrap();
        for (snapshot, ever) in snapshots.iter().zip(curve) {
            let found = exact.moments(snapshot.years).unwrap();
            let found = [found.mean_phi, found.std_phi, found.mean_e, found.std_e, found.cov_phi_e];
            let difference = apart(found, snapshot.moments);
            // The reference is accurate to 1e-6 of a mean, and a mean is up to 60 standard deviations.
            assert!(difference < 2e-5, "{name} at {}: {difference:e}", snapshot.years);
            let above = exact.probability_above(problem.critical_e, snapshot.years).unwrap();
            assert!((above.value - snapshot.above).abs() < 1e-6, "{name} at {}", snapshot.years);
            assert!((ever.value - snapshot.ever).abs() < 1e-6, "{name} at {}: ever", snapshot.years);
        }
    }
}

#[test]
fn the_exact_joint_density_agrees_with_a_sample_of_orbits_and_adds_up_to_one() {
    let (problem, _) = scenario("sun-moon-2");
    let flow = Flow::new(problem.model);
    let grids = comparison_grids(&problem, &flow, 40, 40).unwrap();
    let exact = Exact::new(&problem, &flow, ExactSettings::default());
    let snapshot = exact.snapshot(&grids, 3).unwrap();
    assert!((snapshot.estimate.mass() + snapshot.mass_outside - 1.0).abs() < 1e-6);
    assert!(snapshot.joint_error < 1e-3, "{}", snapshot.joint_error);
}

#[test]
fn monte_carlo_has_the_moments_and_passages_of_the_reference() {
    const SAMPLES: usize = 1 << 15;
    for name in ["sun-moon-1", "correlated-1"] {
        let (problem, snapshots) = scenario(name);
        let flow = Flow { model: problem.model, accuracy: Accuracy::Medium };
        let plan = SamplingPlan { draws: Draws::Sobol, seed: 1, replicates: NonZeroUsize::MIN };
        let (x1, x2) = plan.draw(&problem.initial, SAMPLES);
        let passages = passage_times(&flow, &x1, &x2, problem.critical_e, 2.0).unwrap();
        let mut orbits = Orbits::new(flow, x1, x2);
        for snapshot in &snapshots {
            orbits.advance_to(snapshot.years).unwrap();
            let (mut phi, mut e) = (vec![0.0; SAMPLES], vec![0.0; SAMPLES]);
            orbits.read_out(&mut phi, &mut e);
            let (moments, _) = density::estimate::weighted_moments(&phi, &e, None, problem.critical_e);
            let difference = apart(five(moments), snapshot.moments);
            assert!(difference < 0.01, "{name} at {}: {difference}", snapshot.years);
            let passed = passages.iter().filter(|&&time| time <= snapshot.years).count() as f64 / SAMPLES as f64;
            assert!((passed - snapshot.ever).abs() < 2e-3, "{name} at {}: {passed}", snapshot.years);
        }
    }
}

#[test]
fn the_carried_mesh_and_the_mixture_have_the_moments_of_the_reference() {
    for name in SCENARIOS {
        let (problem, snapshots) = scenario(name);
        let flow = Flow::new(problem.model);
        let grids = comparison_grids(&problem, &flow, 20, 20).unwrap();
        let start = initial_points(&problem, 961, Placement::Lattice, 0).unwrap();
        let mesh = CarriedMesh::new(&problem.initial, &start.phi, &start.e, start.lattice, 7).unwrap();
        let mut orbits = Orbits::from_polar(flow, &start.phi, &start.e);
        let mut propagator =
            PlanarMixturePropagator::new(&problem, &flow, &mixture::MixtureSettings::default()).unwrap();
        for (snapshot, grid) in snapshots.iter().zip(&grids) {
            orbits.advance_to(snapshot.years).unwrap();
            let (mut phi, mut e) = (start.phi.clone(), start.e.clone());
            orbits.read_out(&mut phi, &mut e);
            let (estimate, _) = mesh.estimate(&phi, &e, grid, problem.critical_e).unwrap();
            let difference = apart(five(estimate.moments), snapshot.moments);
            assert!(difference < 2e-3, "mesh, {name} at {}: {difference:e}", snapshot.years);
            propagator.advance_to(snapshot.years).unwrap();
            let (moments, _) = mixture::moments::moments(&propagator.mixture().components, problem.critical_e).unwrap();
            let difference = apart(five(moments), snapshot.moments);
            assert!(difference < 5e-3, "mixture, {name} at {}: {difference:e}", snapshot.years);
        }
    }
}

#[test]
fn the_exact_density_says_so_where_the_sun_outweighs_the_radiation() {
    let (problem, _) = scenario("sun-moon-1");
    let weak = [("radiation", 1e-3), ("oblateness", 0.4), ("sun", 1e-3), ("moon", 1e-3)];
    let problem = Problem { model: Planar::by_name("planar-sun-moon", &weak).unwrap(), ..problem };
    let flow = Flow::new(problem.model);
    let refused = Exact::new(&problem, &flow, ExactSettings::default()).moments(1.0).unwrap_err();
    assert!(matches!(refused, Error::EccentricityTurnsBack { .. }), "{refused}");
}

/// A correlated cloud that the cut at `e = 0` changes, on the branch cut and wide: its joint density at the start and
/// its moments agree with a fine Sobol sample, and at the start with each other.
#[test]
fn a_correlated_cloud_agrees_with_its_own_sample() {
    const SAMPLES: usize = 1 << 17;
    let (correlated, _) = scenario("correlated-1");
    for (correlation, mean_phi, mean_e, sigma_phi) in [(0.9, 6.2, 0.04, 0.3), (-0.6, 1.0, 0.2, 1.2)] {
        let initial = InitialGaussian { mean_phi, mean_e, sigma_phi, sigma_e: 0.03, correlation };
        let problem = Problem { initial, times: vec![0.0, 0.7], ..correlated.clone() };
        let flow = Flow::new(problem.model);
        let grids = comparison_grids(&problem, &flow, 12, 12).unwrap();
        let exact = Exact::new(&problem, &flow, ExactSettings::default());
        let plan = SamplingPlan { draws: Draws::Sobol, seed: 3, replicates: NonZeroUsize::MIN };
        let (x1, x2) = plan.draw(&initial, SAMPLES);
        let mut orbits = Orbits::new(flow, x1, x2);
        for (index, &years) in problem.times.iter().enumerate() {
            orbits.advance_to(years).unwrap();
            let (mut phi, mut e) = (vec![0.0; SAMPLES], vec![0.0; SAMPLES]);
            orbits.read_out(&mut phi, &mut e);
            let sampled = density::binning::estimate(&phi, &e, grids[index], problem.critical_e);
            let snapshot = exact.snapshot(&grids, index).unwrap();
            assert!(snapshot.moment_error < 1e-7 && snapshot.joint_error < 1e-3, "{years}: {snapshot:?}");
            let difference = apart(five(sampled.moments), five(snapshot.estimate.moments));
            assert!(difference < 2e-3, "{correlation} at {years}: {difference:e}");
            let area = grids[index].bin_area();
            let variation: f64 =
                sampled.joint.iter().zip(&snapshot.estimate.joint).map(|(a, b)| 0.5 * (a - b).abs() * area).sum();
            assert!(variation < 5e-3, "{correlation} at {years}: {variation:e}");
        }
    }
}

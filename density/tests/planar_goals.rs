//! The carried mesh and the mixture at their defaults, and first passages, in the scenarios with the gravity of the Sun
//! and the Moon and with a correlated start, against moments and probabilities that another program computed by
//! quadrature.

mod planar_reference;

use density::first_passage::exact::exact_curve;
use density::flow::Flow;
use density::grid::{Grid, comparison_grids};
use density::mesh::passage::passage_curve;
use density::mesh::{CarriedMesh, Placement, initial_points};
use density::mixture::{self, MixtureSettings, PlanarMixturePropagator};
use density::model::registry::Planar;
use density::orbits::Orbits;
use density::problem::Problem;
use planar_reference::{apart, scenario};

const SCENARIOS: [&str; 4] = ["sun-moon-1", "sun-moon-2", "sun-moon-3", "correlated-1"];
/// Largest error of a moment, in standard deviations or products of them.
const MOMENTS: f64 = 5e-4;
/// Largest error of the probability of having re-entered.
const EVER: f64 = 1e-4;

/// The grids are coarse: nothing is asked of the densities here.
fn grids(problem: &Problem<Planar>) -> Vec<Grid> {
    comparison_grids(problem, &Flow::new(problem.model), 10, 10).unwrap()
}

#[test]
fn the_carried_mesh_has_every_moment_to_a_two_thousandth() {
    for name in SCENARIOS {
        let (problem, snapshots) = scenario(name);
        let points = initial_points(&problem, 10_000, Placement::Lattice, 0).unwrap();
        let mesh = CarriedMesh::new(&problem.initial, &points.phi, &points.e, points.lattice, 7).unwrap();
        let mut orbits = Orbits::from_polar(Flow::new(problem.model), &points.phi, &points.e);
        let (mut phi, mut e) = (points.phi.clone(), points.e.clone());
        for (snapshot, grid) in snapshots.iter().zip(grids(&problem)) {
            orbits.advance_to(snapshot.years).unwrap();
            orbits.read_out(&mut phi, &mut e);
            let m = mesh.estimate(&phi, &e, &grid, problem.critical_e).unwrap().0.moments;
            let difference = apart([m.mean_phi, m.std_phi, m.mean_e, m.std_e, m.cov_phi_e], snapshot.moments);
            println!("dee, {name} at {} yr: {difference:.1e}", snapshot.years);
            assert!(difference < MOMENTS, "{name} at {} yr: {difference:e}", snapshot.years);
        }
    }
}

#[test]
fn the_adaptive_mixture_has_every_moment_to_a_two_thousandth() {
    for name in SCENARIOS {
        let (problem, snapshots) = scenario(name);
        let flow = Flow::new(problem.model);
        let mut propagator = PlanarMixturePropagator::new(&problem, &flow, &MixtureSettings::default()).unwrap();
        for (snapshot, grid) in snapshots.iter().zip(grids(&problem)) {
            propagator.advance_to(snapshot.years).unwrap();
            let mixture = propagator.mixture();
            let m = mixture::estimate(&mixture.components, &grid, problem.critical_e).unwrap().moments;
            let difference = apart([m.mean_phi, m.std_phi, m.mean_e, m.std_e, m.cov_phi_e], snapshot.moments);
            println!("gmm-ut, {name} at {} yr: {difference:.1e}", snapshot.years);
            assert!(difference < MOMENTS, "{name} at {} yr: {difference:e}", snapshot.years);
        }
    }
}

#[test]
fn the_probability_of_having_re_entered_is_right_to_a_ten_thousandth() {
    for name in SCENARIOS {
        let (problem, snapshots) = scenario(name);
        let flow = Flow::new(problem.model);
        let exact = exact_curve(&problem, &flow, &problem.times).unwrap();
        let points = initial_points(&problem, 2_500, Placement::Lattice, 0).unwrap();
        let mesh = passage_curve(&problem, &flow, &points, 7, &problem.times).unwrap();
        for (k, snapshot) in snapshots.iter().enumerate() {
            let [exact, mesh] = [exact[k].value, mesh.probability[k]].map(|p| (p - snapshot.ever).abs());
            println!("{name} by {} yr: exact {exact:.1e}, dee {mesh:.1e}", snapshot.years);
            assert!(exact < EVER && mesh < EVER, "{name} by {} yr: {exact:e} {mesh:e}", snapshot.years);
        }
    }
}

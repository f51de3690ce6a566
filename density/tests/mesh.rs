//! Tests of the mesh methods against exact moments, the exact density and the paper's Table 3.

mod mesh_support;

use density::mesh::{
    Branch, CarriedMesh, MeshDiagnostics, MeshError, Placement, characteristic_densities, hull_estimate,
    initial_points, lattice_points,
};
use density::{estimate::Estimate, flow::Flow, grid::comparison_grids, model::plane::State, problem::Problem};
use mesh_support::{Snapshot, exact_joint, exact_moments, l1, paper_table_3, propagate, relative_errors, scenario};

/// Estimates of a carried mesh at every snapshot.
fn carried(
    problem: &Problem,
    count: usize,
    placement: Placement,
    degree: usize,
) -> Vec<(Snapshot, Estimate, MeshDiagnostics)> {
    let (points, snapshots) = propagate(problem, count, placement, 1);
    let mesh = CarriedMesh::new(&problem.initial, &points.phi, &points.e, points.lattice, degree).unwrap();
    let estimate = |s: Snapshot| {
        let (estimate, diagnostics) = mesh.estimate(&s.phi, &s.e, &s.grid, problem.critical_e).unwrap();
        (s, estimate, diagnostics)
    };
    snapshots.into_iter().map(estimate).collect()
}

/// Fails unless mean and standard deviation of both coordinates are within `tolerance` (relative).
fn assert_moments(number: usize, s: &Snapshot, estimate: &Estimate, tolerance: f64) {
    let exact = exact_moments(number, s.time);
    let errors = relative_errors(&estimate.moments, &exact);
    assert!(errors.iter().all(|&error| error < tolerance), "scenario {number}, t = {}: {errors:?}", s.time);
}

#[test]
fn carried_lattice_of_961_points_keeps_every_moment_to_a_hundredth_of_a_per_cent() {
    for number in 1..=3 {
        for (s, estimate, diagnostics) in carried(&scenario(number), 961, Placement::Lattice, 7) {
            assert_moments(number, &s, &estimate, 1e-4);
            let above = exact_moments(number, s.time).prob_above_critical_e;
            assert!((estimate.moments.prob_above_critical_e - above).abs() < 2e-6);
            assert!(diagnostics.is_resolved(), "{diagnostics:?}");
        }
    }
}

#[test]
fn carried_straight_triangles_over_961_lattice_points_keep_every_moment_to_seven_tenths_of_a_per_cent() {
    for number in 1..=3 {
        let problem = scenario(number);
        let flow = Flow::new(problem.model);
        let points = lattice_points(&problem, 31, 4.2).unwrap();
        let mesh = CarriedMesh::new(&problem.initial, &points.phi, &points.e, points.lattice, 1).unwrap();
        let grids = comparison_grids(&problem, &flow, 100, 100).unwrap();
        for (&time, grid) in problem.times.iter().zip(grids) {
            let start = points.phi.iter().zip(&points.e).map(|(&phi, &e)| State::from_polar(phi, e));
            let (mut x1, mut x2): (Vec<f64>, Vec<f64>) = start.map(|state| (state.x1, state.x2)).unzip();
            flow.advance(&mut x1, &mut x2, time).unwrap();
            let end: Vec<State> = x1.iter().zip(&x2).map(|(&x1, &x2)| State { x1, x2 }).collect();
            let phi: Vec<f64> = end.iter().map(|state| state.solar_angle()).collect();
            let e: Vec<f64> = end.iter().map(|state| state.eccentricity()).collect();
            let (estimate, _) = mesh.estimate(&phi, &e, &grid, problem.critical_e).unwrap();
            if number == 1 && time == 1.0 {
                let exact = exact_joint(&problem, time, &grid, [8, 16]);
                assert!(l1(&estimate, &exact) < 0.15, "{}", l1(&estimate, &exact));
            }
            assert_moments(number, &Snapshot { time, grid, x1, x2, phi, e }, &estimate, 7e-3);
        }
    }
}

#[test]
fn carried_lattice_of_1e5_points_keeps_every_moment_to_a_hundredth_of_a_per_cent_at_any_degree() {
    for number in 1..=3 {
        for degree in [1, 7] {
            for (s, estimate, diagnostics) in carried(&scenario(number), 100_000, Placement::Lattice, degree) {
                assert_moments(number, &s, &estimate, 1e-4);
                assert!(degree == 1 || diagnostics.measure_defect < 1e-5, "{diagnostics:?}");
            }
        }
    }
}

/// The snapshots in which the cloud is stretched most, and how finely bins are sampled for their exact density.
const HARDEST: [(usize, f64, [usize; 2]); 5] =
    [(1, 1.0, [8, 16]), (1, 2.0, [8, 8]), (2, 1.5, [32, 32]), (2, 3.0, [8, 8]), (3, 2.0, [8, 8])];

fn assert_joint(count: usize, degree: usize, tolerance: f64) {
    for number in 1..=3 {
        let problem = scenario(number);
        for (s, estimate, _) in carried(&problem, count, Placement::Lattice, degree) {
            let Some(&(.., fineness)) = HARDEST.iter().find(|&&(k, time, _)| k == number && time == s.time) else {
                continue;
            };
            let exact = exact_joint(&problem, s.time, &s.grid, fineness);
            let distance = l1(&estimate, &exact);
            assert!(distance < tolerance, "scenario {number}, t = {}: L1 = {distance}", s.time);
        }
    }
}

#[test]
fn joint_density_of_a_carried_lattice_of_961_points_is_within_half_a_per_cent() {
    assert_joint(961, 7, 5e-3);
}

#[test]
fn joint_density_of_a_carried_lattice_of_1e5_points_is_within_half_a_per_cent() {
    assert_joint(100_000, 1, 5e-3);
}

#[test]
fn carried_random_points_lose_no_more_than_the_tails_beyond_them() {
    for (s, estimate, diagnostics) in carried(&scenario(1), 100_000, Placement::Random, 1) {
        assert!(diagnostics.truncated_mass < 3e-4, "{diagnostics:?}");
        assert_moments(1, &s, &estimate, 2e-3);
    }
}

#[test]
fn a_mesh_too_coarse_for_scenario_two_at_one_and_a_half_years_says_so() {
    for (placement, degree) in [(Placement::Lattice, 1), (Placement::Random, 1), (Placement::Lattice, 3)] {
        let found = carried(&scenario(2), 225, placement, degree);
        let (early, worst) = (&found[1].2, &found[3].2);
        assert!(found[3].0.time == 1.5 && !worst.is_resolved(), "{placement:?} {worst:?}");
        assert!(early.measure_defect < 0.1 * worst.measure_defect, "{early:?}");
    }
}

#[test]
fn as_printed_hull_of_1e5_random_samples_reproduces_table_3() {
    let problem = scenario(1);
    let (points, snapshots) = propagate(&problem, 100_000, Placement::Random, 1);
    for s in snapshots {
        let n = characteristic_densities(&problem.initial, &points.phi, &points.e, &s.x1, &s.x2, false).unwrap();
        let hull = hull_estimate(&s.phi, &s.e, &n, &s.grid, 5000, Branch::AsPrinted, problem.critical_e).unwrap();
        let m = hull.moments;
        let found = [m.mean_phi, m.std_phi, m.mean_e, m.std_e];
        let paper = paper_table_3("dee-1e5", s.time);
        // At one and two years the slivers along the hull depend on the outermost few samples, so that two draws differ
        // by chance. The tolerance is four times the standard deviation over seeds 0 to 19 (example `table_3_spread`).
        let tolerance = match s.time {
            1.0 => [4.69e-3, 4.28e-3, 2.11e-4, 3.01e-4].map(|spread| 4.0 * spread),
            2.0 => [1.25e-3, 3.84e-4, 3.92e-4, 7.36e-4].map(|spread| 4.0 * spread),
            _ => paper.map(|value| 5e-3 * value),
        };
        for k in 0..4 {
            assert!((found[k] - paper[k]).abs() < tolerance[k], "t = {}: {found:?}, paper {paper:?}", s.time);
        }
        assert!((hull.mass() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn with_the_jacobian_the_hull_is_right_where_the_cloud_is_convex_and_too_wide_where_it_is_bent() {
    let problem = scenario(1);
    let (points, snapshots) = propagate(&problem, 100_000, Placement::Random, 1);
    let mesh = CarriedMesh::new(&problem.initial, &points.phi, &points.e, None, 1).unwrap();
    for s in snapshots {
        let n = characteristic_densities(&problem.initial, &points.phi, &points.e, &s.x1, &s.x2, true).unwrap();
        let hull = hull_estimate(&s.phi, &s.e, &n, &s.grid, 1000, Branch::Grid, problem.critical_e).unwrap();
        if s.time == 1.0 || s.time == 2.0 {
            let exact = exact_moments(1, s.time);
            let (carried, _) = mesh.estimate(&s.phi, &s.e, &s.grid, problem.critical_e).unwrap();
            let excess = hull.moments.std_e / exact.std_e - 1.0;
            assert!(excess > 0.01, "t = {}: {excess}", s.time);
            assert!((carried.moments.std_e / exact.std_e - 1.0).abs() < 0.1 * excess, "t = {}", s.time);
        } else {
            assert_moments(1, &s, &hull, 5e-3);
        }
    }
}

#[test]
fn results_are_the_same_bytes_for_any_number_of_threads() {
    let problem = scenario(1);
    let run = || {
        let (points, snapshots) = propagate(&problem, 5000, Placement::Random, 4);
        let s = &snapshots[4];
        let n = characteristic_densities(&problem.initial, &points.phi, &points.e, &s.x1, &s.x2, true).unwrap();
        let hull = hull_estimate(&s.phi, &s.e, &n, &s.grid, 1000, Branch::Grid, problem.critical_e).unwrap();
        let scattered = CarriedMesh::new(&problem.initial, &points.phi, &points.e, None, 1).unwrap();
        let (carried, _) = scattered.estimate(&s.phi, &s.e, &s.grid, problem.critical_e).unwrap();
        let (points, snapshots) = propagate(&problem, 400, Placement::Lattice, 4);
        let s = &snapshots[4];
        let lattice = CarriedMesh::new(&problem.initial, &points.phi, &points.e, points.lattice, 5).unwrap();
        let (lattice, diagnostics) = lattice.estimate(&s.phi, &s.e, &s.grid, problem.critical_e).unwrap();
        (hull, carried, lattice, diagnostics)
    };
    let with = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run);
    // Compared as text, which shows every bit of a number and treats NaN as equal to NaN.
    assert!(format!("{:?}", with(1)) == format!("{:?}", with(3)));
}

#[test]
fn wrong_columns_are_named_not_panicked_on() {
    let problem = scenario(1);
    let points = initial_points(&problem, 100, Placement::Lattice, 0).unwrap();
    let new = |phi: &[f64], lattice, degree| CarriedMesh::new(&problem.initial, phi, &points.e, lattice, degree);
    assert!(matches!(new(&points.phi[1..], Some(10), 3), Err(MeshError::Length { column: "e", .. })));
    assert!(matches!(new(&points.phi, Some(9), 3), Err(MeshError::Length { .. })));
    assert!(matches!(new(&points.phi, Some(10), 10), Err(MeshError::Degree { .. })));
    let mut moved = points.phi.clone();
    moved[57] += 0.01;
    assert_eq!(new(&moved, Some(10), 3).unwrap_err(), MeshError::NotALattice { side: 10, row: 57 });
    let mesh = new(&points.phi, Some(10), 3).unwrap();
    let grid = comparison_grids(&problem, &Flow::new(problem.model), 10, 10).unwrap()[0];
    let mut e = points.e.clone();
    e[3] = f64::NAN;
    let error = mesh.estimate(&points.phi, &e, &grid, 0.6).unwrap_err();
    assert!(matches!(error, MeshError::Value { column: "e", row: 3, .. }));
}

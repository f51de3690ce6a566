//! Prints the errors of the mesh methods in the paper's three scenarios, and the time they take.
//!
//! `cargo run --release -p phasecloud-experiments --bin mesh_report -- [points] [random|lattice|low-discrepancy]
//! [degree]`

#[path = "../../../density/tests/mesh_support/mod.rs"]
mod mesh_support;

use std::time::Instant;

use density::mesh::delaunay::triangulate;
use density::mesh::raster::PointGrid;
use density::mesh::{Branch, CarriedMesh, Placement, characteristic_densities, hull_estimate};
use mesh_support::{exact_joint, exact_moments, l1, propagate, relative_errors, scenario};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, default: usize| arguments.get(k).and_then(|text| text.parse().ok()).unwrap_or(default);
    let (count, degree, seed) = (number(0, 961), number(2, 5), number(3, 1));
    let placement = match arguments.get(1).map(String::as_str) {
        Some("random") => Placement::Random,
        Some("low-discrepancy") => Placement::LowDiscrepancy,
        _ => Placement::Lattice,
    };
    println!("{count} points, {placement:?}, degree {degree}; relative errors in per cent");
    println!(
        "s  t    | carried: mu_phi  sd_phi  mu_e    sd_e    dP(e>c)   L1      defect  flipped trunc  | hull L1 | ms carried, hull, of which raster"
    );
    for k in 1..=3 {
        let problem = scenario(k);
        let (points, snapshots) = propagate(&problem, count, placement, seed as u64);
        let start = Instant::now();
        let mesh = CarriedMesh::new(&problem.initial, &points.phi, &points.e, points.lattice, degree).unwrap();
        println!("   mesh built in {:.1} ms", start.elapsed().as_secs_f64() * 1e3);
        for s in snapshots {
            let exact = exact_joint(&problem, s.time, &s.grid, [number(4, 8), number(5, 8)]);
            let moments = exact_moments(k, s.time);
            let ((carried, diagnostics), carried_ms) =
                fastest(|| mesh.estimate(&s.phi, &s.e, &s.grid, problem.critical_e).unwrap());
            let n = characteristic_densities(&problem.initial, &points.phi, &points.e, &s.x1, &s.x2, true).unwrap();
            let (hull, hull_ms) =
                fastest(|| hull_estimate(&s.phi, &s.e, &n, &s.grid, 5000, Branch::Grid, problem.critical_e).unwrap());
            let fine = PointGrid::new(&s.grid, 5000).unwrap();
            let triangles = triangulate(&s.phi, &s.e).unwrap();
            let corner = |row: u32| [s.grid.fold(s.phi[row as usize]), s.e[row as usize], n[row as usize]];
            let (_, raster_ms) = fastest(|| fine.bin_means(triangles.len(), |k| triangles[k].map(corner)));
            let [a, b, c, d] = relative_errors(&carried.moments, &moments).map(|error| 100.0 * error);
            let above = carried.moments.prob_above_critical_e - moments.prob_above_critical_e;
            println!(
                "{k}  {:.1}  | {a:14.5} {b:7.5} {c:7.5} {d:7.5} {above:9.1e} {:7.3} {:8.5} {:6} {:8.1e} | {:7.3} | {carried_ms:6.1} {hull_ms:6.1} {raster_ms:6.1}  mass exact {:.5} carried {:.5}",
                s.time,
                100.0 * l1(&carried, &exact),
                diagnostics.measure_defect,
                diagnostics.flipped_elements,
                diagnostics.truncated_mass,
                100.0 * l1(&hull, &exact),
                exact.iter().sum::<f64>() * s.grid.bin_area(),
                carried.mass(),
            );
        }
    }
}

/// The value, and the shortest of a few measured times \[ms\].
fn fastest<T>(work: impl Fn() -> T) -> (T, f64) {
    let run = || {
        let start = Instant::now();
        let value = work();
        (value, start.elapsed().as_secs_f64() * 1e3)
    };
    (0..3).map(|_| run()).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_else(run)
}

//! Our part of the comparison with other programs: writes the samples from which all start, and times our kernels.
//!
//! Run by `benches/peers/compare.py`; by hand: `cargo run --release -p phasecloud-experiments --bin for_peers -- FOLDER
//! 5`. Files are little-endian f64, column after column, and u32 for triangles. Every time is printed as a line
//! `stage,level,threads,seconds`, the median of the given number of runs: CPU time on one thread, which other programs
//! on the machine disturb less, and wall time on two.

mod common;

use std::path::Path;
use std::time::Instant;

use common::{cpu, paper};
use density::flow::{Accuracy, Flow};
use density::grid::comparison_grids;
use density::mesh::delaunay::triangulate;
use density::mesh::raster::PointGrid;
use density::mesh::{Placement, characteristic_densities, initial_points};
use density::orbits::Orbits;
use rayon::ThreadPoolBuilder;

const SAMPLES: usize = 100_000;
const RESOLUTION: usize = 5000;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, folder, repeats] = &arguments[..] else { panic!("give a folder and a number of repeats") };
    let (folder, repeats) = (Path::new(folder), repeats.parse().expect("a number of repeats"));
    let problem = paper(1, vec![0.0, 0.5, 1.0, 1.5, 2.0]);
    let force = problem.model;
    let start = initial_points(&problem, SAMPLES, Placement::Random, 1).expect("points");
    let orbits = |accuracy| Orbits::from_polar(Flow { model: force, accuracy }, &start.phi, &start.e);
    let first = orbits(Accuracy::Fine);
    write(&folder.join("start.f64"), &[first.x1(), first.x2()]);

    for accuracy in Accuracy::ALL {
        let propagate = || {
            let mut orbits = orbits(accuracy);
            let mut states = Vec::new();
            for &time in &problem.times[1..] {
                orbits.advance_to(time).expect("no orbit is lost");
                states.push((orbits.x1().to_vec(), orbits.x2().to_vec()));
            }
            states
        };
        let level = format!("{:e}", accuracy.largest_error());
        let columns: Vec<Vec<f64>> = propagate().into_iter().flat_map(|(x1, x2)| [x1, x2]).collect();
        write(&folder.join(format!("ours-{level}.f64")), &columns.iter().map(Vec::as_slice).collect::<Vec<_>>());
        time("propagate", &level, repeats, propagate);
    }

    let mut last = orbits(Accuracy::Fine);
    last.advance_to(2.0).expect("no orbit is lost");
    let (mut phi, mut e) = (vec![0.0; SAMPLES], vec![0.0; SAMPLES]);
    last.read_out(&mut phi, &mut e);
    let n = characteristic_densities(&problem.initial, &start.phi, &start.e, last.x1(), last.x2(), true)
        .expect("densities");
    let grid = comparison_grids(&problem, &first.flow, 100, 100).expect("grids")[4];
    phi.iter_mut().for_each(|phi| *phi = grid.fold(*phi));
    write(&folder.join("cloud.f64"), &[&phi, &e, &n]);
    write(&folder.join("grid.f64"), &[&[grid.phi.low, grid.phi.high, grid.e.low, grid.e.high]]);
    time("bin", "", 20 * repeats, || grid.count(&phi, &e));
    let triangles = triangulate(&phi, &e).expect("triangles");
    time("triangulate", "", repeats, || triangulate(&phi, &e));
    let corners: Vec<u8> = triangles.as_flattened().iter().flat_map(|corner| corner.to_le_bytes()).collect();
    std::fs::write(folder.join("triangles.u32"), corners).expect("room for the triangles");
    let points = PointGrid::new(&grid, RESOLUTION).expect("points");
    let corner = |row: u32| [phi[row as usize], e[row as usize], n[row as usize]];
    let bins = || points.bin_means(triangles.len(), |k| triangles[k].map(corner));
    write(&folder.join("ours-bins.f64"), &[&bins()]);
    time("interpolate", "", repeats, bins);
}

/// Prints the median time of `work` on one and on two threads.
fn time<T: Send>(stage: &str, level: &str, repeats: usize, work: impl Fn() -> T + Sync) {
    for threads in [1, 2] {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let mut seconds: Vec<f64> = (0..repeats.max(1))
            .map(|_| {
                let (wall, before) = (Instant::now(), cpu());
                let result = pool.install(&work);
                let seconds = if threads == 1 { cpu() - before } else { wall.elapsed().as_secs_f64() };
                drop(result);
                seconds
            })
            .collect();
        seconds.sort_by(f64::total_cmp);
        println!("{stage},{level},{threads},{}", seconds[seconds.len() / 2]);
    }
}

fn write(path: &Path, columns: &[&[f64]]) {
    let bytes: Vec<u8> = columns.iter().copied().flatten().flat_map(|value| value.to_le_bytes()).collect();
    std::fs::write(path, bytes).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
}

//! Times of the kernels on scenario 1: `cargo bench`, or `cargo bench -- NAME` for some of them. See
//! docs/performance.md.
//!
//! Every time is wall time on the given number of threads, for the cloud of the paper's launch file.

use std::f64::consts::PI;
use std::num::NonZeroUsize;
use std::sync::LazyLock;

use density::exact::{Exact, ExactSettings};
use density::first_passage::times::first_passage_times;
use density::flow::{Accuracy, Flow};
use density::flow_map::{FlowMap, MappedOrbits, Settings as MapSettings};
use density::grid::{Grid, comparison_grids};
use density::mesh::delaunay::triangulate;
use density::mesh::raster::PointGrid;
use density::mesh::{Branch, CarriedMesh, Placement, characteristic_densities, hull_estimate, initial_points};
use density::mixture::{self, PlanarMixturePropagator};
use density::model::planar::SrpJ2;
use density::model::plane::State;
use density::model::sun_moon::SunMoon;
use density::model::vectorial::Vectorial;
use density::model::{Model, ecliptic};
use density::orbits::Orbits;
use density::problem::{InitialGaussian, Problem};
use density::rare::{Event, Question, importance};
use density::sampling::{Draws, SamplingPlan};
use density::{binning, sampling};
use divan::{Bencher, black_box};
use rayon::ThreadPoolBuilder;

const SAMPLES: usize = 100_000;
/// Numbers of threads for each time.
const THREADS: [usize; 2] = [1, 2];
/// The paper's Ngrid: 25 million interpolation points.
const RESOLUTION: usize = 5000;

fn main() {
    divan::main();
}

/// Scenario 1 of the paper.
fn problem() -> Problem {
    let initial =
        InitialGaussian { mean_phi: 2.2069, mean_e: 0.145, sigma_phi: PI / 16.0, sigma_e: 0.025, correlation: 0.0 };
    let force = SrpJ2 { radiation: 0.15, oblateness: 0.40921 };
    Problem { model: force, initial, times: vec![0.0, 0.5, 1.0, 1.5, 2.0], critical_e: 0.6 }
}

fn flow() -> Flow<SrpJ2> {
    Flow::new(problem().model)
}

/// Samples at two years: solar angles, eccentricities, densities and the grid.
struct Cloud {
    orbits: Orbits,
    phi: Vec<f64>,
    e: Vec<f64>,
    n: Vec<f64>,
    grid: Grid,
}

static GRIDS: LazyLock<Vec<Grid>> = LazyLock::new(|| comparison_grids(&problem(), &flow(), 100, 100).unwrap());

static CLOUD: LazyLock<Cloud> = LazyLock::new(|| {
    let problem = problem();
    let start = initial_points(&problem, SAMPLES, Placement::Random, 1).unwrap();
    let mut orbits = Orbits::from_polar(flow(), &start.phi, &start.e);
    orbits.advance_to(2.0).unwrap();
    let (mut phi, mut e) = (vec![0.0; SAMPLES], vec![0.0; SAMPLES]);
    orbits.read_out(&mut phi, &mut e);
    let n = characteristic_densities(&problem.initial, &start.phi, &start.e, orbits.x1(), orbits.x2(), true).unwrap();
    let grid = GRIDS[4];
    phi.iter_mut().for_each(|phi| *phi = grid.fold(*phi));
    Cloud { orbits, phi, e, n, grid }
});

/// Times `work` on a pool with the given number of threads.
fn on_threads<T: Send>(bencher: Bencher, threads: usize, work: impl Fn() -> T + Sync) {
    LazyLock::force(&CLOUD);
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    bencher.bench_local(|| pool.install(&work));
}

/// 1e5 orbits over two years with all four snapshots.
fn propagate(bencher: Bencher, threads: usize, accuracy: Accuracy) {
    let (x1, x2) = sampling::draw(&problem().initial, 1, SAMPLES);
    let flow = Flow { accuracy, ..flow() };
    on_threads(bencher, threads, || {
        let mut orbits = Orbits::new(flow, x1.clone(), x2.clone());
        problem().times.iter().for_each(|&time| orbits.advance_to(time).unwrap());
        orbits
    });
}

#[divan::bench(args = THREADS)]
fn flow_to_1e_6(bencher: Bencher, threads: usize) {
    propagate(bencher, threads, Accuracy::Coarse);
}

#[divan::bench(args = THREADS)]
fn flow_to_1e_9(bencher: Bencher, threads: usize) {
    propagate(bencher, threads, Accuracy::Medium);
}

#[divan::bench(args = THREADS)]
fn flow_to_1e_12(bencher: Bencher, threads: usize) {
    propagate(bencher, threads, Accuracy::Fine);
}

/// The same orbits with the gravity of the Sun and the Moon, whose series come from the equations of motion.
#[divan::bench(args = THREADS)]
fn flow_sun_moon_to_1e_12(bencher: Bencher, threads: usize) {
    let (x1, x2) = sampling::draw(&problem().initial, 1, SAMPLES);
    let flow = Flow::new(SunMoon::at(2.5, problem().model));
    on_threads(bencher, threads, || {
        let mut orbits = Orbits::new(flow, x1.clone(), x2.clone());
        problem().times.iter().for_each(|&time| orbits.advance_to(time).unwrap());
        orbits
    });
}

/// The same orbits in space with the obliquity of the ecliptic, inclined by 0.3 rad.
#[divan::bench(args = THREADS)]
fn flow_vectorial_to_1e_12(bencher: Bencher, threads: usize) {
    let forces = SunMoon::at(2.5, problem().model);
    let model = Vectorial { forces, obliquity: ecliptic::OBLIQUITY_DEGREES.to_radians(), sun_longitude: 1.0 };
    let (x1, x2) = sampling::draw(&problem().initial, 1, SAMPLES);
    let starts = x1.into_iter().zip(x2).enumerate().map(|(k, (x1, x2))| {
        let state = State { x1, x2 };
        model.state(0.0, [state.solar_angle(), state.eccentricity(), 0.3, k as f64])
    });
    let mut columns = vec![Vec::new(); 6];
    starts.for_each(|start| columns.iter_mut().zip(start).for_each(|(column, value)| column.push(value)));
    let flow = Flow::new(model);
    on_threads(bencher, threads, || {
        let mut columns = columns.clone();
        let mut slices: Vec<&mut [f64]> = columns.iter_mut().map(Vec::as_mut_slice).collect();
        problem().times.windows(2).for_each(|pair| flow.carry(&mut slices, pair[0], pair[1]).unwrap());
        columns
    });
}

/// A million samples to all snapshots by a flow map that is made for them, reduced there to bins and sums for the
/// moments.
#[divan::bench(args = THREADS)]
fn mapped_1e6_all_snapshots(bencher: Bencher, threads: usize) {
    const MAPPED: usize = 1_000_000;
    let problem = problem();
    let plan = SamplingPlan { draws: Draws::Independent, seed: 1, replicates: NonZeroUsize::MIN };
    let settings = MapSettings { smallest_share: 1e-3, ..MapSettings::default() };
    on_threads(bencher, threads, || {
        let critical = problem.critical_e;
        let map = FlowMap::new(flow(), problem.initial.into(), &problem.times, Some(critical), &settings).unwrap();
        let mut orbits = MappedOrbits::new(map, 0..MAPPED, Box::new(plan.starts(&problem.initial)));
        let reduced = |(index, grid): (usize, &Grid)| {
            orbits.advance_watching(index, critical).unwrap();
            orbits.reduce(grid, critical).unwrap()
        };
        GRIDS.iter().enumerate().map(reduced).collect::<Vec<_>>()
    });
}

/// A probability of 1.5e-6 from 5,000 orbits.
#[divan::bench(args = THREADS)]
fn rare_event_from_5000_orbits(bencher: Bencher, threads: usize) {
    let problem = problem();
    let question =
        Question { flow: flow(), gaussian: problem.initial.into(), years: 2.0, critical: 0.8086, event: Event::Ever };
    on_threads(bencher, threads, || importance(&question, 5000, 1).unwrap());
}

#[divan::bench(args = THREADS)]
fn draw_1e5(bencher: Bencher, threads: usize) {
    on_threads(bencher, threads, || sampling::draw(&problem().initial, 1, SAMPLES));
}

#[divan::bench(args = THREADS)]
fn read_out_1e5(bencher: Bencher, threads: usize) {
    on_threads(bencher, threads, || {
        let (mut phi, mut e) = (vec![0.0; SAMPLES], vec![0.0; SAMPLES]);
        CLOUD.orbits.read_out(&mut phi, &mut e);
        (phi, e)
    });
}

#[divan::bench(args = THREADS)]
fn first_passage_1e5(bencher: Bencher, threads: usize) {
    let (x1, x2) = sampling::draw(&problem().initial, 1, SAMPLES);
    on_threads(bencher, threads, || first_passage_times(&flow(), &x1, &x2, problem().critical_e, 2.0).unwrap());
}

/// Counting only; `estimate_samples_1e5` also computes moments and their standard errors.
#[divan::bench(args = THREADS)]
fn bin_1e5(bencher: Bencher, threads: usize) {
    on_threads(bencher, threads, || CLOUD.grid.count(&CLOUD.phi, &CLOUD.e));
}

#[divan::bench(args = THREADS)]
fn estimate_samples_1e5(bencher: Bencher, threads: usize) {
    on_threads(bencher, threads, || binning::estimate(&CLOUD.phi, &CLOUD.e, CLOUD.grid, 0.6));
}

#[divan::bench(args = THREADS)]
fn triangulate_1e5(bencher: Bencher, threads: usize) {
    on_threads(bencher, threads, || triangulate(&CLOUD.phi, &CLOUD.e).unwrap());
}

/// The same points with a crate that only triangulates.
#[divan::bench]
fn triangulate_1e5_delaunator(bencher: Bencher) {
    let points: Vec<_> = CLOUD.phi.iter().zip(&CLOUD.e).map(|(&x, &y)| delaunator::Point { x, y }).collect();
    bencher.bench_local(|| delaunator::triangulate(black_box(&points)));
}

/// 25 million interpolation points into 100 x 100 bins.
#[divan::bench(args = THREADS)]
fn raster_25e6(bencher: Bencher, threads: usize) {
    let Cloud { phi, e, n, grid, .. } = &*CLOUD;
    let triangles = triangulate(phi, e).unwrap();
    let points = PointGrid::new(grid, RESOLUTION).unwrap();
    let corner = |row: u32| [phi[row as usize], e[row as usize], n[row as usize]];
    on_threads(bencher, threads, || points.bin_means(triangles.len(), |k| triangles[k].map(corner)));
}

#[divan::bench(args = THREADS)]
fn estimate_hull_1e5(bencher: Bencher, threads: usize) {
    let Cloud { phi, e, n, grid, .. } = &*CLOUD;
    on_threads(bencher, threads, || hull_estimate(phi, e, n, grid, RESOLUTION, Branch::Grid, 0.6).unwrap());
}

/// All snapshots of a carried lattice.
fn estimate_carried(bencher: Bencher, threads: usize, count: usize) {
    let problem = problem();
    let start = initial_points(&problem, count, Placement::Lattice, 0).unwrap();
    let mut orbits = Orbits::from_polar(flow(), &start.phi, &start.e);
    let snapshots: Vec<(Vec<f64>, Vec<f64>)> = (problem.times.iter())
        .map(|&time| {
            orbits.advance_to(time).unwrap();
            let (mut phi, mut e) = (start.phi.clone(), start.e.clone());
            orbits.read_out(&mut phi, &mut e);
            (phi, e)
        })
        .collect();
    on_threads(bencher, threads, || {
        let mesh = CarriedMesh::new(&problem.initial, &start.phi, &start.e, start.lattice, 7).unwrap();
        let estimate = |((phi, e), grid): (&(Vec<f64>, Vec<f64>), &Grid)| mesh.estimate(phi, e, grid, 0.6).unwrap();
        snapshots.iter().zip(GRIDS.iter()).map(estimate).collect::<Vec<_>>()
    });
}

#[divan::bench(args = THREADS)]
fn estimate_carried_961_all_snapshots(bencher: Bencher, threads: usize) {
    estimate_carried(bencher, threads, 961);
}

#[divan::bench(args = THREADS)]
fn estimate_carried_1e5_all_snapshots(bencher: Bencher, threads: usize) {
    estimate_carried(bencher, threads, SAMPLES);
}

#[divan::bench(args = THREADS)]
fn plan_and_propagate_mixture(bencher: Bencher, threads: usize) {
    let problem = problem();
    on_threads(bencher, threads, || {
        let mut propagator =
            PlanarMixturePropagator::new(&problem, &flow(), &mixture::MixtureSettings::default()).unwrap();
        problem.times.iter().for_each(|&time| propagator.advance_to(time).unwrap());
        propagator.mixture()
    });
}

#[divan::bench(args = THREADS)]
fn estimate_mixture_all_snapshots(bencher: Bencher, threads: usize) {
    let problem = problem();
    let mut propagator = PlanarMixturePropagator::new(&problem, &flow(), &mixture::MixtureSettings::default()).unwrap();
    let mixtures: Vec<_> = (problem.times.iter())
        .map(|&time| {
            propagator.advance_to(time).unwrap();
            propagator.mixture().components
        })
        .collect();
    on_threads(bencher, threads, || {
        let estimate = |(mixture, grid): (&Vec<_>, &Grid)| mixture::estimate(mixture, grid, 0.6).unwrap();
        mixtures.iter().zip(GRIDS.iter()).map(estimate).collect::<Vec<_>>()
    });
}

#[divan::bench(args = THREADS)]
fn exact_all_snapshots(bencher: Bencher, threads: usize) {
    let problem = problem();
    on_threads(bencher, threads, || {
        let (flow, settings) = (flow(), ExactSettings::default());
        let exact = Exact::new(&problem, &flow, settings);
        (0..GRIDS.len()).map(|index| exact.snapshot(&GRIDS, index).unwrap()).collect::<Vec<_>>()
    });
}

/// A state is read out so often that its time is measured separately.
#[divan::bench]
fn solar_angle(bencher: Bencher) {
    let state = State { x1: 0.1, x2: -0.3 };
    bencher.bench_local(|| black_box(state).solar_angle());
}

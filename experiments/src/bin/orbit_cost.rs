//! What an orbit costs in each model: CPU time on one thread, to 1e-12 over two years, for the cloud of the paper's
//! scenario 1.
//!
//! ```sh
//! cargo run --release -p phasecloud-experiments --bin orbit_cost
//! ```

use density::flow::Flow;
use density::model::osculating::Osculating;
use density::model::planar::SrpJ2;
use density::model::shadow::{ShadowedOsculating, ShadowedVectorial};
use density::model::sun_moon::SunMoon;
use density::model::uncertain_radiation::{Linear, UncertainRadiation};
use density::model::vectorial::Vectorial;
use density::model::{Coordinates, Model, ecliptic};
use density::problem::InitialGaussian;
use density::sampling;
use rustix::time::{ClockId, clock_gettime};

/// Number of orbits, fewer than a thread takes at a time.
const ORBITS: usize = 1000;
const YEARS: f64 = 2.0;
/// Each time is the least of this many.
const REPEATS: usize = 3;

fn main() {
    let force = SrpJ2 { radiation: 0.15, oblateness: 0.40921 };
    let forces = SunMoon::at(2.5, force);
    let obliquity = ecliptic::OBLIQUITY_DEGREES.to_radians();
    let initial =
        InitialGaussian { mean_phi: 2.2069, mean_e: 0.145, sigma_phi: 0.19635, sigma_e: 0.025, correlation: 0.0 };
    let (x1, x2) = sampling::draw(&initial, 1, ORBITS);
    let starts: Vec<[f64; 2]> = x1.iter().zip(&x2).map(|(x1, x2)| [x1.atan2(*x2), x1.hypot(*x2)]).collect();
    let planar = time(force, &starts);
    println!("{:36} {planar:9.2} µs", "planar");
    let own = UncertainRadiation::<Linear, _>::new(SrpJ2 { radiation: 0.0, ..force });
    let with_own: Vec<[f64; 3]> = starts.iter().map(|&[phi, e]| [phi, e, force.radiation]).collect();
    let vectorial = Vectorial { forces, obliquity, sun_longitude: 1.0 };
    let flat = Vectorial { obliquity: 0.0, ..vectorial };
    let osculating = Osculating { semi_major_axis: 2.5, forces, obliquity, sun_longitude: 1.0, moon_longitude: 0.0 };
    let in_plane: Vec<[f64; 4]> = starts.iter().map(|&[phi, e]| [phi, e, 0.0, 0.0]).collect();
    let in_space: Vec<[f64; 4]> = starts.iter().map(|&[phi, e]| [phi, e, 0.3, 2.0]).collect();
    let elements: Vec<[f64; 6]> = starts.iter().map(|&[phi, e]| [phi, e, 0.3, 2.0, phi, 2.5]).collect();
    let shadowed = ShadowedVectorial { model: vectorial, semi_major_axis: 2.5, reentry_radius: None };
    let unaveraged = ShadowedOsculating { model: osculating, has_shadow: true, reentry_radius: None };
    let with_axis: Vec<[f64; 5]> = in_space.iter().map(|&[phi, e, i, node]| [phi, e, i, node, 2.5]).collect();
    for (name, time) in [
        ("planar, each with a C of its own", time(own, &with_own)),
        ("planar, Sun and Moon", time(forces, &starts)),
        ("vectorial, the same orbits", time(flat, &in_plane)),
        ("vectorial, inclined, with obliquity", time(vectorial, &in_space)),
        ("the same, with the Earth's shadow", time(shadowed, &with_axis[..100])),
        ("osculating, inclined, with obliquity", time(osculating, &elements[..32])),
        ("the same, with the Earth's shadow", time(unaveraged, &elements[..32])),
    ] {
        println!("{name:36} {time:9.2} µs, {:.1} times as much", time / planar);
    }
}

/// CPU time for each orbit \[µs\].
fn time<M: Model>(model: M, starts: &[M::Variables]) -> f64 {
    let flow = Flow::new(model);
    let count = M::State::<f64>::COUNT;
    let states: Vec<M::State<f64>> = starts.iter().map(|&start| model.state(0.0, start)).collect();
    let once = || {
        let mut columns: Vec<Vec<f64>> =
            (0..count).map(|k| states.iter().map(|state| state.component(k)).collect()).collect();
        let mut slices: Vec<&mut [f64]> = columns.iter_mut().map(Vec::as_mut_slice).collect();
        let before = seconds();
        flow.carry(&mut slices, 0.0, YEARS).expect("orbits of the paper's cloud stay below e = 1");
        seconds() - before
    };
    (0..REPEATS).map(|_| once()).fold(f64::INFINITY, f64::min) * 1e6 / starts.len() as f64
}

/// CPU time of the process \[s\].
fn seconds() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

//! What the exact answer costs at long horizons, and how accurate it is there.
//!
//! `cargo run --release -p phasecloud-experiments --bin exact_horizons` prints, for the paper's scenarios at 2, 30 and
//! 100 years, CPU seconds and error estimates of the moments, of the joint density on 100 x 100 bins, and of the
//! first-passage curve at 65 times. `--years Y` does one horizon, `--scenario N` one scenario. `--check N` compares the
//! mean and the deviation of `e` with a trapezoidal rule over `N x N` orbits that are propagated one by one, within
//! eight deviations of the mean and above `e = 0`.

mod common;

use std::error::Error;

use common::{cpu_of, paper};
use density::exact::{Exact, ExactSettings};
use density::first_passage::curve_times;
use density::first_passage::exact::exact_curve;
use density::flow::Flow;
use density::grid::comparison_grids;
use density::orbits::Orbits;
use density::problem::Problem;

/// Mean and standard deviation of the eccentricity by a trapezoidal rule over orbits.
fn by_orbits(problem: &Problem, years: f64, count: usize) -> Result<(f64, f64), Box<dyn Error>> {
    let initial = &problem.initial;
    let node = |k: usize| 16.0 * (k as f64 / (count - 1) as f64 - 0.5);
    let points = (0..count * count).map(|i| (node(i / count), node(i % count)));
    let (places, weights): (Vec<(f64, f64)>, Vec<f64>) = points
        .map(|(u, v)| (initial.point(u, v), (-0.5 * (u * u + v * v)).exp()))
        .filter(|((_, e), _)| *e > 0.0)
        .unzip();
    let (phi, mut e): (Vec<f64>, Vec<f64>) = places.into_iter().unzip();
    let mut orbits = Orbits::from_polar(Flow::new(problem.model), &phi, &e);
    orbits.advance_to(years)?;
    orbits.read_out(&mut phi.clone(), &mut e);
    let mean_of = |f: &dyn Fn(f64) -> f64| {
        let sum: f64 = weights.iter().zip(&e).map(|(w, &e)| w * f(e)).sum();
        sum / weights.iter().sum::<f64>()
    };
    let mean = mean_of(&|e| e);
    Ok((mean, mean_of(&|e| (e - mean).powi(2)).sqrt()))
}

fn main() -> Result<(), Box<dyn Error>> {
    let (mut horizons, mut scenarios, mut check) = (vec![2.0, 30.0, 100.0], vec![1, 2, 3], None);
    let mut arguments = std::env::args().skip(1);
    while let Some(key) = arguments.next() {
        let value = arguments.next().ok_or_else(|| format!("{key} needs a value"))?;
        match key.as_str() {
            "--years" => horizons = vec![value.parse()?],
            "--scenario" => scenarios = vec![value.parse()?],
            "--check" => check = Some(value.parse()?),
            _ => return Err(format!("{key} is unknown; --years, --scenario and --check are known").into()),
        }
    }
    println!(
        "| scenario | years | moments, s | error | orbits | P(e > 0.6), error | all with joint, s | L1 error | curve, s | error |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for number in scenarios {
        for &years in &horizons {
            let problem = paper(number, vec![0.0, years]);
            let flow = Flow::new(problem.model);
            let exact = Exact::new(&problem, &flow, ExactSettings::default());
            let (moment_seconds, moments) = cpu_of(|| exact.moments(years));
            let moments = moments?;
            if let Some(count) = check {
                let (mean, deviation) = by_orbits(&problem, years, count)?;
                let off = (moments.mean_e - mean).abs().max((moments.std_e - deviation).abs()) / deviation;
                println!("scenario {number}, {years} yr: off by {off:.1e}, {:.1e} expected", moments.e_error);
                continue;
            }
            let grids = comparison_grids(&problem, &flow, 100, 100)?;
            let (all_seconds, snapshot) = cpu_of(|| exact.snapshot(&grids, 1));
            let snapshot = snapshot?;
            let times = curve_times(years, 65);
            let (curve_seconds, curve) = cpu_of(|| exact_curve(&problem, &flow, &times));
            let worst = curve?.iter().map(|p| p.error).fold(0.0, f64::max);
            println!(
                "| {number} | {years} | {moment_seconds:.3} | {:.1e} | {} | {:.1e} | {all_seconds:.2} | {:.1e} | {curve_seconds:.3} | {worst:.1e} |",
                moments.error, moments.orbits, snapshot.probability_error, snapshot.joint_error
            );
        }
    }
    Ok(())
}

//! How far DEE and GMM-UT are off in scenarios of all kinds, beside what they say of themselves: the measurements behind the
//! thresholds of `density::trust`.
//!
//! `cargo run --release -p phasecloud-density --example trust_report -- [scenarios] [first seed] [points a side]`; every row
//! names its seed. The right values are sums over `side²` orbits spread evenly over the initial Gaussian, which share no code
//! with any method but the integrator.
#![allow(missing_docs)]

use std::f64::consts::{PI, TAU};

use density::dynamics::Force;
use density::estimate::{Moments, weighted_moments};
use density::first_passage::{curve_times, passage_times};
use density::flow::Flow;
use density::grid::{Grid, comparison_grids};
use density::mesh::passage::passage_curve;
use density::mesh::{CarriedMesh, Placement, initial_points};
use density::mixture::{self, Propagator};
use density::orbits::Orbits;
use density::problem::{InitialGaussian, Problem};
use density::trust::{Kind, TOLERANCE, trust};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn random(seed: u64) -> Problem {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut between = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
    let force = Force { radiation: between(0.01f64.ln(), 3f64.ln()).exp(), oblateness: between(0.0, 2.0) };
    let initial = InitialGaussian {
        mean_phi: between(0.0, TAU),
        mean_e: between(0.005f64.ln(), 0.9f64.ln()).exp(),
        sigma_phi: between(0.005f64.ln(), 1.5f64.ln()).exp(),
        sigma_e: between(1e-4f64.ln(), 0.1f64.ln()).exp(),
    };
    let critical_e = between(0.2, 0.95);
    let horizon = between(0.1f64.ln(), 10f64.ln()).exp();
    Problem { force, initial, times: vec![0.0, 0.3 * horizon, horizon], critical_e }
}

/// Orbits spread evenly over the initial Gaussian, with their weights.
fn even(initial: &InitialGaussian, side: usize) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let reach = 6.5;
    let (mut phi, mut e, mut weights) = (vec![], vec![], vec![]);
    let low = (-reach * initial.sigma_e + initial.mean_e).max(0.0);
    let high = (reach * initial.sigma_e + initial.mean_e).min(1.0);
    for i in 0..side {
        let u = reach * (2.0 * (i as f64 + 0.5) / side as f64 - 1.0);
        for j in 0..side {
            let here = low + (high - low) * (j as f64 + 0.5) / side as f64;
            let v = (here - initial.mean_e) / initial.sigma_e;
            let weight = (-0.5 * (u * u + v * v)).exp();
            if weight > 1e-10 {
                phi.push(initial.mean_phi + u * initial.sigma_phi);
                e.push(here);
                weights.push(weight);
            }
        }
    }
    let total: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|weight| *weight /= total);
    (phi, e, weights)
}

struct Right {
    moments: Vec<Moments>,
    joints: Vec<Vec<f64>>,
    ever: Vec<f64>,
}

fn right(problem: &Problem, grids: &[Grid], side: usize) -> Option<Right> {
    let flow = Flow::new(problem.force);
    let (mut phi, mut e, weights) = even(&problem.initial, side);
    let mut orbits = Orbits::from_polar(flow, &phi, &e);
    let end = *problem.times.last()?;
    let passages = passage_times(&flow, &orbits.x1, &orbits.x2, problem.critical_e, end).ok()?;
    let ever = |time: f64| passages.iter().zip(&weights).filter(|(t, _)| **t <= time).map(|(_, w)| w).sum();
    let ever = curve_times(end, 65).into_iter().map(ever).collect();
    let (mut moments, mut joints) = (vec![], vec![]);
    for (&time, grid) in problem.times.iter().zip(grids) {
        orbits.advance_to(time).ok()?;
        orbits.read_out(&mut phi, &mut e);
        moments.push(weighted_moments(&phi, &e, Some(&weights), problem.critical_e).0);
        let mut joint = vec![0.0; grid.len()];
        for ((&phi, &e), &weight) in phi.iter().zip(&e).zip(&weights) {
            if let Some(bin) = grid.bin(phi, e) {
                joint[bin] += weight;
            }
        }
        joints.push(joint);
    }
    Some(Right { moments, joints, ever })
}

/// Largest error of means and deviations in standard deviations.
fn off(found: &Moments, right: &Moments) -> f64 {
    let phi = density::angle::nearest(found.mean_phi - right.mean_phi, 0.0).abs() / right.std_phi;
    let deviations = [found.std_phi / right.std_phi - 1.0, found.std_e / right.std_e - 1.0];
    deviations.into_iter().chain([(found.mean_e - right.mean_e) / right.std_e]).fold(phi, |a, b| a.max(b.abs()))
}

fn variation(joint: &[f64], right: &[f64], area: f64) -> f64 {
    0.5 * joint.iter().zip(right).map(|(p, q)| (p * area - q).abs()).sum::<f64>()
}

fn report(seed: u64, problem: &Problem, side: usize) {
    let flow = Flow::new(problem.force);
    let Ok(grids) = comparison_grids(problem, &flow, 100, 100) else { return println!("{seed} lost") };
    let Some(right) = right(problem, &grids, side) else { return println!("{seed} lost") };
    let times = curve_times(*problem.times.last().unwrap(), 65);
    let row = |name: &str, time: f64, moments: f64, joint: f64, above: f64, kind: Kind, says: [f64; 4]| {
        let verdict = trust(kind, says, TOLERANCE);
        let wrong = (verdict.moments() && moments > TOLERANCE) || (verdict.density() && joint > TOLERANCE);
        println!(
            "{seed} {name} t={time:.3} moments {moments:.1e} tv {joint:.1e} above {above:.1e} says {} {:?}{}",
            says.map(|x| format!("{x:.1e}")).join(" "),
            verdict,
            if wrong { " WRONG" } else { "" }
        );
    };
    for count in [961, 100_000] {
        let name = format!("dee-{count}");
        let began = std::time::Instant::now();
        let points = initial_points(problem, count, Placement::Lattice, 0).unwrap();
        let mesh = CarriedMesh::new(&problem.initial, &points.phi, &points.e, points.lattice, 7).unwrap();
        let mut orbits = Orbits::from_polar(flow, &points.phi, &points.e);
        let (mut phi, mut e) = (points.phi.clone(), points.e.clone());
        for (k, (&time, grid)) in problem.times.iter().zip(&grids).enumerate() {
            if let Err(lost) = orbits.advance_to(time) {
                println!("{seed} {name} {lost}");
                break;
            }
            orbits.read_out(&mut phi, &mut e);
            let (found, says) = mesh.estimate(&phi, &e, grid, problem.critical_e).unwrap();
            let joint = variation(&found.joint, &right.joints[k], grid.bin_area());
            let above = (found.moments.prob_above_critical_e - right.moments[k].prob_above_critical_e).abs();
            let says = [says.measure_defect, says.flipped_mass, says.truncated_mass, says.misplaced_mass];
            row(&name, time, off(&found.moments, &right.moments[k]), joint, above, Kind::Mesh, says);
        }
        let middle = began.elapsed().as_secs_f64();
        match passage_curve(problem, &flow, &points, 7, &times) {
            Ok(curve) => {
                let off = |k: usize| (curve.probability[k] - right.ever[k]).abs();
                let worst = (0..times.len()).map(off).fold(0.0, f64::max);
                let over = (0..times.len()).map(|k| off(k) - curve.error[k]).fold(f64::NEG_INFINITY, f64::max);
                let claimed = curve.error.iter().copied().fold(0.0, f64::max);
                let seconds = began.elapsed().as_secs_f64();
                println!(
                    "{seed} {name} passages off {worst:.1e}, beyond their error {over:.1e}, claimed {claimed:.1e}; \
                     {middle:.2} s + {:.2} s",
                    seconds - middle
                );
            }
            Err(error) => println!("{seed} {name} passages: {error}"),
        }
    }
    let began = std::time::Instant::now();
    match Propagator::new(problem, &flow, &mixture::Settings::default()) {
        Err(error) => println!("{seed} gmm-ut {error}"),
        Ok(mut propagator) => {
            for (k, (&time, grid)) in problem.times.iter().zip(&grids).enumerate() {
                propagator.advance_to(time).unwrap();
                let mixture = propagator.mixture();
                let found = mixture::estimate(&mixture.components, grid, problem.critical_e).unwrap();
                let joint = variation(&found.joint, &right.joints[k], grid.bin_area());
                let above = (found.moments.prob_above_critical_e - right.moments[k].prob_above_critical_e).abs();
                let says = [mixture.disagreement(), f64::NAN, f64::NAN, f64::NAN];
                row("gmm-ut", time, off(&found.moments, &right.moments[k]), joint, above, Kind::Mixture, says);
            }
            println!("{seed} gmm-ut {:.2} s", began.elapsed().as_secs_f64());
        }
    }
}

fn main() {
    let numbers: Vec<usize> = std::env::args().skip(1).filter_map(|argument| argument.parse().ok()).collect();
    let number = |k: usize, default| numbers.get(k).copied().unwrap_or(default);
    let (count, first, side) = (number(0, 20), number(1, 1), number(2, 1000));
    for seed in first..first + count {
        let problem = random(seed as u64);
        println!("{seed} {:?} {:?} {:?} {}", problem.force, problem.initial, problem.times, problem.critical_e);
        report(seed as u64, &problem, side);
    }
    if numbers.len() > 3 {
        let paper = Force { radiation: 0.15, oblateness: 0.40921 };
        let near = InitialGaussian { mean_phi: 2.2, mean_e: 0.005, sigma_phi: 0.005, sigma_e: 0.025 };
        let wide = InitialGaussian { mean_phi: 2.2069, mean_e: 0.145, sigma_phi: 0.6, sigma_e: 0.025 };
        let small = InitialGaussian { mean_phi: 2.2069, mean_e: 1e-6, sigma_phi: PI / 16.0, sigma_e: 5e-8 };
        let edge = InitialGaussian { mean_phi: 2.2069, mean_e: 0.02, sigma_phi: 0.1, sigma_e: 0.01 };
        let cases = [
            (Force { radiation: 0.01, oblateness: 0.4 }, near, vec![0.0, 0.05], 0.6),
            (paper, wide, vec![0.0, 0.5, 1.0, 1.5, 2.0], 0.6),
            (paper, small, vec![0.0, 0.5, 1.0, 2.0], 0.6),
            (paper, edge, vec![0.0, 0.1, 1.0, 2.0], 0.6),
            (
                paper,
                InitialGaussian { mean_phi: 0.0, sigma_phi: PI / 16.0, ..wide },
                vec![0.0, 0.5, 1.0, 1.5, 2.0],
                0.6,
            ),
            (paper, InitialGaussian { sigma_phi: PI / 16.0, ..wide }, vec![0.0, 1.0, 2.0, 4.0, 10.0], 0.6),
        ];
        for (seed, (force, initial, times, critical_e)) in cases.into_iter().enumerate() {
            println!("case {seed}");
            report(seed as u64, &Problem { force, initial, times, critical_e }, side);
        }
    }
}

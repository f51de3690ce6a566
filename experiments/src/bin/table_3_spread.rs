//! The paper's DEE over many seeds, beside its Table 3: how much of the difference is chance.
//!
//! `cargo run --release -p phasecloud-experiments --bin table_3_spread -- [seeds] [points]`

#[path = "../../../density/tests/mesh_support/mod.rs"]
mod mesh_support;

use density::mesh::{Branch, Placement, characteristic_densities, hull_estimate};
use mesh_support::{paper_table_3, propagate, scenario};

fn main() {
    let arguments: Vec<usize> = std::env::args().skip(1).filter_map(|text| text.parse().ok()).collect();
    let (seeds, count) = (arguments.first().copied().unwrap_or(20), arguments.get(1).copied().unwrap_or(100_000));
    let method = if count < 10_000 { "dee-961" } else { "dee-1e5" };
    let problem = scenario(1);
    let mut found = vec![Vec::new(); problem.times.len()];
    for seed in 0..seeds {
        let (points, snapshots) = propagate(&problem, count, Placement::Random, seed as u64);
        for (k, s) in snapshots.iter().enumerate() {
            let n = characteristic_densities(&problem.initial, &points.phi, &points.e, &s.x1, &s.x2, false).unwrap();
            let m =
                hull_estimate(&s.phi, &s.e, &n, &s.grid, 5000, Branch::AsPrinted, problem.critical_e).unwrap().moments;
            found[k].push([m.mean_phi, m.std_phi, m.mean_e, m.std_e]);
        }
    }
    println!("t    quantity  paper     mean      std       min       max       paper off in std");
    for (&time, found) in problem.times.iter().zip(&found) {
        for (k, name) in ["mu_phi", "sd_phi", "mu_e", "sd_e"].iter().enumerate() {
            let values: Vec<f64> = found.iter().map(|moments| moments[k]).collect();
            let mean = values.iter().sum::<f64>() / seeds as f64;
            let std = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (seeds as f64 - 1.0)).sqrt();
            let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(l, h), &v| (l.min(v), h.max(v)));
            let paper = paper_table_3(method, time)[k];
            println!(
                "{time:.1}  {name:7} {paper:9.5} {mean:9.5} {std:9.2e} {low:9.5} {high:9.5} {:8.1}",
                (paper - mean) / std
            );
        }
    }
}

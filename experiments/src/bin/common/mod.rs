//! What several examples need: the paper's scenarios, and CPU time.
#![allow(dead_code, reason = "each example uses its own part")]

use std::f64::consts::PI;

use density::model::planar::SrpJ2;
use density::problem::{InitialGaussian, Problem};
use rustix::time::{ClockId, clock_gettime};

/// A scenario of Table 1 of the paper, with snapshots at `times` \[yr\].
pub fn paper(number: usize, times: Vec<f64>) -> Problem {
    let (mean_phi, mean_e, delta_phi, delta_e) = match number {
        1 => (2.2069, 0.145, PI / 8.0, 0.05),
        2 => (0.5419, 0.095, PI / 40.0, 0.01),
        _ => (0.3004, 0.23, PI / 32.0, 0.02),
    };
    let initial =
        InitialGaussian { mean_phi, mean_e, sigma_phi: 0.5 * delta_phi, sigma_e: 0.5 * delta_e, correlation: 0.0 };
    Problem { model: SrpJ2 { radiation: 0.15, oblateness: 0.40921 }, initial, times, critical_e: 0.6 }
}

/// CPU seconds that all threads of the process have taken.
pub fn cpu() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// CPU seconds of all threads that `work` takes, and what it makes.
pub fn cpu_of<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let start = cpu();
    let done = work();
    (cpu() - start, done)
}

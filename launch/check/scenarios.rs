//! The problems that a propagator is checked on.
//!
//! The clouds are so small that even one Gaussian carried by the linearised flow has all moments right to 0.1 standard
//! deviations; no method is judged by how it copes with a bent cloud. Times are uneven, and forces, clouds and numbers
//! of snapshots differ, so that no answer can be right because it is built into the propagator.

use std::f64::consts::TAU;

use density::flow::Flow;
use density::grid::{Axis, Grid, comparison_grids};
use density::model::planar::Force;
use density::model::registry::Planar;
use density::orbits::LostOrbit;
use density::problem::{InitialGaussian, Problem};

/// Bins of the comparison grids, in `phi` and `e`.
const BINS: (usize, usize) = (40, 30);

/// A problem with a name and its comparison grids.
#[derive(Debug, Clone)]
pub struct Scenario {
    /// Its name.
    pub name: &'static str,
    /// The problem.
    pub problem: Problem<Planar>,
    /// The comparison grid of each snapshot.
    pub grids: Vec<Grid>,
}

/// Two problems whose exact answers are known. In the second one the solar angle and the eccentricity are correlated.
pub fn known() -> [Result<Scenario, LostOrbit>; 2] {
    let paper = Force { radiation: 0.15, oblateness: 0.40921 };
    let other = Force { radiation: 0.25, oblateness: 0.2 };
    [
        bounded("check-1", paper, cloud(2.2069, 0.145, 0.005, 0.0008), vec![0.0, 0.3, 0.8, 1.3, 2.0]),
        bounded(
            "check-2",
            other,
            InitialGaussian { correlation: 0.6, ..cloud(0.9, 0.3, 0.005, 0.001) },
            vec![0.0, 0.6, 1.0],
        ),
    ]
}

/// Snapshots of the longest scenario.
pub const LONGEST: usize = 64;

/// The first scenario with far more snapshots.
pub fn long() -> Result<Scenario, LostOrbit> {
    let times = (0..LONGEST as u32).map(|k| 0.5 * f64::from(k)).collect();
    bounded("check-long", Force { radiation: 0.15, oblateness: 0.40921 }, cloud(2.2069, 0.145, 0.005, 0.0008), times)
}

/// Without oblateness the flow turns `(e cos phi, e sin phi, sqrt(1 - e²))` about an axis `atan(C)` away from the last
/// coordinate's, once in `1/sqrt(1 + C²)` yr. Here that is 71.6 degrees and 0.32 yr: the whole cloud leaves `e < 1`.
pub fn impossible() -> Result<Scenario, LostOrbit> {
    let problem = Problem {
        model: Force { radiation: 3.0, oblateness: 0.0 }.into(),
        initial: cloud(0.5, 0.1, 0.01, 0.002),
        times: vec![0.0, 0.2, 0.4],
        critical_e: 0.6,
    };
    let anywhere =
        Grid { phi: Axis { low: 0.0, high: TAU, bins: BINS.0 }, e: Axis { low: 0.0, high: 1.0, bins: BINS.1 } };
    Ok(Scenario { name: "check-impossible", grids: vec![anywhere; problem.times.len()], problem })
}

fn cloud(mean_phi: f64, mean_e: f64, sigma_phi: f64, sigma_e: f64) -> InitialGaussian {
    InitialGaussian { mean_phi, mean_e, sigma_phi, sigma_e, correlation: 0.0 }
}

fn bounded(name: &'static str, force: Force, initial: InitialGaussian, times: Vec<f64>) -> Result<Scenario, LostOrbit> {
    let problem = Problem { model: Planar::from(force), initial, times, critical_e: 0.5 };
    let grids = comparison_grids(&problem, &Flow::new(problem.model), BINS.0, BINS.1)?;
    Ok(Scenario { name, problem, grids })
}

//! Random scenarios, and how they are written down.

use std::f64::consts::TAU;

use std::fmt;

use density::model::planar::SrpJ2;
use density::problem::{InitialGaussian, Problem};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A scenario of the campaign.
#[derive(Debug, Clone)]
pub struct Scenario {
    /// `random-SEED-INDEX`.
    pub name: String,
    /// The problem to be solved.
    pub problem: Problem,
}

/// Scenario number `index` of the campaign `seed`; it depends only on these two numbers.
pub fn draw(seed: u64, index: u64) -> Scenario {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(index);
    let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    let radiation = rounded(between(0.01f64.ln(), 3f64.ln()).exp());
    let oblateness = rounded(between(0.0, 2.0));
    let mean_phi = rounded(between(0.0, TAU));
    let mean_e = rounded(between(0.005, 0.9));
    let delta_phi = rounded(2.0 * between(0.005f64.ln(), 1.5f64.ln()).exp());
    let delta_e = rounded(2.0 * between(1e-4f64.ln(), 0.1f64.ln()).exp());
    let critical_e = rounded(between(0.2, 0.95));
    let horizon = rounded(between(0.1f64.ln(), 30f64.ln()).exp());
    let (one, other) = (between(0.02, 0.49), between(0.5, 0.98));
    let initial =
        InitialGaussian { mean_phi, mean_e, sigma_phi: 0.5 * delta_phi, sigma_e: 0.5 * delta_e, correlation: 0.0 };
    let times = vec![0.0, rounded(one * horizon), rounded(other * horizon), horizon];
    let problem = Problem { model: SrpJ2 { radiation, oblateness }, initial, times, critical_e };
    Scenario { name: format!("random-{seed}-{index}"), problem }
}

/// Rounds to five digits, so that a scenario is short to write down.
fn rounded(x: f64) -> f64 {
    format!("{x:.4e}").parse().unwrap_or(x)
}

impl fmt::Display for Scenario {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Problem { model: force, initial, times, critical_e } = &self.problem;
        let InitialGaussian { mean_phi, mean_e, sigma_phi, sigma_e, .. } = initial;
        write!(
            f,
            "C {:.4} W {:.4} phi {mean_phi:.3} +- {sigma_phi:.4} e {mean_e:.4} +- {sigma_e:.5}, critical e {critical_e:.3}, {:.2} yr",
            force.radiation,
            force.oblateness,
            times.last().copied().unwrap_or(0.0)
        )
    }
}

impl Scenario {
    /// The scenario as a file that phasecloud reads.
    pub fn to_toml(&self) -> String {
        let Problem { model: force, initial, times, critical_e } = &self.problem;
        format!(
            "name = \"{}\"\n[orbit]\nradiation = {:?}\noblateness = {:?}\n[initial]\nphi = {:?}\ne = {:?}\n\
             delta_phi = {:?}\ndelta_e = {:?}\n[times]\nat = {times:?}\n[disposal]\ncritical_e = {critical_e:?}\n",
            self.name,
            force.radiation,
            force.oblateness,
            initial.mean_phi,
            initial.mean_e,
            2.0 * initial.sigma_phi,
            2.0 * initial.sigma_e,
        )
    }

    /// Reads the text that [`Scenario::to_toml`] writes, and the cases beside these tests.
    pub fn from_toml(text: &str) -> Option<Self> {
        let value = |key: &str| {
            text.lines()
                .filter_map(|line| line.split_once('='))
                .find(|(name, _)| name.trim() == key)
                .map(|(_, v)| v.trim())
        };
        let number = |key: &str| value(key)?.parse::<f64>().ok();
        let times =
            value("at")?.trim_matches(['[', ']']).split(',').map(|t| t.trim().parse().ok()).collect::<Option<_>>()?;
        let initial = InitialGaussian {
            mean_phi: number("phi")?,
            mean_e: number("e")?,
            sigma_phi: 0.5 * number("delta_phi")?,
            sigma_e: 0.5 * number("delta_e")?,
            correlation: 0.0,
        };
        let force = SrpJ2 { radiation: number("radiation")?, oblateness: number("oblateness")? };
        let problem = Problem { model: force, initial, times, critical_e: number("critical_e")? };
        Some(Self { name: value("name")?.trim_matches('"').into(), problem })
    }
}

//! The scenarios of `reference/planar.json`, of which another program computed moments and probabilities by quadrature
//! over the initial Gaussian and, where it is uncertain, the radiation parameter.
#![allow(dead_code, reason = "each test file uses its own part")]

use std::f64::consts::PI;

use density::model::registry::Planar;
use density::problem::{InitialGaussian, Problem};
use serde_json::Value;

/// The reference values of one snapshot.
pub struct Snapshot {
    pub years: f64,
    /// Means and standard deviations of the solar angle and the eccentricity, and their covariance.
    pub moments: [f64; 5],
    /// The probability of an eccentricity above the critical one.
    pub above: f64,
    /// The probability of having reached it by this time.
    pub ever: f64,
}

fn of(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key}"))
}

fn entry(name: &str) -> Value {
    let all: Value = serde_json::from_str(include_str!("../reference/planar.json")).unwrap();
    all[name].clone()
}

/// The problem with the mean radiation parameter, and what the reference says of it.
pub fn scenario(name: &str) -> (Problem<Planar>, Vec<Snapshot>) {
    let this = entry(name);
    let or_zero = |key: &str| this["scenario"][key].as_f64().unwrap_or(0.0);
    let given = |key: &str| of(&this["scenario"], key);
    let parameters = [("radiation", "C"), ("oblateness", "W"), ("sun", "A"), ("moon", "B")];
    let model = Planar::by_name("planar-sun-moon", &parameters.map(|(name, key)| (name, or_zero(key)))).unwrap();
    let initial = InitialGaussian {
        mean_phi: given("phi0"),
        mean_e: given("e0"),
        sigma_phi: given("sigma_phi"),
        sigma_e: given("sigma_e"),
        correlation: or_zero("rho"),
    };
    let snapshots: Vec<Snapshot> = (this["snapshots"].as_array().unwrap().iter())
        .map(|row| Snapshot {
            years: of(row, "t"),
            moments: ["mean_phi", "std_phi", "mean_e", "std_e", "cov"].map(|key| of(row, key)),
            above: of(row, "p_above"),
            ever: of(row, "p_ever"),
        })
        .collect();
    let times = snapshots.iter().map(|snapshot| snapshot.years).collect();
    (Problem::new(model, initial, times, given("e_cri")).unwrap(), snapshots)
}

/// The relative standard deviation of the radiation parameter.
pub fn relative_deviation_of_radiation(name: &str) -> f64 {
    of(&entry(name)["scenario"], "sigma_C_rel")
}

/// The largest difference of moments in standard deviations or products of them.
pub fn apart(found: [f64; 5], expected: [f64; 5]) -> f64 {
    let [_, phi, _, e, _] = expected;
    let turn = (found[0] - expected[0] + PI).rem_euclid(2.0 * PI) - PI;
    let differences = [turn / phi, (found[1] - expected[1]) / phi, (found[2] - expected[2]) / e];
    let rest = [(found[3] - expected[3]) / e, (found[4] - expected[4]) / (phi * e)];
    differences.into_iter().chain(rest).fold(0.0, |largest: f64, x| largest.max(x.abs()))
}

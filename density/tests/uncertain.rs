//! Tests of every method where the radiation parameter is uncertain.
//!
//! The reference is moments and probabilities that another program computed by quadrature over the initial Gaussian and the parameter.

use std::f64::consts::PI;

use density::exact::ExactSettings;
use density::exact::leaves::ExactLeaves;
use density::first_passage::over_leaves::curve;
use density::flow::Accuracy;
use density::model::registry::Planar;
use density::problem::{InitialGaussian, Problem};
use density::uncertain::{Distribution, Spread, UncertainProblem};
use serde_json::Value;

struct Snapshot {
    years: f64,
    moments: [f64; 5],
    above: f64,
    ever: f64,
}

fn scenario(name: &str) -> (UncertainProblem, Vec<Snapshot>) {
    let all: Value = serde_json::from_str(include_str!("reference/planar.json")).unwrap();
    let this = &all[name];
    let of = |value: &Value, key: &str| value[key].as_f64().unwrap();
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
    let plane = Problem::new(model, initial, times, given("e_cri")).unwrap();
    let spread = Spread { relative: given("sigma_C_rel"), distribution: Distribution::Gaussian };
    (UncertainProblem::new(plane, spread).unwrap(), snapshots)
}

/// The largest difference of moments in standard deviations or products of them.
fn apart(found: [f64; 5], expected: [f64; 5]) -> f64 {
    let [_, phi, _, e, _] = expected;
    let turn = (found[0] - expected[0] + PI).rem_euclid(2.0 * PI) - PI;
    let differences = [turn / phi, (found[1] - expected[1]) / phi, (found[2] - expected[2]) / e];
    let rest = [(found[3] - expected[3]) / e, (found[4] - expected[4]) / (phi * e)];
    differences.into_iter().chain(rest).fold(0.0, |largest: f64, x| largest.max(x.abs()))
}

/// The reference is good to 1e-5 (a mean of `e` is up to 30 deviations). In `uncertain-3` its 41 values of the parameter are too few by two
/// years, when part of the cloud has passed the saddle: by the same quadrature the covariance changes by 6e-4 of the deviations' product from 41
/// to 81 values, and by 1.3e-4 from 81 to 161. Those times are left out.
#[test]
fn the_exact_density_has_the_moments_and_probabilities_of_the_reference() {
    for (name, times) in [("uncertain-1", [0.5, 2.0]), ("uncertain-3", [0.5, 1.0])] {
        let (problem, snapshots) = scenario(name);
        let exact = ExactLeaves::new(problem, Accuracy::Fine, ExactSettings::default());
        for snapshot in snapshots.iter().filter(|snapshot| times.contains(&snapshot.years)) {
            let (found, above, third) = exact.moments(snapshot.years).unwrap();
            let moments = [found.mean_phi, found.std_phi, found.mean_e, found.std_e, found.cov_phi_e];
            let difference = apart(moments, snapshot.moments);
            assert!(difference < 3e-5, "{name} at {}: {difference:e}", snapshot.years);
            assert!(found.error < 3e-5, "{name} at {}: {:e}", snapshot.years, found.error);
            assert!((above.value - snapshot.above).abs() < 1e-5, "{name} at {}", snapshot.years);
            assert!(third.with_e.is_finite() && third.deviation > 0.0);
        }
    }
}

/// The reference is good to 1e-5, and said to be to 5e-5 for the cliff, where the two differ by 9e-5; which of
/// them is off is not known.
#[test]
fn the_exact_first_passages_are_those_of_the_reference() {
    for (name, tolerance, years) in [("uncertain-1", 1e-5, 2.0), ("uncertain-3", 1e-5, 1.5), ("cliff", 1e-4, 6.0)] {
        let (problem, snapshots) = scenario(name);
        let times: Vec<f64> = problem.plane.times.iter().copied().filter(|&time| time <= years).collect();
        let (mean, deviation) = problem.third();
        let exact = ExactLeaves::new(problem, Accuracy::Medium, ExactSettings::default());
        let found = curve(&exact, &times).unwrap();
        for (passed, snapshot) in found.iter().zip(&snapshots) {
            let difference = (passed.probability.value - snapshot.ever).abs();
            let tolerance = tolerance + passed.probability.error;
            assert!(difference < tolerance, "{name} at {}: {difference:e}", snapshot.years);
            // The law of total expectation, and of total variance.
            let p = passed.probability.value;
            let (yes, no) = (passed.radiation_if_passed, passed.radiation_if_not);
            if (1e-3..0.999).contains(&p) {
                let total = p * yes.0 + (1.0 - p) * no.0;
                let within = p * yes.1.powi(2) + (1.0 - p) * no.1.powi(2);
                let between = p * (1.0 - p) * (yes.0 - no.0).powi(2);
                assert!((total / mean - 1.0).abs() < 1e-9, "{name} at {}", snapshot.years);
                assert!(((within + between).sqrt() / deviation - 1.0).abs() < 1e-6, "{name} at {}", snapshot.years);
                assert!(yes.0 > no.0, "who re-enters has a stronger pull");
            }
        }
    }
}

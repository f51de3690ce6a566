//! Tests of every method where the radiation parameter is uncertain.
//!
//! The reference is moments and probabilities that another program computed by quadrature over the initial Gaussian and
//! the parameter.

mod planar_reference;

use std::num::NonZeroUsize;

use density::exact::ExactSettings;
use density::exact::leaves::ExactLeaves;
use density::first_passage::given::Given;
use density::first_passage::over_leaves::curve;
use density::first_passage::passage_times;
use density::flow::{Accuracy, Flow};
use density::sampling::{Draws, SamplingPlan};
use density::uncertain::{Distribution, Spread, UncertainProblem};
use planar_reference::{Snapshot, apart};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn scenario(name: &str) -> (UncertainProblem, Vec<Snapshot>) {
    let (plane, snapshots) = planar_reference::scenario(name);
    let relative = planar_reference::relative_deviation_of_radiation(name);
    (UncertainProblem::new(plane, Spread { relative, distribution: Distribution::Gaussian }).unwrap(), snapshots)
}

/// The reference is good to 1e-5 (a mean of `e` is up to 30 deviations). In `uncertain-3` its 41 values of the
/// parameter are too few by two years, when part of the cloud has passed the saddle: by the same quadrature the
/// covariance changes by 6e-4 of the deviations' product from 41 to 81 values, and by 1.3e-4 from 81 to 161. Those
/// times are left out.
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

/// The reference is good to 1e-5. Its "cliff" is judged by the test below, since the reference is 9e-5 off there.
#[test]
fn the_exact_first_passages_are_those_of_the_reference() {
    for (name, years) in [("uncertain-1", 2.0), ("uncertain-3", 1.5), ("cliff", 3.0)] {
        let (problem, snapshots) = scenario(name);
        let times: Vec<f64> = problem.plane.times.iter().copied().filter(|&time| time <= years).collect();
        let (mean, deviation) = problem.third();
        let exact = ExactLeaves::new(problem, Accuracy::Medium, ExactSettings::default());
        let found = curve(&exact, &times).unwrap();
        for (passed, snapshot) in found.iter().zip(&snapshots) {
            let difference = (passed.probability.value - snapshot.ever).abs();
            let tolerance = 1e-5 + passed.probability.error;
            assert!(difference < tolerance, "{name} at {}: {difference:e}", snapshot.years);
            // The law of total expectation, and of total variance.
            let p = passed.probability.value;
            let of = |given: Given| (given.mean.value, given.deviation.value);
            let (yes, no) = (of(passed.radiation_if_passed), of(passed.radiation_if_not));
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

/// Mean and standard error of the probability of ever re-entering, by counting orbits: a trapezoid rule with a random
/// offset over the radiation parameter, and a scrambled Sobol sample of its own for each value.
fn counted(problem: &UncertainProblem, years: f64, replicates: u64) -> (f64, f64) {
    const VALUES: usize = 64;
    const ORBITS: usize = 256;
    const WIDEST: f64 = 6.0;
    let step = 2.0 * WIDEST / VALUES as f64;
    let mut random = ChaCha8Rng::seed_from_u64(15);
    let probabilities: Vec<f64> = (0..replicates)
        .map(|replicate| {
            let offset: f64 = random.random();
            let (mut passed, mut weights) = (0.0, 0.0);
            for value in 0..VALUES {
                let z = (value as f64 + offset) * step - WIDEST;
                let Some(leaf) = problem.leaf(z) else { continue };
                let seed = replicate * VALUES as u64 + value as u64;
                let plan = SamplingPlan { draws: Draws::Sobol, seed, replicates: NonZeroUsize::MIN };
                let (x1, x2) = plan.draw(&leaf.initial, ORBITS);
                let times = passage_times(&Flow::new(leaf.model), &x1, &x2, leaf.critical_e, years).unwrap();
                let share = times.iter().filter(|&&time| time <= years).count() as f64 / ORBITS as f64;
                let weight = (-0.5 * z * z).exp();
                passed += weight * share;
                weights += weight;
            }
            passed / weights
        })
        .collect();
    let count = replicates as f64;
    let mean = probabilities.iter().sum::<f64>() / count;
    let variance = probabilities.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

/// `PHASECLOUD_CLIFF=256` counts in 256 replicates instead of 12.
#[test]
#[ignore = "long; .ci/long runs it"]
fn the_probability_on_the_cliff_is_that_of_orbits_that_are_counted() {
    let replicates = std::env::var("PHASECLOUD_CLIFF").map_or(12, |text| text.parse().unwrap());
    let (problem, _) = scenario("cliff");
    let (expected, standard_error) = counted(&problem, 6.0, replicates);
    let exact = ExactLeaves::new(problem, Accuracy::Medium, ExactSettings::default());
    let found = curve(&exact, &[6.0]).unwrap()[0].probability;
    println!("counted {expected:.7} with a standard error of {standard_error:.1e}, exact {:.7}", found.value);
    assert!(standard_error < 1e-4, "{standard_error:e}");
    assert!((found.value - expected).abs() < 4.0 * standard_error + found.error, "{expected} {found:?}");
}

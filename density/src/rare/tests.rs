//! Both methods against a probability in closed form and against the exact tails in the plane.

use super::*;
use crate::exact::{Estimated, Exact, ExactSettings};
use crate::first_passage::exact::exact_curve;
use crate::model::planar::SrpJ2;
use crate::model::sun_moon::SunMoon;
use crate::model::vectorial::Vectorial;
use crate::problem::paper::scenario;
use crate::problem::{InitialGaussian, Problem};

/// Orbits of an estimate.
const ORBITS: usize = 5000;

fn question(problem: &Problem, critical: f64, event: Event) -> Question<SrpJ2, 2> {
    let years = *problem.times.last().unwrap();
    Question { flow: Flow::new(problem.model), gaussian: problem.initial.into(), years, critical, event }
}

fn exact(problem: &Problem, critical: f64, event: Event) -> Estimated {
    let problem = Problem { critical_e: critical, ..problem.clone() };
    let (flow, years) = (Flow::new(problem.model), *problem.times.last().unwrap());
    match event {
        Event::Ever => exact_curve(&problem, &flow, &[0.0, years]).unwrap()[1],
        Event::AtEnd => {
            Exact::new(&problem, &flow, ExactSettings::default()).probability_above(critical, years).unwrap()
        }
    }
}

/// Events of the paper's scenarios with probabilities from 4e-3 to 1e-9.
const EVENTS: [(usize, f64, Event); 8] = [
    (1, 0.8064, Event::Ever),
    (1, 0.8086, Event::Ever),
    (3, 0.4629, Event::Ever),
    (3, 0.6, Event::Ever),
    (1, 0.4643, Event::AtEnd),
    (1, 0.54, Event::AtEnd),
    (2, 0.4, Event::AtEnd),
    (3, 0.6, Event::AtEnd),
];

#[test]
fn importance_sampling_meets_the_exact_tails_within_its_own_standard_errors() {
    for (number, critical, event) in EVENTS {
        let problem = scenario(number);
        let right = exact(&problem, critical, event);
        let answer = importance(&question(&problem, critical, event), ORBITS, 1);
        println!("scenario {number}, e {critical} {event:?}: {answer:?}, exact {right:?}");
        let answer = answer.unwrap();
        let off = (answer.probability - right.value).abs();
        assert!(off < 4.0 * answer.standard_error + right.error, "{number} {critical} {event:?}");
        assert!(answer.standard_error < 0.1 * answer.probability && answer.orbits <= ORBITS);
    }
}

#[test]
fn subset_simulation_meets_the_exact_tails_within_its_own_standard_errors() {
    for (number, critical, event) in EVENTS {
        let problem = scenario(number);
        let right = exact(&problem, critical, event);
        let answer = subset(&question(&problem, critical, event), 1000, 1).unwrap();
        println!("scenario {number}, e {critical} {event:?}: {answer:?}, exact {:e}", right.value);
        let deviations = (answer.probability / right.value).ln() * answer.probability / answer.standard_error;
        assert!(deviations.abs() < 4.0, "{number} {critical} {event:?}: {deviations}");
    }
}

/// Number of seeds: 40, or PHASECLOUD_SEEDS.
fn seeds() -> u64 {
    std::env::var("PHASECLOUD_SEEDS").ok().map_or(40, |text| text.parse().expect("a number"))
}

/// How many of the intervals of so many seeds hold the exact probability, the largest relative standard error, and the
/// spread of the logarithm of the estimate.
fn coverage(right: f64, seeds: u64, answer: impl Fn(u64) -> Result<Answer, Refused>) -> (u64, f64, f64) {
    let (mut held, mut worst, mut squares) = (0, 0.0f64, 0.0);
    for seed in 0..seeds {
        // A seed without an answer holds nothing.
        let Ok(answer) = answer(seed) else { continue };
        held += u64::from(answer.interval.0 <= right && right <= answer.interval.1);
        worst = worst.max(answer.standard_error / answer.probability);
        squares += (answer.probability / right).ln().powi(2);
    }
    (held, worst, (squares / seeds as f64).sqrt())
}

/// Fails if intervals hold the exact probability less often than 95 % ones do, or more often.
fn check_coverage(held: u64, seeds: u64) {
    // Four standard deviations of the count below its mean; at 200 seeds the count itself is to lie from 180 to 198.
    let mean = 0.95 * seeds as f64;
    let least = if seeds >= 200 { 0.9 * seeds as f64 } else { mean - 4.0 * (0.05 * mean).sqrt() };
    assert!(held as f64 >= least, "{held} of {seeds}");
    assert!(seeds < 200 || held as f64 <= 0.99 * seeds as f64, "{held} of {seeds}");
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn the_interval_of_importance_sampling_holds_the_exact_probability_in_95_of_100_seeds() {
    let seeds = seeds();
    for (number, critical, event) in
        [(1, 0.8086, Event::Ever), (1, 0.4643, Event::AtEnd), (1, 0.54, Event::AtEnd), (3, 0.6, Event::Ever)]
    {
        let problem = scenario(number);
        let right = exact(&problem, critical, event).value;
        let question = question(&problem, critical, event);
        let (held, worst, spread) = coverage(right, seeds, |seed| importance(&question, ORBITS, seed));
        println!(
            "scenario {number}, e {critical} {event:?}, {right:.3e}: {held} of {seeds}, largest standard error {worst:.3}, spread {spread:.4}"
        );
        check_coverage(held, seeds);
        assert!(worst < 0.1, "a standard error of {worst}");
    }
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn the_interval_of_subset_simulation_holds_the_exact_probability_in_95_of_100_seeds() {
    let seeds = seeds();
    for (number, critical, event) in EVENTS {
        let problem = scenario(number);
        let right = exact(&problem, critical, event).value;
        let question = question(&problem, critical, event);
        let (held, worst, spread) = coverage(right, seeds, |seed| subset(&question, ORBITS / 6, seed));
        println!(
            "scenario {number}, e {critical} {event:?}, {right:.3e}: {held} of {seeds}, largest standard error {worst:.3}, spread {spread:.4}"
        );
        check_coverage(held, seeds);
    }
}

#[test]
fn an_event_that_cannot_happen_is_refused_in_words() {
    let refused = importance(&question(&scenario(1), 0.9, Event::Ever), ORBITS, 1).unwrap_err();
    assert!(refused.to_string().contains("up to 7.5 standard deviations from the mean has the event"), "{refused}");
    let rarer = importance(&question(&scenario(1), 0.5666, Event::AtEnd), ORBITS, 1);
    assert!(matches!(rarer, Err(Refused::TooRare { .. })), "{rarer:?}");
    // What subset simulation finds there rests on few chains, which it says first.
    let rarer = subset(&question(&scenario(1), 0.5666, Event::AtEnd), 1000, 1);
    assert!(matches!(rarer, Err(Refused::TooRare { .. } | Refused::FewChains { .. })), "{rarer:?}");
    let few = importance(&question(&scenario(1), 0.8, Event::Ever), 100, 1).unwrap_err();
    assert!(few.to_string().contains("at least 500 are needed"), "{few}");
}

#[test]
fn the_answer_is_the_same_bytes_for_any_number_of_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let question = question(&scenario(1), 0.8086, Event::Ever);
        pool.install(|| (importance(&question, ORBITS, 7), subset(&question, 500, 7)))
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn a_probability_in_four_dimensions_is_that_in_closed_form() {
    // Nothing moves in no time: the event is that the initial e exceeds a value.
    let forces = SunMoon { force: scenario(1).model, sun: 0.0, moon: 0.0 };
    let model = Vectorial { forces, obliquity: 0.4, sun_longitude: 1.0 };
    let gaussian = Gaussian::independent([2.2, 0.145, 0.5, 1.0], [0.2, 0.025, 0.01, 0.02]);
    let question = Question { flow: Flow::new(model), gaussian, years: 1e-9, critical: 0.27, event: Event::Ever };
    let right = normal_tail(5.0);
    let answer = importance(&question, 10_000, 1).unwrap();
    println!("{answer:?}, exact {right:e}");
    assert!((answer.probability - right).abs() < 4.0 * answer.standard_error);
    assert!(answer.standard_error < 0.1 * right);
}

/// A cloud over the centre, ten years ahead.
fn over_the_centre(sigma_phi: f64) -> Problem {
    let initial = InitialGaussian { mean_phi: 0.0, mean_e: 0.2771, sigma_phi, sigma_e: 0.03, correlation: 0.0 };
    let model = SrpJ2 { radiation: 0.15, oblateness: 0.409 };
    Problem { model, initial, times: vec![0.0, 10.0], critical_e: 0.6 }
}

/// With probabilities of 0.9997 and 0.9987 all of a few hundred orbits have the event in most seeds.
#[test]
fn the_interval_of_a_nearly_certain_event_is_not_empty() {
    let problem = over_the_centre(0.15);
    for critical in [0.278, 0.279] {
        let right = exact(&problem, critical, Event::Ever).value;
        let question = question(&problem, critical, Event::Ever);
        let (held, _, _) = coverage(right, 20, |seed| subset(&question, 833, seed));
        assert!((0.99..1.0).contains(&right) && held >= 17, "{critical}, {right}: {held} of 20");
        let (held, worst, _) = coverage(right, 20, |seed| importance(&question, ORBITS, seed));
        assert!(held >= 17 && worst < 2e-3, "{critical}, {right}: {held} of 20, {worst}");
    }
}

/// An event of 3.6e-7 on an island to which the margin does not lead.
#[test]
fn subset_simulation_says_when_it_has_not_come_to_the_event() {
    let problem = over_the_centre(0.05);
    let right = exact(&problem, 0.47, Event::AtEnd).value;
    let question = question(&problem, 0.47, Event::AtEnd);
    let (mut told, mut missed) = (0, 0);
    for seed in 1..=10 {
        match subset(&question, 833, seed) {
            Ok(answer) => {
                told += 1;
                missed += u32::from(right < answer.interval.0 || answer.interval.1 < right);
            }
            Err(Refused::NotReached { .. } | Refused::FewChains { .. }) => {}
            Err(refused) => panic!("{refused}"),
        }
    }
    println!("exact {right:e}, {told} of 10 seeds told, {missed} missed");
    assert!(missed <= 1, "{missed} of {told}");
    let found = importance(&question, ORBITS, 1).unwrap();
    assert!(found.interval.0 <= right && right <= found.interval.1);
}

//! Compares the oracle of the random campaign with values computed by others, and `exact` with the oracle.

mod campaign_support;
mod common;

use campaign_support::cases::{Known, all};
use campaign_support::judge::{Oracles, judge};
use campaign_support::methods::{Method, run};
use campaign_support::oracle::{Effort, Oracle, Truth, solve};
use campaign_support::paths::{Motion, follow};
use campaign_support::scenario::{Scenario, draw};
use common::{paper, rows};
use density::angle::nearest;
use density::exact::{Exact, ExactSettings};
use density::first_passage::exact::exact_curve;
use density::flow::Flow;
use density::grid::{Axis, Grid, comparison_grids};
use density::model::planar::SrpJ2;
use density::model::plane::State;
use density::problem::Problem;

/// A grid of little cost, for when no density is needed.
fn few_bins(problem: &Problem) -> Vec<Grid> {
    let axis = |low: f64, high: f64| Axis { low, high, bins: 4 };
    vec![Grid { phi: axis(0.0, 6.0), e: axis(0.0, 1.0) }; problem.times.len()]
}

fn quadrature_alone(problem: &Problem, most_levels: usize) -> Oracle {
    let effort = Effort { first: (80, 200), most_levels, most_steps: u64::MAX, ..Effort::QUICK };
    solve(problem, &few_bins(problem), &effort)
}

#[test]
fn the_oracle_has_the_reference_moments_of_the_paper() {
    for number in 1..=3 {
        let problem = paper(number);
        let oracle = quadrature_alone(&problem, 2);
        assert!(oracle.contradictions.is_empty(), "{:?}", oracle.contradictions);
        let scenario = format!("scenario-{number}");
        for (name, row) in rows("exact-moments.csv").into_iter().filter(|(name, _)| *name == scenario) {
            let k = problem.times.iter().position(|time| *time == row[0]).unwrap();
            let truth = &oracle.truths[k];
            for i in 0..5 {
                let off = if i == 0 {
                    nearest(truth.cloud.moments[0] - row[1], 0.0)
                } else {
                    truth.cloud.moments[i] - row[i + 1]
                };
                // The file has nine digits.
                let scale = truth.cloud.scales()[i].max(1e-3 * row[i + 1].abs());
                let off = (off / scale).abs();
                assert!(off < 2e-6 + truth.error.moments[i], "{name} {} {i}: {off:e}", row[0]);
            }
            // The file's probabilities are less accurate than its moments, see `exact.rs`.
            assert!((truth.above - row[6]).abs() < 1e-7, "{name} {}: {:e} {:e}", row[0], truth.above, row[6]);
        }
    }
}

/// Describes every figure that is off by more than it may be.
fn differences(known: &Known, truth: &Truth) -> Vec<String> {
    let mut found = Vec::new();
    let mut compare = |name: &str, off: f64, allowed: f64| {
        if off.is_nan() || off.abs() > allowed {
            found.push(format!("{name} at {} yr is off by {off:.1e}, more than {allowed:.1e}", known.time));
        }
    };
    if let Some(moments) = known.moments {
        let scales = truth.cloud.scales();
        for (i, name) in ["mean_phi", "std_phi", "mean_e", "std_e", "cov_phi_e"].into_iter().enumerate() {
            let off = truth.cloud.moments[i] - moments[i];
            let off = if i == 0 { nearest(off, 0.0) } else { off };
            compare(name, off / scales[i], known.moment_error + truth.error.moments[i]);
        }
    }
    if let Some(resultant) = known.resultant {
        let [sin, cos] = truth.cloud.vector;
        compare("resultant", sin.hypot(cos) - resultant, known.moment_error + truth.error.vector);
    }
    let probabilities = [(known.above, truth.above, truth.error.above), (known.ever, truth.ever, truth.error.ever)];
    for (i, (value, found, error)) in probabilities.into_iter().enumerate() {
        if let Some(value) = value {
            compare(["p_above", "p_ever"][i], found - value, known.probability_error[i] + error);
        }
    }
    found
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn the_oracle_has_the_values_of_the_cases() {
    for (scenario, known) in all() {
        let oracle = quadrature_alone(&scenario.problem, 2);
        // An oracle that does not know a figure cannot contradict it.
        let knows = |truth: &Truth| truth.error.moments.iter().all(|e| *e < 0.05) && truth.error.ever < 0.02;
        if !oracle.truths.iter().all(knows) {
            // Two refinements are not enough for a cloud that a saddle has pulled apart for ten years.
            assert_eq!(scenario.name, "saddle");
            continue;
        }
        let problem = &scenario.problem;
        let at = |time: f64| problem.times.iter().position(|t| *t == time).map(|k| &oracle.truths[k]);
        let found: Vec<String> =
            known.iter().filter_map(|known| Some(differences(known, at(known.time)?))).flatten().collect();
        assert!(
            found.is_empty() && oracle.contradictions.is_empty(),
            "{} {found:#?} {:?}",
            scenario.name,
            oracle.contradictions
        );
    }
}

#[test]
fn the_oracles_orbits_are_those_of_the_flow() {
    let forces = [(0.15, 0.40921), (0.034, 0.33), (1.5, 0.4), (2.9, 1.7), (0.3, 0.0)];
    for (radiation, oblateness) in forces {
        let force = SrpJ2 { radiation, oblateness };
        let starts: Vec<[f64; 2]> = (0..40).map(|i| [0.7 * f64::from(i), 0.015 * f64::from(i) + 0.01]).collect();
        let paths = follow(Motion { force, most_steps: 2_000 }, &starts, &[0.0, 0.3, 2.0]);
        for (i, &[phi, e]) in starts.iter().enumerate() {
            let Ok(end) = Flow::new(force).advance_one(State::from_polar(phi, e), 2.0) else { continue };
            let off = (paths.x1[2][i] - end.x1).hypot(paths.x2[2][i] - end.x2);
            assert!(off < 1e-9, "{force:?} {phi} {e}: {off:e}");
        }
    }
}

#[test]
fn the_largest_eccentricity_on_the_way_is_that_of_a_close_look() {
    let force = SrpJ2 { radiation: 0.4, oblateness: 0.8 };
    let starts: Vec<[f64; 2]> = (0..16).map(|i| [0.4 * f64::from(i), 0.03 * f64::from(i) + 0.02]).collect();
    let fine: Vec<f64> = (0..=3000).map(|k| f64::from(k) * 1e-3).collect();
    let motion = Motion { force, most_steps: 10_000 };
    let (paths, closely) = (follow(motion, &starts, &[0.0, 3.0]), follow(motion, &starts, &fine));
    for i in 0..starts.len() {
        let seen = closely.x1.iter().zip(&closely.x2).map(|(x1, x2)| x1[i].powi(2) + x2[i].powi(2)).fold(0.0, f64::max);
        assert!(paths.peak[1][i] >= seen - 1e-14 && paths.peak[1][i] < seen + 1e-3, "{i} {seen} {}", paths.peak[1][i]);
    }
}

#[test]
fn a_scenario_survives_being_written_down() {
    let scenario = draw(3, 17);
    let read = Scenario::from_toml(&scenario.to_toml()).unwrap();
    assert_eq!((read.problem, read.name), (scenario.problem, scenario.name));
}

/// Figures of the cases that `exact` may withhold, by case, name and time; it must withhold no others.
const BEYOND_EXACT: &[(&str, &str, f64)] = &[];

#[test]
#[ignore = "long; .ci/long runs it"]
fn exact_has_the_values_of_the_cases() {
    let (mut wrong, mut withheld) = (Vec::new(), Vec::new());
    for (scenario, known) in all() {
        let problem = &scenario.problem;
        let flow = Flow::new(problem.model);
        let grids = comparison_grids(problem, &flow, 10, 10).unwrap();
        let exact = Exact::new(problem, &flow, ExactSettings::default());
        let curve = exact_curve(problem, &flow, &problem.times).unwrap();
        for known in &known {
            let k = problem.times.iter().position(|time| *time == known.time).unwrap();
            let found = exact.snapshot(&grids, k).unwrap().estimate.moments.to_array();
            let mut compare = |name: &'static str, off: f64, allowed: f64| {
                if off.is_nan() {
                    withheld.push((scenario.name.clone(), name, known.time));
                } else if off.abs() > allowed {
                    wrong.push(format!("{} {name} at {} yr is off by {off:.1e}", scenario.name, known.time));
                }
            };
            if let Some(right) = known.moments {
                let scales = [right[1], right[1], right[3], right[3], right[1] * right[3]];
                for (i, name) in ["mean_phi", "std_phi", "mean_e", "std_e", "cov_phi_e"].into_iter().enumerate() {
                    let off = found[i] - right[i];
                    let off = if i == 0 { nearest(off, 0.0) } else { off };
                    compare(name, off / scales[i], known.moment_error);
                }
            }
            if let Some(above) = known.above {
                compare("p_above", found[5] - above, known.probability_error[0]);
            }
            if let Some(ever) = known.ever {
                compare("p_ever", curve[k].value - ever, known.probability_error[1]);
            }
        }
    }
    let is_expected = |(case, name, time): &(String, &str, f64)| BEYOND_EXACT.contains(&(case.as_str(), name, *time));
    withheld.retain(|figure| !is_expected(figure));
    assert!(wrong.is_empty() && withheld.is_empty(), "wrong: {wrong:#?}\nwithheld: {withheld:?}");
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn exact_is_silently_wrong_in_no_case_by_the_oracle() {
    for (scenario, _) in all() {
        let problem = &scenario.problem;
        let grids = comparison_grids(problem, &Flow::new(problem.model), 25, 25).unwrap();
        let oracle = solve(problem, &grids, &Effort::QUICK);
        let verdict = judge(problem, &run(Method::Exact, problem, &grids), &oracle, true);
        let wrong: Vec<String> =
            verdict.silently_wrong().map(|figure| format!("{}, {}", figure.name, figure.detail)).collect();
        assert!(wrong.is_empty(), "{}: {wrong:#?}", scenario.name);
    }
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn exact_is_not_refused_for_the_side_of_zero_on_which_the_mean_of_a_symmetric_cloud_lies() {
    // Once mixed along its orbits, the cloud is symmetric about phi = 0: its circular mean is 0 or just below 2π.
    let mut problem = draw(1, 35).problem;
    let end = problem.times[problem.times.len() - 1];
    problem.times = (0..=8).map(|k| end - 0.25 * f64::from(8 - k)).collect();
    problem.times[0] = 0.0;
    let flow = Flow::new(problem.model);
    let grids = comparison_grids(&problem, &flow, 10, 10).unwrap();
    let exact = Exact::new(&problem, &flow, ExactSettings::default());
    for k in 1..problem.times.len() {
        let found = exact.snapshot(&grids, k).unwrap().estimate;
        let (mean, circular) = (found.moments.mean_phi, found.circular.mean);
        assert!((mean - circular).abs() < std::f64::consts::PI, "{mean} {circular}");
    }
}

/// Scenarios of this test's campaign; `cargo run --release -p phasecloud-experiments --bin campaign` runs any number.
const SCENARIOS: u64 = 15;
const SEED: u64 = 20_261_127;

/// Number of scenarios, from the first, on which all methods but `dee-1e5` are tried; on the others only the cheap ones
/// are.
const WITH_ALL_METHODS: u64 = 6;

#[test]
#[ignore = "long; .ci/long runs it"]
fn no_method_is_silently_wrong_in_a_random_scenario() {
    let mut wrong = Vec::new();
    for index in 0..SCENARIOS {
        let scenario = draw(SEED, index);
        let problem = &scenario.problem;
        let Ok(grids) = comparison_grids(problem, &Flow::new(problem.model), 25, 25) else { continue };
        let mut oracles = Oracles::new(problem, &grids, &Effort::QUICK);
        let names =
            if index < WITH_ALL_METHODS { &["exact", "gmm-ut", "dee-961", "mc"][..] } else { &["exact", "gmm-ut"] };
        for method in names.iter().filter_map(|name| Method::named(name)) {
            let verdict = oracles.judge(&run(method, problem, &grids), method == Method::Exact);
            let figures = verdict.silently_wrong();
            let words = figures.map(|figure| format!("{}: {}, {}", method.name(), figure.name, figure.detail));
            wrong.extend(words.map(|words| format!("{words}\n{}", scenario.to_toml())));
        }
    }
    assert!(wrong.is_empty(), "seed {SEED}: {} figures\n{}", wrong.len(), wrong.join("\n"));
}

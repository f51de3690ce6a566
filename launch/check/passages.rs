//! Whether a first-passage curve agrees with orbits of our own, the initial cloud, and its sender's own snapshots.

use density::first_passage::empirical::empirical_curve;
use density::first_passage::times::first_passage_times;
use density::flow::Flow;
use density::in_space::disposal::{self, Effort, REPLICATES};
use density::sampling::{Draws, SamplingPlan};
use kit::assignment::Assignment;
use messages::layout::PassageHeader;
use nodes::services::passage_rules::{breach, curve_in, doubts, rows};
use nodes::services::reading::Reading;

use super::amount::to_within;
use super::answer::Received;

/// Number of our own orbits, drawn as a Sobol sequence: the probabilities of their curve are good to [`OWN_ERROR`].
const ORBITS: usize = 16_384;
/// Tolerated error of the probabilities of our own curve.
const OWN_ERROR: f64 = 0.005;
/// Tolerated error of probabilities that do not come from counting samples.
const GENEROUS: f64 = 0.1;
/// Tolerated error of probabilities that come from counting samples, in standard errors.
const SIGMAS: f64 = 5.0;

/// Judges a curve that breaks no rule by itself; `snapshots` are the figures of the same propagator's snapshots.
///
/// # Errors
/// What is wrong with it.
pub fn judge(
    assignment: &Assignment,
    Received { header, items }: &Received<PassageHeader>,
    snapshots: &[Reading],
) -> Result<String, String> {
    let items = &curve_in(header, items);
    if items.is_empty() || breach(items).is_some() {
        return Ok(String::new()); // there is no curve, or it has been judged already
    }
    let snapshots: Vec<&Reading> = snapshots.iter().collect();
    if let Some(doubt) = doubts(items, header.samples, assignment, &snapshots).into_iter().next() {
        return Err(doubt);
    }
    let right = own_curve(assignment)?;
    let mut worst = 0.0f64;
    for (row, right) in rows(items).into_iter().zip(right) {
        let allowed = match header.samples {
            0 => GENEROUS,
            n => SIGMAS * (2.0 * right * (1.0 - right) / n as f64).sqrt() + 25.0 / n as f64 + OWN_ERROR,
        };
        let off = match row.is_withheld() {
            true => (row.low - right).max(right - row.high),
            false => (row.probability - right).abs(),
        };
        if off > allowed {
            let (time, p) = (row.time, row.probability);
            return Err(format!(
                "the probability is {p:.5} at {time} yr, where {right:.5} of our own orbits have passed"
            ));
        }
        worst = worst.max(off);
    }
    Ok(to_within("right", worst))
}

/// The curve of orbits of our own.
fn own_curve(assignment: &Assignment) -> Result<Vec<f64>, String> {
    let times = assignment.passage_times();
    if let Some(problem) = &assignment.in_space {
        let effort = Effort { orbits: ORBITS / REPLICATES, seed: 1 };
        let curve = disposal::curve(problem, effort, &times);
        let curve = curve.map_err(|why| format!("our own orbits cannot be followed: {why}"))?;
        return Ok(curve.probability.into_iter().map(|p| p.value).collect());
    }
    let problem = &assignment.plane().map_err(|e| e.to_string())?.problem;
    let plan = SamplingPlan { draws: Draws::Sobol, seed: 1, replicates: std::num::NonZeroUsize::MIN };
    let (x1, x2) = plan.draw(&problem.initial, ORBITS);
    let end = times.last().copied().unwrap_or(0.0);
    let passages = first_passage_times(&Flow::new(problem.model), &x1, &x2, problem.critical_e, end);
    let passages = passages.map_err(|why| format!("our own orbits cannot be followed: {why}"))?;
    Ok(empirical_curve(&passages, None, &times).probability)
}

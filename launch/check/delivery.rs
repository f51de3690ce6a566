//! Rules about what was sent: who, how many, in which order, when, and whether the numbers are finite.

use density::first_passage::curve_times;
use kit::assignment::Assignment;
use kit::breach;
use kit::snapshot_rules::breaches;
use messages::content::Content;
use messages::layout::{GIVEN_COLUMNS, PASSAGE_COLUMNS, PASSAGE_TIMES, PassageHeader, SnapshotHeader};
use messages::text::unpack;
use nodes::services::passage_rules::{breach, curve_in};

use super::answer::{Answer, LABEL, Received};
use super::verdict::{Findings, Rule};

/// Judges all messages that a propagator sent about a scenario.
pub fn judge(findings: &mut Findings, answer: &Answer) {
    let name = &answer.assignment.description.name;
    let snapshots = &answer.heard.snapshots;
    if answer.outcome.is_done() {
        let (sent, right) = (snapshots.len(), answer.assignment.times.len());
        let seen = format!("{name}: {sent} of {right}");
        findings.take(Rule::Count, if sent == right { Ok(seen) } else { Err(seen) });
    }
    if snapshots.is_empty() {
        return;
    }
    let broken: Vec<Rule> = snapshots
        .iter()
        .enumerate()
        .flat_map(|(k, snapshot)| judge_snapshot(findings, &answer.assignment, k, snapshot))
        .collect();
    let rules = [Rule::Identity, Rule::Order, Rule::Times, Rule::Shape, Rule::Finite, Rule::Eccentricity];
    for rule in rules.into_iter().filter(|rule| !broken.contains(rule)) {
        findings.good(rule, format!("{name}: {} snapshots", snapshots.len()));
    }
    if answer.outcome.is_done() && answer.heard.passages.is_empty() {
        findings.take(Rule::FirstPassage, Err(format!("{name}: no message on phasecloud/passage")));
    }
    for passage in &answer.heard.passages {
        let result = judge_passage(&answer.assignment, passage).map_err(|problem| format!("{name}: {problem}"));
        findings.take(Rule::FirstPassage, result.map(|seen| format!("{name}: {seen}")));
    }
}

/// Judges one snapshot and returns which rules it breaks.
fn judge_snapshot(
    findings: &mut Findings,
    assignment: &Assignment,
    k: usize,
    Received { header, items }: &Received<SnapshotHeader>,
) -> Vec<Rule> {
    let mut problems: Vec<(Rule, String)> = breaches(header, items, assignment, k)
        .into_iter()
        .map(|breach| {
            let rule = match breach.rule {
                breach::Rule::Identity => Rule::Identity,
                breach::Rule::Count => Rule::Count,
                breach::Rule::Order => Rule::Order,
                breach::Rule::Time => Rule::Times,
                breach::Rule::Shape => Rule::Shape,
                breach::Rule::Finite => Rule::Finite,
                breach::Rule::Range => Rule::Eccentricity,
            };
            (rule, breach.what)
        })
        .collect();
    if unpack(&header.label) != LABEL {
        problems.push((Rule::Identity, format!("its label is \"{}\", not \"{LABEL}\"", unpack(&header.label))));
    }
    let shape_is_right = problems.iter().all(|(rule, _)| *rule != Rule::Shape && *rule != Rule::Finite);
    if shape_is_right && let Ok(Content::Mixture(_)) = header.content() {
        let means = items.chunks_exact(header.rows as usize).nth(2).unwrap_or_default();
        if let Some(row) = means.iter().position(|e| !(0.0..1.0).contains(e)) {
            problems.push((Rule::Eccentricity, format!("component {row} has mean e = {}, outside [0, 1)", means[row])));
        }
    }
    for (rule, what) in &problems {
        findings.problem(*rule, format!("{}, snapshot {k}: {what}", assignment.description.name));
    }
    problems.into_iter().map(|(rule, _)| rule).collect()
}

fn judge_passage(
    assignment: &Assignment,
    Received { header, items }: &Received<PassageHeader>,
) -> Result<String, String> {
    let signed = (header.run_id, header.scenario) == (assignment.description.run_id, assignment.scenario());
    if !signed || unpack(&header.label) != LABEL {
        let label = unpack(&header.label);
        return Err(format!("it is signed \"{label}\", run {:012x}, scenario {}", header.run_id, header.scenario));
    }
    if header.rows == 0 {
        let reason = unpack(&header.reason);
        return if reason.is_empty() { Err("neither a curve nor a reason".into()) } else { Ok("a reason".into()) };
    }
    let columns = PASSAGE_COLUMNS + if header.given == 0 { 0 } else { GIVEN_COLUMNS };
    if header.rows as usize != PASSAGE_TIMES || items.len() != PASSAGE_TIMES * columns {
        return Err(format!("{} rows and {} numbers, not {PASSAGE_TIMES} rows", header.rows, items.len()));
    }
    let end = assignment.times.last().copied().unwrap_or(0.0);
    let curve = curve_in(header, items);
    for (row, time) in curve.chunks_exact(PASSAGE_COLUMNS).zip(curve_times(end, PASSAGE_TIMES)) {
        let &[t, ..] = row else { continue };
        let off = (t - time).abs();
        if off.is_nan() || off > 1e-9 * end {
            return Err(format!("a row is at {t} yr, not at {time} yr"));
        }
    }
    match breach(&curve) {
        Some(what) => Err(what),
        None => Ok("a curve".into()),
    }
}
